"""Order in which the modules of tests are dealt out to several workers (``--dist loadscope --no-loadscope-reorder``).

A worker gets a module at a time. The long ones come first, so that no worker is left alone with one at the end, and
those that compile the same come apart, so that the second finds the code of the first in the cache: the two at the head
share none. Modules with tests that need the machine to themselves come last, where nobody waits for them.
"""

from pathlib import Path

import pytest
from alone_on_the_machine import MARK

LONG = (
    "acceptance/test_abs_against_locked.py",  # compiles the bench's loop and the car
    "acceptance/test_attitude_other_offsets.py",  # compiles neither
    "acceptance/test_state_document.py",
    "acceptance/test_attitude_rides.py",
    "model_diagnosis/data/test_small_delays.py",
    "acceptance/test_attitude_extra_state.py",
    "estimators/test_bad_inputs_of_all.py",
    "model_diagnosis/test_localisation.py",
    "acceptance/test_friction_document.py",
    "model_diagnosis/data/test_hidden_data_faults.py",
    "bench/whole_runs/test_physical_faults.py",
    "model_diagnosis/test_diagnosis.py",
    "acceptance/test_in_line_delay.py",
    "acceptance/test_filter_consistency.py",
    "acceptance/test_state_document_grade.py",
    "bench/estimation/test_comparison.py",
)

_HERE = Path(__file__).resolve().parent


class OrderOfModules:
    """Plugin that sorts the collected tests; within a module their order stays."""

    def __init__(self) -> None:
        missing = [name for name in LONG if not (_HERE / name).is_file()]
        if missing:
            raise pytest.UsageError(f"{__file__}: no module {', '.join(missing)}")
        self._places = {_HERE / name: place for place, name in enumerate(LONG)}

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        alone = {item.path for item in items if item.get_closest_marker(MARK)}

        def place(item: pytest.Item) -> int:
            return len(LONG) + 1 if item.path in alone else self._places.get(item.path, len(LONG))

        items.sort(key=place)
