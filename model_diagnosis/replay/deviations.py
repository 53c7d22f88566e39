"""How each deviation of the catalogue changes the replay's record; a deviation of 0 leaves it bit-identical."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.in_common import IN_COMMON
from signals.wheels import WHEELS

ALL, FRONT, REAR = slice(0, 4), slice(0, 2), slice(2, 4)


@dataclass(frozen=True)
class _Change:
    """``field`` (of the wheels) times 1 + deviation, or plus the deviation; kept within its limits."""

    field: str
    wheels: slice | None = None
    relative: bool = True
    factor: float = 1.0
    least: float = -np.inf

    def apply(self, entry: np.void, deviation: float) -> None:
        if self.wheels is None:
            entry[self.field] = self._changed(entry[self.field], deviation)
        else:
            entry[self.field][self.wheels] = self._changed(entry[self.field][self.wheels], deviation)

    def _changed(self, value: float | NDArray[np.float64], deviation: float) -> float | NDArray[np.float64]:
        change = self.factor * deviation
        changed = value * (1.0 + change) if self.relative else value + change
        limited: NDArray[np.float64] = np.maximum(changed, self.least)
        return limited


def _relative(field: str, wheels: slice | None = None, factor: float = 1.0) -> _Change:
    return _Change(field, wheels, True, factor)


def _absolute(field: str, wheels: slice | None = None, factor: float = 1.0, least: float = -np.inf) -> _Change:
    return _Change(field, wheels, False, factor, least)


def _each_wheel(effect: str, field: str, relative: bool) -> dict[str, tuple[_Change, ...]]:
    return {f"{effect}.{wheel}": (_Change(field, slice(i, i + 1), relative),) for i, wheel in enumerate(WHEELS)}


def _each_axle(
    effect: str, *fields: str, relative: bool = True, least: float = -np.inf
) -> dict[str, tuple[_Change, ...]]:
    return {
        f"{effect}.{axle}": tuple(_Change(field, wheels, relative) for field in fields)
        for axle, wheels in (("front", FRONT), ("rear", REAR))
    }


def _tyre_changes() -> dict[str, tuple[_Change, ...]]:
    lengths = tuple(_absolute(f"relaxation_{letter}", ALL, least=0.0) for letter in "xy")
    return {
        **_each_axle("tyre_friction", "friction"),
        "tyre_longitudinal_stiffness.factor": (_relative("longitudinal_stiffness", ALL),),
        **_each_axle("tyre_cornering_stiffness", "cornering_stiffness"),
        "tyre_load_sensitivity.loss": (_absolute("more_load_loss"),),
        "tyre_relaxation_length.length": lengths,
        "tyre_peak_shape.peak_slip": (_absolute("peak_shift"),),
        "tyre_temperature_fade.coefficient": (_absolute("heat_fade"),),
        "tyre_velocity_fade.slope": (_absolute("velocity_fade"),),
        "tyre_camber_conicity.camber": (_absolute("camber_angle"),),
        "tyre_camber_conicity.conicity": (_absolute("conicity"),),
        "rolling_resistance.constant": (_relative("rolling_resistance", ALL),),
        "rolling_resistance.speed": (_absolute("rolling_speed"),),
        **_each_wheel("wheel_radius_change", "radius", relative=True),
        "wheel_radius_load.load": (_absolute("radius_load"),),
        "wheel_radius_load.speed": (_absolute("radius_speed"),),
    }


def _brake_changes() -> dict[str, tuple[_Change, ...]]:
    return {
        "brake_pad_friction.factor": (_relative("torque_per_pressure", ALL),),
        "brake_pad_speed.exponent": (_absolute("pad_speed_exponent", ALL),),
        "brake_pad_pressure.exponent": (_absolute("pad_pressure_exponent", ALL),),
        "brake_pad_fade.coefficient": (_absolute("fade", ALL),),
        "brake_pad_fade.temperature": (_absolute("fade_temperature", ALL),),
        "brake_in_stop_rise.rise": (_absolute("in_stop_rise"),),
        "brake_hysteresis.pressure": (_absolute("hysteresis"),),
        "brake_threshold.pressure": (_absolute("threshold_pressure", ALL, least=0.0),),
        **_each_wheel("brake_drag_torque", "drag_torque", relative=False),
        **_each_wheel("wheel_brake_weak", "brake_factor", relative=True),
        **{
            f"disc_thickness_variation.{wheel}_{part}": (_absolute(f"thickness_variation_{part}", slice(i, i + 1)),)
            for i, wheel in enumerate(WHEELS)
            for part in ("sine", "cosine")
        },
        "caliper_lag.time_constant": (_absolute("caliper_lag", least=0.0),),
    }


def _chassis_changes() -> dict[str, tuple[_Change, ...]]:
    return {
        **_each_axle("spring_rate", "spring_rate"),
        **_each_axle("damper_rate", "compression_damping", "rebound_damping"),
        **_each_axle("anti_roll_bar", "anti_roll_rate"),
        "bump_stop.rate": (_absolute("bump_rate", ALL, least=0.0),),
        "bump_stop.clearance": (_absolute("bump_clearance", ALL, least=0.0),),
        **_each_axle("roll_centre_height", "roll_centre_height", relative=False),
        "mass_change.factor": (_relative("mass"),),
        "cg_height_change.factor": (_relative("height"),),
        "cg_longitudinal.shift": (_absolute("front_arm"),),
        "yaw_inertia.factor": (_relative("yaw_inertia"),),
        "aero_drag.factor": (_relative("drag"),),
        "head_wind.speed": (_absolute("wind_along"),),
        "side_wind.speed": (_absolute("wind_across"),),
        "road_grade.grade": (_absolute("grade"),),
        "road_bank.bank": (_absolute("bank"),),
        "mu_step.level": (_absolute("friction_step"),),
        "mu_step.place": (_absolute("friction_step_place"),),
        "mu_split.level": (_absolute("friction_split"),),
        "engine_braking.torque": (_absolute("engine_drag"),),
        "driveline_drag.constant": (_absolute("driveline_drag"),),
        "driveline_drag.viscous": (_absolute("driveline_viscous"),),
        "differential_locking.preload": (_absolute("locking_preload"),),
        "differential_locking.viscous": (_absolute("locking_viscous"),),
        "steering_compliance.stiffness": (_relative("steering_stiffness"),),
        "steering_offset.angle": (_absolute("steering_offset"),),
        "accelerometer_levelled.share": (_absolute("accelerometer_leaning", factor=-1.0),),
    }


def _form_changes() -> dict[str, tuple[_Change, ...]]:
    """Differences of form that are no causes (``effects.form``)."""
    return {
        "form_contact_scrub.roll": (_absolute("roll_scrub"),),
        "form_contact_scrub.pitch": (_absolute("pitch_scrub"),),
        "form_contact_scrub.links": (_absolute("link_scrub"),),
        "form_pitch_pole.share": (_absolute("pitch_pole"),),
        "form_guide_lean.share": (_absolute("guide_lean"),),
        "form_support.apart": (_absolute("support_apart"),),
        "form_heave.held": (_absolute("link_lift_held"),),
        "form_transient.share": (_absolute("lag_on_force"),),
        "form_steering_link.share": (_absolute("steering_link"),),
        "form_trail.bulge": (_absolute("trail_bulge"),),
        "form_trail.across": (_absolute("trail_across"),),
        "form_weight_arm.roll": (_absolute("roll_weight_arm"),),
        "form_weight_arm.pitch": (_absolute("pitch_weight_arm"),),
        "form_body_inertia.roll": (_relative("roll_inertia"),),
        "form_body_inertia.pitch": (_relative("pitch_inertia"),),
        **_each_axle("form_wheel_inertia", "spin_inertia"),
        "form_inferred_braking.front": (_absolute("inferred_front"),),
        "form_lag.accelerometer": (_absolute("accelerometer_lag", least=0.0),),
        "form_lag.gyro": (_absolute("gyro_lag"),),
        "form_lag.speed": (_absolute("speed_lag"),),
        "form_lag.wheel_speed": (_absolute("wheel_speed_lag"),),
        "form_lag.steering": (_relative("steering_damping"),),
    }


def _support(axle: slice) -> Callable[[np.void, float], None]:
    def apply(entry: np.void, angle: float) -> None:
        for support in ("brake_support", "drive_support"):
            entry[support][axle] = np.tan(np.arctan(entry[support][axle]) + angle)

    return apply


def _lift(field: str) -> Callable[[np.void, float], None]:
    def apply(entry: np.void, coefficient: float) -> None:
        entry[field] += coefficient * entry["air"]

    return apply


def _balance(entry: np.void, shift: float) -> None:
    torque = entry["torque_per_pressure"]
    ratio = torque[0] / torque[2] if torque[2] > 0.0 else 0.0
    torque[FRONT] *= 1.0 + shift
    torque[REAR] *= max(1.0 - shift * ratio, 0.0)


def _pressure(entry: np.void, deviation: float) -> None:
    """A tyre at another pressure (exponents as in the effect's equation)."""
    pressure = 1.0 + deviation
    entry["cornering_stiffness"] *= pressure**0.4
    entry["longitudinal_stiffness"] *= pressure**-0.1
    entry["relaxation_x"] *= pressure**-0.3
    entry["relaxation_y"] *= pressure**-0.3
    entry["rolling_resistance"] *= pressure**-0.4
    deflection = entry["reference_load"] / entry["vertical_stiffness"]
    entry["radius"] += deflection * (1.0 - 1.0 / pressure)
    entry["vertical_stiffness"] *= pressure


def _reflected_inertia(entry: np.void, inertia: float) -> None:
    driven = entry["drive_share"] > 0.0
    entry["spin_inertia"][driven] = np.maximum(entry["spin_inertia"][driven] + inertia, 0.05)


def _ratio(entry: np.void, deviation: float) -> None:
    entry["steering_scale"] /= 1.0 + deviation


def _tyre_compliance(entry: np.void, deviation: float) -> None:
    entry["vertical_stiffness"] /= 1.0 + deviation


def _damper_split(entry: np.void, share: float) -> None:
    """Damping moved from rebound to compression, their sum as before."""
    moved = share * entry["compression_damping"]
    entry["compression_damping"] += moved
    entry["rebound_damping"] -= moved


_CHANGES: Mapping[str, tuple[_Change, ...]] = {
    **_tyre_changes(),
    **_brake_changes(),
    **_chassis_changes(),
    **_form_changes(),
}
_LAWS: Mapping[str, Callable[[np.void, float], None]] = {
    "form_damper_split.share": _damper_split,
    "form_tyre_spring.compliance": _tyre_compliance,
    "anti_dive_anti_lift.front": _support(FRONT),
    "anti_dive_anti_lift.rear": _support(REAR),
    "aero_lift_front_rear.front": _lift("lift_front"),
    "aero_lift_front_rear.rear": _lift("lift_rear"),
    "brake_balance.shift": _balance,
    "tyre_ageing_pressure.pressure": _pressure,
    "wheel_inertia_reflected.inertia": _reflected_inertia,
    "steering_ratio.factor": _ratio,
}

RECORD_COLUMNS = frozenset(_CHANGES) | frozenset(_LAWS) | frozenset(IN_COMMON)
"""Columns that change the car's record."""


def change_record(record: NDArray[np.void], deviations: Mapping[str, float]) -> None:
    """Apply deviations by column to a car's record (shape ``(1,)``); columns that act elsewhere are passed over."""
    entry = record[0]
    by_axle = _by_axle(deviations)
    # numbers of the data sheet come first: what a cause adds to one does not grow with it
    for column, deviation in sorted(by_axle.items(), key=lambda pair: not pair[0].startswith("form_")):
        if deviation == 0.0:
            continue
        if column in _LAWS:
            _LAWS[column](entry, deviation)
        for change in _CHANGES.get(column, ()):
            change.apply(entry, deviation)


def _by_axle(deviations: Mapping[str, float]) -> Mapping[str, float]:
    """The same with what both axles have in common added to each one's own."""
    common = {column: deviation for column, deviation in deviations.items() if column in IN_COMMON}
    if not common:
        return deviations
    own = {column: deviation for column, deviation in deviations.items() if column not in common}
    for column, deviation in common.items():
        own |= {axle: own.get(axle, 0.0) + deviation for axle in IN_COMMON[column]}
    return own
