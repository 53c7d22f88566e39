"""Effects that one parameter of the vehicle file does not hold: several parameters together, or added terms.

Each law is the equation of the effect in the catalogue, written for the plant. A law gets the vehicle and the
deviations that are not zero, and gives values by dotted path and terms.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

from model_diagnosis.extension.tyre_shape import peak_shape
from signals.wheels import WHEELS
from vehicle_model.extension_terms_file import Term, Wheels
from vehicle_model.vehicle_file import VehicleFile

Result = tuple[dict[str, float], list[Term]]
Law = Callable[[VehicleFile, Mapping[str, float]], Result]

_STOP_SPEED_M_S = 100.0 / 3.6
_TURNING_RAD_S = 1.0
_PRELOAD_SPAN_RAD_S = 0.5
_COASTING_N_M = 1.0
_TOUCHING_PA = 1e3
"""Pressure at the pads from which a brake counts as applied."""
_PRESSURE_POWERS = {"lateral": 0.4, "longitudinal": -0.1, "relaxation": -0.3, "rolling": -0.4}


def _term(target: str, coefficient: float, *factors: dict[str, Any], wheels: str = "all", description: str) -> Term:
    return Term.model_validate(
        {
            "target": target,
            "coefficient": coefficient,
            "wheels": wheels,
            "factors": list(factors),
            "description": description,
        }
    )


def _driven(vehicle: VehicleFile) -> list[tuple[Wheels, float]]:
    """Driven axles with the share of each of their wheels in the torque of the driveline."""
    shares = vehicle.driveline.wheel_share()
    axles: tuple[tuple[Wheels, float], ...] = (("front", shares[0]), ("rear", shares[2]))
    return [(axle, share) for axle, share in axles if share > 0.0]


def _torque_per_pressure(vehicle: VehicleFile, axle: str) -> float:
    """Torque of one brake over the pressure [N m/Pa] (eq. 78 of the friction document: two pads)."""
    brake = getattr(vehicle.brakes, axle)
    return float(2.0 * brake.pad_area * brake.pad_friction * brake.effective_radius)


def _support_angles(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    """The links' pole has moved, about which both what brakes and what drives an axle supports it."""
    numbers = vehicle.numbers("suspension")
    paths = [(f"suspension.{axle}.{kind}_support_angle", axle) for axle in deviation for kind in ("brake", "drive")]
    return {path: numbers[path] + deviation[axle] for path, axle in paths}, []


