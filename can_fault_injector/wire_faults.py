"""Faults of CAN_H and CAN_L from a model of their voltages: what each node of the bit model still sees.

Nodes hang on a line of two conductors with a terminating resistor at both ends (ISO 11898-2). A dominant transmitter
pulls CAN_H up and CAN_L down through its output stage, all receivers bias both conductors to half the supply. The
network is resistive and settles within the bit; edges, reflections and dominant time-outs are not in it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import NDArray

SUPPLY_V, BATTERY_V = 5.0, 13.5
RECESSIVE_V = SUPPLY_V / 2
TERMINATION_OHM = 120.0
OUTPUT_OHM = 45.0
"""Of one output stage: 3.5 V and 1.5 V at the nominal load of 60 ohm."""
INPUT_OHM = 30_000.0
"""From each conductor of a receiver to its bias; ISO 11898-2 allows 6 to 50 kilo-ohm."""
LINE_OHM = 0.5
CONTACT_OHM = 0.5
THRESHOLD_V = 0.7
"""A receiver takes a higher difference for dominant; ISO 11898-2 asks for a decision between 0.5 V and 0.9 V."""
_SURE_RECESSIVE_V, _SURE_DOMINANT_V = 0.5, 0.9
_RECESSIVE_LIMITS_V = (2.0, 3.0)
"""Of each conductor; outside, the bus has no reserve against noise and ground shift."""
_COMMON_MODE_V = 12.0

Conductor = Literal["can_h", "can_l"]
_CONDUCTORS: tuple[Conductor, ...] = ("can_h", "can_l")
_SHORTS = {"ground": 0.0, "battery": BATTERY_V, "supply": SUPPLY_V}
FAULTS = (
    "can_h_open",
    "can_l_open",
    "both_open",
    "can_h_to_can_l",
    *(f"{conductor}_to_{voltage}" for conductor in _CONDUCTORS for voltage in _SHORTS),
)
"""Names of the wire faults, those of `error_frames.WIRES`."""


@dataclass(frozen=True)
class Line:
    """Nodes along a line.

    Parameters
    ----------
    nodes : sequence of str
        In the order of the line.
    terminated : sequence of str, optional
        Nodes at which a terminating resistor sits; both ends by default. A node that is no end of the terminated line
        hangs on a stub.
    """

    nodes: Sequence[str]
    terminated: Sequence[str] | None = None

    @property
    def terminators(self) -> tuple[str, ...]:
        """Nodes with a terminating resistor."""
        return (self.nodes[0], self.nodes[-1]) if self.terminated is None else tuple(self.terminated)


@dataclass(frozen=True)
class Levels:
    """Voltages and levels for every set of dominant nodes.

    Attributes
    ----------
    can_h, can_l : float64 arrays (2 ** nodes, nodes) [V]
        Row: bit i is set if node i drives dominant.
    seen : uint8 array (2 ** nodes, nodes)
        0 where the node sees dominant; what `Bus.connect` takes.
    """

    can_h: NDArray[np.float64]
    can_l: NDArray[np.float64]
    seen: NDArray[np.uint8]

    @property
    def difference(self) -> NDArray[np.float64]:
        """CAN_H less CAN_L, V."""
        return self.can_h - self.can_l

    @property
    def in_limits(self) -> NDArray[np.bool_]:
        """For each node whether all voltages are as ISO 11898-2 wants them.

        Decisions are sure (below 0.5 V or above 0.9 V), recessive conductors lie at 2 V to 3 V, none beyond 12 V.
        """
        difference = self.difference
        sure = np.all((difference < _SURE_RECESSIVE_V) | (difference > _SURE_DOMINANT_V), axis=0)
        low, high = _RECESSIVE_LIMITS_V
        resting = np.stack([self.can_h[0], self.can_l[0]])
        common_mode = np.maximum(np.abs(self.can_h), np.abs(self.can_l)).max(axis=0)
        return sure & np.all((resting > low) & (resting < high), axis=0) & (common_mode < _COMMON_MODE_V)


def _faulty_conductors(fault: str) -> tuple[Conductor, ...]:
    return tuple(conductor for conductor in _CONDUCTORS if fault.startswith((conductor, "both")))


class _Network:
    """Conductances between the points of a line; point 2k is CAN_H, 2k + 1 CAN_L of node k."""

    def __init__(self, count: int) -> None:
        self.matrix = np.zeros((2 * count, 2 * count))
        self.current = np.zeros(2 * count)

    def connect(self, a: int, b: int, ohm: float) -> None:
        self.matrix[[a, b], [a, b]] += 1.0 / ohm
        self.matrix[[a, b], [b, a]] -= 1.0 / ohm

    def source(self, point: int, voltage: float, ohm: float) -> None:
        self.matrix[point, point] += 1.0 / ohm
        self.current[point] += voltage / ohm

    def copy(self) -> "_Network":
        other = _Network(self.current.size // 2)
        other.matrix, other.current = self.matrix.copy(), self.current.copy()
        return other

    def voltages(self) -> NDArray[np.float64]:
        return np.asarray(np.linalg.solve(self.matrix, self.current), np.float64)


def _passive_parts(line: Line, fault: str | None, before: int) -> _Network:
    """The line with its fault between node ``before`` - 1 and node ``before``, and all receivers."""
    network = _Network(len(line.nodes))
    broken = _faulty_conductors(fault) if fault is not None and fault.endswith("open") else ()
    for k in range(len(line.nodes)):
        for offset, conductor in enumerate(_CONDUCTORS):
            network.source(2 * k + offset, RECESSIVE_V, INPUT_OHM)
            if k and not (k == before and conductor in broken):
                network.connect(2 * k - 2 + offset, 2 * k + offset, LINE_OHM)
        if line.nodes[k] in line.terminators:
            network.connect(2 * k, 2 * k + 1, TERMINATION_OHM)
    if fault == "can_h_to_can_l":
        network.connect(2 * before, 2 * before + 1, CONTACT_OHM)
    elif fault is not None and not broken:
        shorted, _, voltage = fault.partition("_to_")
        network.source(2 * before + (shorted == "can_l"), _SHORTS[voltage], CONTACT_OHM)
    return network


def _with_drivers(passive: _Network, dominant: Sequence[bool]) -> NDArray[np.float64]:
    """Voltages with output stages on; each has a diode, so that it only pulls CAN_H up and CAN_L down."""
    stages = {(k, side) for k, on in enumerate(dominant) if on for side in (0, 1)}
    while True:
        network = passive.copy()
        for k, side in stages:
            network.source(2 * k + side, 0.0 if side else SUPPLY_V, OUTPUT_OHM)
        voltages = network.voltages()
        blocked = {
            (k, side) for k, side in stages if (voltages[2 * k + side] < 0.0 if side else voltages[2 * k] > SUPPLY_V)
        }
        if not blocked:
            return voltages
        stages -= blocked


def levels(line: Line, fault: str | None = None, before: str | None = None) -> Levels:
    """What every node sees for every set of dominant nodes.

    Parameters
    ----------
    fault : str, optional
        One of ``FAULTS``; none is a sound line.
    before : str, optional
        Node at whose side of the line the fault is: a break is between it and the node before, a short at it. The last
        one by default.

    Raises
    ------
    ValueError
        For unknown faults or nodes, and a break before the first node.
    """
    if fault is not None and fault not in FAULTS:
        raise ValueError(f"wire fault: found {fault!r}, allowed: {', '.join(FAULTS)}")
    place = before or line.nodes[-1]
    if place not in line.nodes:
        raise ValueError(f"node: found {place!r}, allowed: {', '.join(line.nodes)}")
    at = list(line.nodes).index(place)
    if at == 0 and fault is not None and fault.endswith("open"):
        raise ValueError(f"before: found {place!r}, the first node; allowed for a break: {', '.join(line.nodes[1:])}")
    passive = _passive_parts(line, fault, at)
    rows = [_with_drivers(passive, dominant[::-1]) for dominant in product((False, True), repeat=len(line.nodes))]
    voltages = np.array(rows)
    can_h, can_l = voltages[:, 0::2], voltages[:, 1::2]
    return Levels(can_h, can_l, (can_h - can_l <= THRESHOLD_V).astype(np.uint8))


def wiring(line: Line, nodes: Sequence[str], fault: str | None = None, before: str | None = None) -> NDArray[np.uint8]:
    """What `Bus.connect` takes for a bus whose nodes stand in another order than along the line.

    Raises
    ------
    ValueError
        As `levels`, and if the two do not have the same nodes.
    """
    if sorted(nodes) != sorted(line.nodes):
        raise ValueError(f"nodes of the line: found {', '.join(line.nodes)}, allowed: {', '.join(nodes)}")
    seen = levels(line, fault, before).seen
    places = [list(line.nodes).index(name) for name in nodes]
    sets = np.arange(seen.shape[0])
    along_line = np.zeros_like(sets)
    for number, place in enumerate(places):
        along_line |= ((sets >> number) & 1) << place
    return seen[along_line][:, places]
