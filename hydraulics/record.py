"""Parameters of the hydraulic unit as the compiled model reads them."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hydraulics.fluid import viscosity_ratio
from signals.wheels import WHEELS

INCREASE, HOLD, DECREASE, INVALID = range(4)

STEP_S = 0.001
LONGEST_DELAY_STEPS = 128

# one number of the unit, named as in the vehicle file
_UNIT_NUMBERS = (
    "accumulator_pressure",
    "accumulator_volume",
    "pump_back_pressure",
    "pump_flow",
    "pump_pressure",
    "active_build_up",
    "rearm_near_target",
    "literal_event",
    "flow_through",
    "pump_failure",
    "pump_rate",
)
# one number per wheel, hydraulics.<name>_<wheel> and brakes.<name>_<wheel>
_UNIT_WHEELS = (
    "inlet_stuck",
    "outlet_stuck",
    "inlet_conductance",
    "outlet_conductance",
    "inlet_leak",
    "outlet_leak",
    "brake_leak",
    "air_volume",
)
_BRAKE_WHEELS = ("pad_glazing", "piston_friction", "drag_torque", "thickness_variation")
# one number per axle, brakes.<axle>.<name>, copied to its wheels
_BRAKE_AXLES = (
    "fade",
    "fade_temperature",
    "fade_floor",
    "disc_heat_capacity",
    "disc_heat_share",
    "disc_cooling",
    "disc_cooling_per_speed",
    "disc_start_temperature",
    "effective_radius",
    "pad_speed_exponent",
    "pad_pressure_exponent",
    "threshold_pressure",
)

PARAMETER_RECORD = np.dtype(
    [
        ("time_constant", "f8", (3,)),
        ("threshold", "f8"),
        *[(name, "f8") for name in _UNIT_NUMBERS],
        ("first_order_time_constant", "f8"),
        ("delay", "f8"),
        ("flow_resistance", "f8"),  # of the valves over that of warm fluid
        ("front_rear_split", "i8"),
        ("circuit_failure", "f8", (2,)),
        ("accumulator_blocked", "f8", (2,)),
        ("caliper_stiffness", "f8", (4,)),
        ("torque_per_pressure", "f8", (4,)),
        *[(name, "f8", (4,)) for name in (*_UNIT_WHEELS, *_BRAKE_WHEELS, *_BRAKE_AXLES)],
        ("ambient_temperature", "f8"),
        ("caliper_time_constant", "f8"),
        ("inlet_delay", "i8", (4,)),
        ("outlet_delay", "i8", (4,)),
        ("logic", "i8", (32,)),
    ]
)


def fill_record(values: Mapping[str, float], record: NDArray[np.void]) -> None:
    """Write the parameters into the record that the compiled model reads (its selection logic stays as it is).

    Parameters
    ----------
    values
        Every path of ``PARAMETERS`` with its SI value.
    record : shape (1,), dtype ``PARAMETER_RECORD``
    """
    entry = record[0]
    for number, name in enumerate(("increase", "hold", "decrease")):
        entry["time_constant"][number] = values[f"hydraulics.{name}_time_constant"]
    entry["threshold"] = values["hydraulics.pressure_change_threshold"]
    entry["first_order_time_constant"] = values["brakes.first_order_time_constant"]
    entry["delay"] = values["brakes.hydraulic_delay"]
    for name in _UNIT_NUMBERS:
        entry[name] = values[f"hydraulics.{name}"]
    viscous = viscosity_ratio(values["hydraulics.fluid_temperature"]) - 1.0
    entry["flow_resistance"] = 1.0 + values["hydraulics.laminar_share"] * viscous
    entry["front_rear_split"] = int(values["hydraulics.circuit_split"] > 0.5)
    for number, circuit in enumerate(("first", "second")):
        entry["circuit_failure"][number] = values[f"hydraulics.{circuit}_circuit_failure"]
        entry["accumulator_blocked"][number] = values[f"hydraulics.{circuit}_accumulator_blocked"]
    entry["ambient_temperature"] = values["brakes.ambient_temperature"]
    entry["caliper_time_constant"] = values["brakes.caliper_time_constant"]
    for wheel, suffix in enumerate(WHEELS):
        _fill_wheel(values, entry, wheel, suffix)


def _fill_wheel(values: Mapping[str, float], entry: np.void, wheel: int, suffix: str) -> None:
    axle = "front" if wheel < 2 else "rear"
    brake = f"brakes.{axle}"
    # eq. 78: two pads per brake
    area, friction = values[f"{brake}.pad_area"], values[f"{brake}.pad_friction"]
    entry["torque_per_pressure"][wheel] = 2.0 * area * friction * values[f"{brake}.effective_radius"]
    entry["caliper_stiffness"][wheel] = values[f"hydraulics.caliper_stiffness_{axle}"]
    for name in _BRAKE_AXLES:
        entry[name][wheel] = values[f"{brake}.{name}"]
    for name in _BRAKE_WHEELS:
        entry[name][wheel] = values[f"brakes.{name}_{suffix}"]
    for name in _UNIT_WHEELS:
        entry[name][wheel] = values[f"hydraulics.{name}_{suffix}"]
    for valve in ("inlet", "outlet"):
        entry[f"{valve}_delay"][wheel] = round(values[f"hydraulics.{valve}_delay_{suffix}"] / STEP_S)