def _temperature_fade(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    factor = {"variable": "tyre_heating", "exponent": 2.0}
    text = "friction lost to the tread's heat"
    return {}, [_term("tyre_friction_factor", -deviation["coefficient"], factor, description=text)]


def _velocity_fade(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    factor = {"variable": "speed", "symmetry": "even"}
    return {}, [_term("tyre_friction_factor", -deviation["slope"], factor, description="friction lost with speed")]


def _conicity(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    terms = []
    if "camber" in deviation:
        load = {"variable": "vertical_load"}
        terms.append(_term("tyre_lateral_force", deviation["camber"], load, description="camber thrust"))
    if "conicity" in deviation:
        terms.append(_term("tyre_lateral_force", deviation["conicity"], description="conicity"))
    return {}, terms


def _ageing_pressure(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    pressure, power = 1.0 + deviation["pressure"], _PRESSURE_POWERS
    tyres, values = vehicle.numbers("tyres"), {}
    for axle, load in (("front", vehicle.static_loads()[0]), ("rear", vehicle.static_loads()[2])):
        for direction in ("lateral", "longitudinal"):
            path = f"tyres.{axle}.{direction}.stiffness"
            if path in tyres:
                values[path] = tyres[path] * pressure ** power[direction]
            length = f"tyres.{axle}.relaxation_length_{direction}"
            if length in tyres:
                values[length] = tyres[length] * pressure ** power["relaxation"]
        for wheel in WHEELS[:2] if axle == "front" else WHEELS[2:]:
            entry, path = getattr(vehicle.wheels, wheel), f"wheels.{wheel}"
            values[f"{path}.rolling_resistance"] = entry.rolling_resistance * pressure ** power["rolling"]
            values[f"{path}.radius"] = entry.radius + load / entry.vertical_stiffness * (1.0 - 1.0 / pressure)
            values[f"{path}.vertical_stiffness"] = entry.vertical_stiffness * pressure
    return values, []


def _rolling_resistance(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    share = 1.0 + deviation.get("constant", 0.0)
    values = {
        f"wheels.{wheel}.rolling_resistance": getattr(vehicle.wheels, wheel).rolling_resistance for wheel in WHEELS
    }
    terms = []
    if "speed" in deviation:
        terms = [
            _term(
                "rolling_resistance",
                values[f"wheels.{wheel}.rolling_resistance"] * deviation["speed"],
                {"variable": "speed"},
                wheels=wheel,
                description="rolling resistance by speed",
            )
            for wheel in WHEELS
        ]
    changed = {path: value * share for path, value in values.items()} if "constant" in deviation else {}
    return changed, terms


def _radius_load(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    terms, loads = [], vehicle.static_loads()
    for axle, wheel, rest in (("front", "fl", loads[0]), ("rear", "rl", loads[2])):
        radius = getattr(vehicle.wheels, wheel).radius
        if "load" in deviation:
            share, text = deviation["load"] / radius, "radius by load"
            load = {"variable": "vertical_load"}
            terms.append(_term("wheel_radius_factor", -share, load, wheels=axle, description=text))
            terms.append(_term("wheel_radius_factor", share * rest, wheels=axle, description=text))
        if "speed" in deviation:
            square = {"variable": "speed", "exponent": 2.0}
            text = "radius by speed"
            terms.append(
                _term("wheel_radius_factor", deviation["speed"] / radius, square, wheels=axle, description=text)
            )
    return {}, terms


def _in_stop_rise(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    energy = 0.5 * vehicle.body.mass * _STOP_SPEED_M_S**2
    text = "pad friction over the energy of the stop"
    return {}, [_term("brake_torque_factor", deviation["rise"] / energy, {"variable": "stop_energy"}, description=text)]


def _hysteresis(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    """A piston with half of the hysteresis as friction each way, and its half added back where the brake is applied:
    rising the torque follows the pressure at once, falling only beyond the hysteresis."""
    half = deviation["pressure"] / 2.0
    values = {
        f"brakes.piston_friction_{wheel}": getattr(vehicle.brakes, f"piston_friction_{wheel}") + half
        for wheel in WHEELS
    }
    terms = [
        _term(
            "brake_torque",
            half * _torque_per_pressure(vehicle, axle),
            {"variable": "brake_pressure", "function": "step", "at": _TOUCHING_PA},
            wheels=axle,
            description="mean pressure of the hysteresis",
        )
        for axle in ("front", "rear")
    ]
    return values, terms


def _balance(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    shift, brakes = deviation["shift"], vehicle.brakes
    rear = _torque_per_pressure(vehicle, "rear")
    ratio = _torque_per_pressure(vehicle, "front") / rear if rear > 0.0 else 0.0
    return {
        "brakes.front.pad_friction": brakes.front.pad_friction * (1.0 + shift),
        "brakes.rear.pad_friction": brakes.rear.pad_friction * max(1.0 - shift * ratio, 0.0),
    }, []


def _weak_brake(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    values, terms = {}, []
    for wheel, change in deviation.items():
        glazing = 1.0 - (1.0 - getattr(vehicle.brakes, f"pad_glazing_{wheel}")) * (1.0 + change)
        if glazing >= 0.0:
            values[f"brakes.pad_glazing_{wheel}"] = glazing
        else:
            terms.append(_term("brake_torque_factor", change, wheels=wheel, description="stronger wheel brake"))
    return values, terms


def _thickness_variation(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    """Amplitude of sine and cosine together: where on the disc it lies has no meaning in another drive."""
    return {
        f"brakes.thickness_variation_{wheel}": math.hypot(
            deviation.get(f"{wheel}_sine", 0.0), deviation.get(f"{wheel}_cosine", 0.0)
        )
        for wheel in WHEELS
        if f"{wheel}_sine" in deviation or f"{wheel}_cosine" in deviation
    }, []


def _caliper_lag(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    return {"brakes.caliper_time_constant": vehicle.brakes.caliper_time_constant + deviation["time_constant"]}, []


def _engine_braking(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    turning = {"variable": "wheel_speed", "function": "limited", "width": _TURNING_RAD_S}
    coasting = {"variable": "drive_torque", "function": "below", "at": _COASTING_N_M, "exponent": 0.0}
    torque, text = deviation["torque"], "engine braking"
    return {}, [
        _term("drive_torque", -torque * share, turning, coasting, wheels=axle, description=text)
        for axle, share in _driven(vehicle)
    ]


def _driveline_drag(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    turning = {"variable": "wheel_speed", "function": "limited", "width": _TURNING_RAD_S}
    terms, text = [], "drag of the driveline"
    for axle, share in _driven(vehicle):
        if "constant" in deviation:
            torque = -share * deviation["constant"]
            terms.append(_term("drive_torque", torque, turning, wheels=axle, description=text))
        if "viscous" in deviation:
            speed = {"variable": "wheel_speed"}
            torque = -share * deviation["viscous"]
            terms.append(_term("drive_torque", torque, speed, wheels=axle, description=text))
    return {}, terms


def _reflected_inertia(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    shares = vehicle.driveline.wheel_share()
    return {
        f"wheels.{wheel}.inertia": max(getattr(vehicle.wheels, wheel).inertia + deviation["inertia"], 0.05)
        for wheel, share in zip(WHEELS, shares, strict=True)
        if share > 0.0
    }, []


def _differential(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    terms, text = [], "locking of the differential"
    for axle, _ in _driven(vehicle):
        if "preload" in deviation:
            sign = {"variable": "axle_speed_difference", "function": "limited", "width": _PRELOAD_SPAN_RAD_S}
            terms.append(_term("drive_torque", -deviation["preload"], sign, wheels=axle, description=text))
        if "viscous" in deviation:
            difference = {"variable": "axle_speed_difference"}
            terms.append(_term("drive_torque", -deviation["viscous"], difference, wheels=axle, description=text))
    return {}, terms


def _tone_ring(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    """One ring radius for all sensors, so that the largest error is the car's eccentricity."""
    ring = vehicle.sensors.wheel_speed
    return {"sensors.wheel_speed.eccentricity": ring.eccentricity + max(map(abs, deviation.values()))}, []


def _booster(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    brakes = vehicle.brakes
    values = {
        "gain": ("brakes.booster_gain", brakes.booster_gain * (1.0 + deviation.get("gain", 0.0))),
        "slope_loss": (
            "brakes.booster_slope_loss",
            min(brakes.booster_slope_loss + deviation.get("slope_loss", 0.0), 1.0),
        ),
        "knee": ("brakes.booster_knee_pressure", max(brakes.booster_knee_pressure + deviation.get("knee", 0.0), 0.0)),
    }
    return dict(values[name] for name in deviation), []


def _pressure_lag(vehicle: VehicleFile, deviation: Mapping[str, float]) -> Result:
    """The plant's pressure sensors delay; a lag of first order is a delay of its time constant at low frequencies."""
    return {"sensors.brake_pressure.delay": vehicle.sensors.brake_pressure.delay + deviation["time_constant"]}, []


LAWS: Mapping[str, Law] = {
    "anti_dive_anti_lift": _support_angles,
    "tyre_peak_shape": peak_shape,
    "tyre_temperature_fade": _temperature_fade,
    "tyre_velocity_fade": _velocity_fade,
    "tyre_camber_conicity": _conicity,
    "tyre_ageing_pressure": _ageing_pressure,
    "rolling_resistance": _rolling_resistance,
    "wheel_radius_load": _radius_load,
    "brake_in_stop_rise": _in_stop_rise,
    "brake_hysteresis": _hysteresis,
    "brake_balance": _balance,
    "wheel_brake_weak": _weak_brake,
    "disc_thickness_variation": _thickness_variation,
    "caliper_lag": _caliper_lag,
    "booster_saturation": _booster,
    "engine_braking": _engine_braking,
    "driveline_drag": _driveline_drag,
    "wheel_inertia_reflected": _reflected_inertia,
    "differential_locking": _differential,
    "tone_ring_error": _tone_ring,
    "pressure_sensor_lag": _pressure_lag,
}
