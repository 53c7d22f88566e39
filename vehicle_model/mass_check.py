"""Whether masses and inertias of a car leave something for its sprung body; without numpy, as vehicle files use it."""

from collections.abc import Sequence

from signals.errors import FieldError
from vehicle_model.body_file import Axles, Body, Wheel
from vehicle_model.inertias import TRANSVERSE_OVER_SPIN

_INERTIAS = ("roll_inertia", "pitch_inertia", "yaw_inertia")


def check_masses(body: Body, axles: Axles, wheels: Sequence[Wheel]) -> None:
    """Refuse a car whose wheels alone have its mass, or its inertia about one of the axes.

    Parameters
    ----------
    wheels
        In wheel order.

    Raises
    ------
    FieldError
        At ``body.mass`` or the inertia.
    """
    unsprung = sum(wheel.unsprung_mass for wheel in wheels)
    sprung = body.mass - unsprung
    if sprung <= 0.0:
        raise FieldError("not more than the unsprung masses", at=("body", "mass"), allowed=f"more than {unsprung:g} kg")
    to_front = body.centre_of_gravity_to_front_axle
    needed, moment = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
    for number, wheel in enumerate(wheels):
        along = to_front if number < 2 else to_front - body.wheelbase
        half_track = 0.5 * (axles.front if number < 2 else axles.rear).track
        place = (along, half_track if number % 2 == 0 else -half_track, wheel.radius - body.centre_of_gravity_height)
        square = sum(part * part for part in place)
        for axis in range(3):
            own = wheel.inertia if axis == 1 else TRANSVERSE_OVER_SPIN * wheel.inertia
            needed[axis] += own + wheel.unsprung_mass * (square - place[axis] ** 2)
            moment[axis] += wheel.unsprung_mass * place[axis]
    # the sprung body's centre lies where it balances the wheels
    square = sum(part * part for part in moment) / sprung
    for axis, name in enumerate(_INERTIAS):
        least = needed[axis] + square - moment[axis] ** 2 / sprung
        if getattr(body, name) <= least:
            raise FieldError(
                "not more than the wheels alone have", at=("body", name), allowed=f"more than {least:.0f} kg m^2"
            )
