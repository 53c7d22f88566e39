"""Numbers of the car that the vehicle-state observers use, as the document names them (6.1)."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import count

import numpy as np
from numpy.typing import NDArray

from estimators.vehicle_numbers import longitudinal_car, required
from signals.errors import InputError

GRAVITY = 9.80665
"""The document's g (l. 5904, implied)."""

MOST_GEARS = 12

CAR_RECORD = np.dtype(
    [
        ("m", "f8"),
        ("j_z", "f8"),
        ("j_y", "f8"),
        ("j_xx", "f8"),
        ("j_k", "f8", (4,)),
        ("j_e", "f8"),
        ("l_1", "f8"),
        ("l_2", "f8"),
        ("b_1", "f8"),
        ("b_2", "f8"),
        ("h", "f8"),
        ("h_w", "f8"),
        ("r", "f8", (4,)),
        ("f_0", "f8"),
        ("k_fv", "f8"),
        ("drag", "f8"),
        ("roll_stiffness", "f8"),
        ("roll_damping", "f8"),
        ("pitch_stiffness", "f8"),
        ("pitch_damping", "f8"),
        ("efficiency", "f8"),
        ("ratio", "f8", (MOST_GEARS + 1,)),  # gearbox times final drive, gear 0 is neutral
        ("driven", "f8", (4,)),  # share of the drive torque, in the document's wheel order
        ("brake_gain", "f8", (4,)),
        ("arm_1", "f8"),  # from a_y at the centre of gravity to the friction in use of each axle
        ("arm_2", "f8"),
    ]
)


@dataclass(frozen=True)
class DocumentCar:
    """The car in the document's letters, and its steering map.

    Attributes
    ----------
    record : shape (1,), dtype ``CAR_RECORD``
    steering : array, shape (3, n)
        Steering-wheel angles and road-wheel angles of the left and the right wheel at them [rad], bench axes.
    """

    record: NDArray[np.void]
    steering: NDArray[np.float64]


def document_car(vehicle: Mapping[str, float], *, exact_arms: bool = True, needs_steering: bool = True) -> DocumentCar:
    """Read the car from the numbers of a vehicle file.

    Parameters
    ----------
    vehicle : mapping
        Dotted path to SI number.
    exact_arms : bool
        Arms from the yaw acceleration to the friction in use of the axles: J_z/(m l_2) and J_z/(m l_1), which the
        balance of forces demands, or l_1 and l_2 as printed (3.3, editor's warning 4).
    needs_steering : bool
        Whether a missing steering map is an error (2.8).

    Raises
    ------
    InputError
        If the file lacks a number or, where it is needed, the steering map.
    """
    both = longitudinal_car(vehicle, with_brakes="brakes.front.pad_area" in vehicle)
    record = np.zeros(1, CAR_RECORD)
    car = record[0]
    car["m"], car["h"], car["h_w"] = both.mass, both.height, both.drag_height
    car["l_1"], car["l_2"] = both.front_length, both.wheelbase - both.front_length
    car["b_1"], car["b_2"] = required(vehicle, "axles.front.track"), required(vehicle, "axles.rear.track")
    car["j_z"] = required(vehicle, "body.yaw_inertia")
    car["j_y"] = required(vehicle, "body.pitch_inertia")
    car["j_xx"] = required(vehicle, "body.roll_inertia")
    car["r"] = both.radius[0], both.radius[0], both.radius[1], both.radius[1]
    car["j_k"] = [0.5 * both.inertia[i // 2] for i in range(4)]
    car["brake_gain"] = [both.brake_gain[i // 2] for i in range(4)]
    car["drag"], car["f_0"] = both.drag_factor, both.rolling_coefficient
    car["k_fv"] = vehicle.get("planar.rolling_resistance_speed_factor", 0.0)
    car["arm_1"] = car["j_z"] / (car["m"] * car["l_2"]) if exact_arms else car["l_1"]
    car["arm_2"] = car["j_z"] / (car["m"] * car["l_1"]) if exact_arms else car["l_2"]
    _fill_springs(car, vehicle)
    _fill_driveline(car, vehicle)
    return DocumentCar(record, _steering_map(vehicle, needs_steering))


def _fill_springs(car: np.void, vehicle: Mapping[str, float]) -> None:
    """Body springs: given, or those of the suspension."""
    sums = dict.fromkeys(("pitch_stiffness", "pitch_damping", "roll_stiffness", "roll_damping"), 0.0)
    for axle, arm, track in (("front", car["l_1"], car["b_1"]), ("rear", car["l_2"], car["b_2"])):
        section = f"suspension.{axle}"
        if f"{section}.spring_rate" not in vehicle:
            continue
        spring = required(vehicle, f"{section}.spring_rate")
        damping = 0.5 * (
            required(vehicle, f"{section}.compression_damping") + required(vehicle, f"{section}.rebound_damping")
        )
        sums["pitch_stiffness"] += 2.0 * spring * arm**2
        sums["pitch_damping"] += 2.0 * damping * arm**2
        sums["roll_stiffness"] += (0.5 * spring + vehicle.get(f"{section}.anti_roll_rate", 0.0)) * track**2
        sums["roll_damping"] += 0.5 * damping * track**2
    for name, value in sums.items():
        car[name] = vehicle.get(f"planar.{name}", value)
        if not car[name] > 0.0:
            raise InputError(
                f"the vehicle file gives neither planar.{name} nor a suspension, one of which the estimator needs"
            )


def _fill_driveline(car: np.void, vehicle: Mapping[str, float]) -> None:
    car["efficiency"] = vehicle.get("driveline.efficiency", 1.0)
    car["j_e"] = vehicle.get("driveline.engine.inertia", 0.0)
    final = vehicle.get("driveline.final_drive", 1.0)
    for gear in range(1, MOST_GEARS + 1):
        ratio = vehicle.get(f"driveline.gear_ratios.{gear - 1}")
        if ratio is None:
            break
        car["ratio"][gear] = ratio * final


def _steering_map(vehicle: Mapping[str, float], needed: bool) -> NDArray[np.float64]:
    rows = []
    for name in ("steering_wheel_angle", "left", "right"):
        row: list[float] = []
        for number in count():
            value = vehicle.get(f"steering.map.{name}.{number}")
            if value is None:
                break
            row.append(value)
        rows.append(row)
    if len(rows[0]) < 2:
        if needed:
            raise InputError(
                "the vehicle file gives no steering.map, which the estimator needs",
                mend="give steering.map with steering_wheel_angle, left and right, or take a car that has one "
                "(lada_vesta_assumed_steering)",
            )
        return np.array([[-1.0, 1.0], [0.0, 0.0], [0.0, 0.0]])
    return np.array(rows)
