"""Forms of the attitude filter: which quantities are states, which one is the virtual offset, what noise they expect.

One full vector serves all forms (attitude document 3.3, recommended implementation): a form is a list of its entries
that are states and one entry that every filter of the bank is told; the others stay zero.
"""

from collections.abc import Mapping
from dataclasses import dataclass

THETA, PHI, SPEED, LATERAL_SPEED, B_ROLL, B_YAW, B_PITCH, B_X, B_Y, B_Z = range(10)
ENTRIES = 10
"""Pitch, roll [rad], speeds along x and y [m/s], offsets of gyroscopes [rad/s] and accelerometers [m/s^2]."""

ROW_Y, ROW_Z, ROW_SPEED, ROW_ROLL, ROW_YAW, ROW_PITCH = range(6)
ROWS = 6
"""Measurements: G_y, G_z, speed, balance of the roll moment, of the yaw moment, of the pitch moment."""

NONE = -1
ACCELEROMETER = {"x": B_X, "y": B_Y, "z": B_Z}


@dataclass(frozen=True)
class Form:
    """A form of the filter.

    Attributes
    ----------
    states : tuple of int
        Entries of the full vector that the filters estimate.
    virtual : int
        Entry that they are told; ``NONE`` for the comparison device, which has no bank.
    rows : tuple of int
        Measurements that it uses.
    car : bool
        Model of the car (document, 6) instead of the two-wheeler.
    loop : bool
        Wheel loads, strokes and elevation angle (blocks 60 to 90) feed the filters.
    measurement : mapping
        Standard deviation of each row (3.5).
    process_speed : float
        Standard deviation of the speed per root second (3.5).
    """

    states: tuple[int, ...]
    virtual: int
    rows: tuple[int, ...]
    measurement: Mapping[int, float]
    process_speed: float
    car: bool = False
    loop: bool = False

    @property
    def pitches(self) -> bool:
        """Whether it knows a pitch gyroscope (second embodiment)."""
        return THETA in self.states


_FIRST = (PHI, SPEED, B_ROLL, B_YAW)
_SECOND = (THETA, PHI, SPEED, B_ROLL, B_YAW, B_PITCH)
_CAR = (THETA, PHI, SPEED, LATERAL_SPEED, B_ROLL, B_YAW, B_PITCH)
_ROWS_1 = (ROW_Y, ROW_Z, ROW_SPEED)
_ROWS_2 = (ROW_Y, ROW_Z, ROW_SPEED, ROW_ROLL)
_FINE = {ROW_Y: 0.03, ROW_Z: 0.03, ROW_SPEED: 0.05}
_MIDDLE = {ROW_Y: 0.1, ROW_Z: 0.1, ROW_SPEED: 0.1, ROW_ROLL: 0.1}
_COARSE = {ROW_Y: 0.5, ROW_Z: 0.5, ROW_SPEED: 0.2, ROW_ROLL: 0.5}
_CAR_NOISE = {ROW_Y: 0.2, ROW_Z: 0.5, ROW_SPEED: 0.1, ROW_ROLL: 0.2, ROW_YAW: 0.2, ROW_PITCH: 0.3}
"""Chosen by the rule of 3.5 on the MuJoCo car; the document's own car had 0.3 (6)."""
_ROWS_CAR = (ROW_Y, ROW_SPEED, ROW_ROLL, ROW_YAW)


def _second(state: int, virtual: int, noise: Mapping[int, float], *, loop: bool) -> Form:
    return Form((*_SECOND, state), virtual, _ROWS_2, noise, 0.05, loop=loop)


def _of_car(virtual: int) -> Form:
    offsets = tuple(entry for entry in (B_X, B_Y, B_Z) if entry != virtual)
    return Form((*_CAR, *offsets), virtual, tuple(range(ROWS)), _CAR_NOISE, 0.05, car=True)


FORMS: dict[str, Form] = {
    "1A": Form((*_FIRST, B_Z), B_Y, _ROWS_1, _FINE, 0.1),
    "1B": Form((*_FIRST, B_Y), B_Z, _ROWS_1, _FINE, 0.1),
    "1C": Form((*_FIRST, B_Z), B_X, _ROWS_1, _MIDDLE, 0.1),
    "1D": Form((*_FIRST, B_Y), B_X, _ROWS_1, _MIDDLE, 0.1),
    "2A": _second(B_Z, B_X, _MIDDLE, loop=True),
    "2B": _second(B_X, B_Z, _COARSE, loop=True),
    "2C": _second(B_X, B_Y, _COARSE, loop=True),
    "2A-light": _second(B_Z, B_X, _MIDDLE, loop=False),
    "2B-light": _second(B_X, B_Z, _COARSE, loop=False),
    "2C-light": _second(B_X, B_Y, _COARSE, loop=False),
    "comparison": Form((*_FIRST, B_Z), NONE, _ROWS_1, _MIDDLE, 0.1),
    "car": Form((PHI, SPEED, LATERAL_SPEED, B_ROLL, B_YAW), B_Y, _ROWS_CAR, _CAR_NOISE, 0.05, car=True),
    "car_x": _of_car(B_X),
    "car_y": _of_car(B_Y),
    "car_z": _of_car(B_Z),
}
"""Forms 1A to 2C of the document (3.2, 3.3), those without blocks 60 to 90, its comparison device, the car of its 6 and
the same car with pitch and all offsets."""
