"""Numbers of the car that the observers of the vertical loads use (vertical-load document, section 5)."""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from estimators.vehicle_numbers import GRAVITY_M_S2, required
from estimators.vertical_load_settings import VerticalLoadSettings
from signals.errors import InputError
from signals.wheels import WHEELS

LOAD_CAR = np.dtype(
    [
        ("mass", "f8"),
        ("sprung_mass", "f8"),
        ("yaw_inertia", "f8"),
        ("roll_inertia", "f8"),  # about the roll axis
        ("to_front", "f8"),
        ("to_rear", "f8"),
        ("track", "f8"),
        ("height", "f8"),
        ("roll_centre", "f8"),
        ("roll_arm", "f8"),
        ("roll_stiffness", "f8"),
        ("roll_damping", "f8"),
        ("roll_share", "f8", (2,)),
        ("stiffness", "f8", (2,)),  # of one tyre, front and rear
        ("static_load", "f8", (2,)),  # of the axles
        ("radius", "f8", (4,)),
        ("steering_ratio", "f8"),
        ("gravity_in_acceleration", "f8"),  # g for a sensor that rolls with the body, else 0
    ]
)


def load_car(vehicle: Mapping[str, float], settings: VerticalLoadSettings) -> NDArray[np.void]:
    """Read the car from the numbers of a vehicle file; record of shape (1,), dtype ``LOAD_CAR``.

    Parameters
    ----------
    vehicle : mapping
        Dotted path to SI number.

    Raises
    ------
    InputError
        If a number is missing and nothing stands for it.
    """
    record = np.zeros(1, LOAD_CAR)
    car = record[0]
    car["mass"], car["yaw_inertia"] = required(vehicle, "body.mass"), required(vehicle, "body.yaw_inertia")
    wheelbase = required(vehicle, "body.wheelbase")
    car["to_front"] = required(vehicle, "body.centre_of_gravity_to_front_axle")
    car["to_rear"] = wheelbase - car["to_front"]
    car["track"] = 0.5 * (required(vehicle, "axles.front.track") + required(vehicle, "axles.rear.track"))
    car["height"] = required(vehicle, "body.centre_of_gravity_height")
    car["steering_ratio"] = required(vehicle, "steering.ratio")
    car["radius"] = [required(vehicle, f"wheels.{wheel}.radius") for wheel in WHEELS]
    car["gravity_in_acceleration"] = GRAVITY_M_S2 if settings.accelerometer == "body" else 0.0
    front_share = car["to_rear"] / wheelbase
    weight = car["mass"] * GRAVITY_M_S2
    given = settings.static_load_front, settings.static_load_rear
    shares = front_share, 1.0 - front_share
    car["static_load"] = [weight * share if load is None else load for load, share in zip(given, shares, strict=True)]
    share = settings.front_roll_share
    if share is None:
        share = vehicle.get("two_track.front_roll_share", front_share)
    car["roll_share"] = share, 1.0 - share
    _fill_roll_axis(car, vehicle, front_share)
    _fill_springs(car, vehicle)
    _fill_tyres(car, vehicle, settings)
    return record


def _fill_roll_axis(car: np.void, vehicle: Mapping[str, float], front_share: float) -> None:
    axis = vehicle.get("two_track.roll_centre_height")
    if axis is None:
        heights = [vehicle.get(f"suspension.{axle}.roll_centre_height", 0.0) for axle in ("front", "rear")]
        axis = front_share * heights[0] + (1.0 - front_share) * heights[1]
    car["roll_centre"], car["roll_arm"] = axis, car["height"] - axis
    wheels = sum(vehicle.get(f"wheels.{wheel}.unsprung_mass", 0.0) for wheel in WHEELS)
    car["sprung_mass"] = vehicle.get("two_track.sprung_mass", car["mass"] - wheels)
    inertia = vehicle.get("two_track.roll_axis_inertia")
    if inertia is None:
        inertia = required(vehicle, "body.roll_inertia") + car["sprung_mass"] * car["roll_arm"] ** 2
    car["roll_inertia"] = inertia


def _fill_springs(car: np.void, vehicle: Mapping[str, float]) -> None:
    stiffness = damping = 0.0
    for axle in ("front", "rear"):
        section, track = f"suspension.{axle}", required(vehicle, f"axles.{axle}.track")
        spring = vehicle.get(f"{section}.spring_rate", 0.0)
        stiffness += (0.5 * spring + vehicle.get(f"{section}.anti_roll_rate", 0.0)) * track**2
        both = vehicle.get(f"{section}.compression_damping", 0.0) + vehicle.get(f"{section}.rebound_damping", 0.0)
        damping += 0.25 * both * track**2
    car["roll_stiffness"] = vehicle.get("planar.roll_stiffness", stiffness)
    car["roll_damping"] = vehicle.get("planar.roll_damping", damping)
    smallest = car["sprung_mass"] * GRAVITY_M_S2 * car["roll_arm"]
    if not (car["roll_stiffness"] > smallest and car["roll_damping"] > 0.0):
        raise InputError(
            "the vehicle file gives no roll stiffness that holds the body, which the estimator needs",
            found=f"{float(car['roll_stiffness']):.0f} N m/rad",
            allowed=f"more than {float(smallest):.0f} N m/rad, and damping",
            mend="give planar.roll_stiffness and planar.roll_damping, or a suspension",
        )


def _fill_tyres(car: np.void, vehicle: Mapping[str, float], settings: VerticalLoadSettings) -> None:
    given = settings.cornering_stiffness_front, settings.cornering_stiffness_rear
    for number, (axle, value) in enumerate(zip(("front", "rear"), given, strict=True)):
        if value is None:
            value = vehicle.get(f"two_track.cornering_stiffness_{axle}")
        if value is None:
            value = slope_of_tyre(vehicle, axle, 0.5 * car["static_load"][number])
        car["stiffness"][number] = value


def slope_of_tyre(vehicle: Mapping[str, float], axle: str, load: float) -> float:
    """Initial slope of the side force at a load [N/rad], where the file tells it in one of the usual ways."""
    lateral, formula = f"tyres.{axle}.lateral", f"tyres.{axle}.cornering_stiffness"
    if f"{lateral}.stiffness" in vehicle:
        names = ("stiffness", "shape", "peak_friction")
        return load * math.prod(required(vehicle, f"{lateral}.{name}") for name in names)
    if formula in vehicle:
        return load * vehicle[formula]
    raise InputError(
        f"the vehicle file does not tell the cornering stiffness of the {axle} tyres, which the estimator needs",
        mend=f"give the estimator's setting cornering_stiffness_{axle}, or two_track.cornering_stiffness_{axle}",
    )
