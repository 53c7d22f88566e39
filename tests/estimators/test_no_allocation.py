"""A tick allocates nothing: numba's runtime counts what compiled code takes from the heap."""

from typing import Any

import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys
from test_bad_inputs_of_all import TICKS, build, inputs_of, positions

import estimators
from signals.catalogue import block_slice, index_of


def arrays_in(value: Any) -> int:
    """Arrays in what a tick is called with: a call from Python makes a handle of each."""
    if isinstance(value, np.ndarray):
        return 1
    return sum(arrays_in(item) for item in value) if isinstance(value, tuple) else 0


@pytest.mark.parametrize("name", estimators.names())
def test_a_tick_allocates_nothing_but_the_handles_of_its_arrays(name: str) -> None:
    estimator = build(name)
    columns, _ = inputs_of(name)
    bus, bus_age = block_slice("bus"), block_slice("bus_age")
    inputs, ages = np.zeros((TICKS, bus.stop - bus.start)), np.zeros(bus_age.stop - bus_age.start)
    for signal, values in columns.items():
        inputs[:, index_of(signal) - bus.start] = values
    out = np.zeros(len(estimator.outputs))
    estimator.tick(inputs[0], ages, out)
    handles = arrays_in(estimator.tick.args) + arrays_in((inputs, ages, out))
    _nrt_python.memsys_enable_stats()
    try:
        before = rtsys.get_allocation_stats().alloc
        for row in inputs[1:]:
            estimator.tick(row, ages, out)
        allocated = rtsys.get_allocation_stats().alloc - before
    finally:
        _nrt_python.memsys_disable_stats()
    at = positions(estimator)
    assert "active" not in at or out[at["active"]] == 1.0
    assert allocated == (TICKS - 1) * handles
