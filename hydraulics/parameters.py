"""Parameters of the hydraulic unit: dotted path, unit, default, range, and the record that the compiled model reads."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from signals.wheels import WHEELS

INCREASE, HOLD, DECREASE, INVALID = range(4)

STEP_S = 0.001
LONGEST_DELAY_STEPS = 128

PARAMETER_RECORD = np.dtype(
    [
        ("time_constant", "f8", (3,)),
        ("threshold", "f8"),
        ("accumulator_pressure", "f8"),
        ("accumulator_volume", "f8"),
        ("pump_flow", "f8"),
        ("pump_pressure", "f8"),
        ("active_build_up", "f8"),
        ("rearm_near_target", "f8"),
        ("literal_event", "f8"),
        ("pump_failure", "f8"),
        ("first_order_time_constant", "f8"),
        ("delay", "f8"),
        ("caliper_stiffness", "f8", (4,)),
        ("torque_per_pressure", "f8", (4,)),
        ("inlet_stuck", "f8", (4,)),
        ("outlet_stuck", "f8", (4,)),
        ("inlet_delay", "i8", (4,)),
        ("outlet_delay", "i8", (4,)),
        ("logic", "i8", (32,)),
    ]
)


@dataclass(frozen=True)
class Parameter:
    """One parameter of the unit.

    Attributes
    ----------
    path, unit
        Dotted path as in a vehicle file, SI unit.
    default
        Value when the vehicle file has none; None where the file has to give it.
    low, high
        Closed range of allowed values.
    description, source
        One line, and where the default comes from.
    """

    path: str
    unit: str
    default: float | None
    low: float
    high: float
    description: str
    source: str


def _hydraulics(name: str, unit: str, default: float, low: float, high: float, text: str, source: str) -> Parameter:
    return Parameter(f"hydraulics.{name}", unit, default, low, high, text, source)


def _per_wheel(name: str, unit: str, high: float, text: str) -> list[Parameter]:
    return [_hydraulics(f"{name}_{w}", unit, 0.0, 0.0, high, f"{text}, {w}", "neutral") for w in WHEELS]


def _brake(axle: str) -> list[Parameter]:
    path = f"brakes.{axle}"
    return [
        Parameter(f"{path}.pad_area", "m^2", None, 1e-5, 0.1, "effective area of one pad", "vehicle file"),
        Parameter(f"{path}.pad_friction", "1", None, 0.0, 2.0, "friction of pad on disc", "vehicle file"),
        Parameter(f"{path}.effective_radius", "m", None, 0.01, 1.0, "radius at which the pads act", "vehicle file"),
    ]


_SPEC = "friction document 2.6.4"
_STUCK = "valve fault: 0 none, 1 stuck open, 2 stuck closed"

PARAMETERS: tuple[Parameter, ...] = (
    *_brake("front"),
    *_brake("rear"),
    Parameter(
        "brakes.hydraulic_delay", "s", 0.005, 0.0, 0.12, "delay of the brake of eq. 79", "friction document 2.4.2"
    ),
    Parameter(
        "brakes.first_order_time_constant",
        "s",
        0.02,
        1e-4,
        1.0,
        "time constant of the brake of eq. 79",
        "friction document 2.4.2",
    ),
    _hydraulics("increase_time_constant", "s", 0.05, 1e-4, 2.0, "pressure build-up", _SPEC),
    _hydraulics("hold_time_constant", "s", 0.05, 1e-4, 2.0, "settling after the valves close", _SPEC),
    _hydraulics("decrease_time_constant", "s", 0.03, 1e-4, 2.0, "pressure release", _SPEC),
    _hydraulics("pressure_change_threshold", "Pa", 1e5, 0.0, 5e6, "driver's change that re-arms a segment", _SPEC),
    _hydraulics(
        "accumulator_pressure", "Pa", 5e5, 0.0, 2e6, "pressure of a full low-pressure accumulator", "document 2.6.1"
    ),
    _hydraulics("accumulator_volume", "m^3", 4e-6, 1e-7, 1e-4, "capacity per circuit", "assumed: usual 2 to 4 cm^3"),
    _hydraulics("pump_flow", "m^3/s", 6e-6, 0.0, 1e-3, "return pump, per circuit", "assumed"),
    _hydraulics("pump_pressure", "Pa", 1.5e7, 0.0, 4e7, "pressure of active build-up", "assumed"),
    _hydraulics("active_build_up", "1", 0.0, 0.0, 1.0, "1 while an ESP logic builds pressure by pump", "neutral"),
    _hydraulics(
        "caliper_stiffness_front",
        "Pa/m^3",
        7e12,
        1e11,
        1e15,
        "pressure per volume",
        "assumed: 0.014 cm^3/bar above the knee",
    ),
    _hydraulics(
        "caliper_stiffness_rear",
        "Pa/m^3",
        1.6e13,
        1e11,
        1e15,
        "pressure per volume",
        "assumed: 0.006 cm^3/bar above the knee",
    ),
    _hydraulics("rearm_near_target", "1", 0.0, 0.0, 1.0, "1 re-arms build-up each step near the target", _SPEC),
    _hydraulics("literal_event", "1", 0.0, 0.0, 1.0, "1 uses the printed AND form of the event", "document 2.6.3"),
    _hydraulics("pump_failure", "1", 0.0, 0.0, 1.0, "1 stops the return pump", "neutral"),
    *_per_wheel("inlet_stuck", "1", 2.0, f"inlet {_STUCK}"),
    *_per_wheel("outlet_stuck", "1", 2.0, f"outlet {_STUCK}"),
    *_per_wheel("inlet_delay", "s", 0.1, "dead time of the inlet valve"),
    *_per_wheel("outlet_delay", "s", 0.1, "dead time of the outlet valve"),
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
    for name in (
        "accumulator_pressure",
        "accumulator_volume",
        "pump_flow",
        "pump_pressure",
        "active_build_up",
        "rearm_near_target",
        "literal_event",
        "pump_failure",
    ):
        entry[name] = values[f"hydraulics.{name}"]
    for wheel, suffix in enumerate(WHEELS):
        axle = "front" if wheel < 2 else "rear"
        brake = f"brakes.{axle}"
        # eq. 78: two pads per brake
        area, friction = values[f"{brake}.pad_area"], values[f"{brake}.pad_friction"]
        entry["torque_per_pressure"][wheel] = 2.0 * area * friction * values[f"{brake}.effective_radius"]
        entry["caliper_stiffness"][wheel] = values[f"hydraulics.caliper_stiffness_{axle}"]
        for valve in ("inlet", "outlet"):
            entry[f"{valve}_stuck"][wheel] = values[f"hydraulics.{valve}_stuck_{suffix}"]
            entry[f"{valve}_delay"][wheel] = round(values[f"hydraulics.{valve}_delay_{suffix}"] / STEP_S)
