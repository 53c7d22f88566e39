"""Effects of the wheel brakes: pads, discs, calipers."""

from functools import partial

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)
_BRAKING = ("longitudinal_acceleration", *_WHEEL_SPEEDS)
_SAE = "pad friction over pressure and speed, SAE 740415"
_LUMPED = "usual lumped brake model"


_brake = partial(Effect, group=Group.BRAKE, application=Application.PLANT, signals=_BRAKING, remarks="")


def _absolute(
    name: str, unit: str, low: float, high: float, scatter: float, width: float, path: str = ""
) -> EffectParameter:
    return EffectParameter(name, unit, low, high, scatter, width, path, relative=False)


BRAKE_EFFECTS: tuple[Effect, ...] = (
    _brake(
        name="brake_pad_friction",
        equation="T_b <- (1 + d) T_b, all wheels",
        parameters=(EffectParameter("factor", "1", -0.6, 0.6, 0.03, 0.15, "brakes.*.pad_friction"),),
        confounded_with=("pressure_sensor_scale", "mass_change"),
        separating_manoeuvre="a pressure reference or a torque wheel; mass shows in driving and coasting too",
        source=_LUMPED,
        remarks="exactly equal to the scale of the pressure sensors where their pressures drive the replay",
    ),
    _brake(
        name="brake_pad_speed",
        equation="mu_p <- mu_p (v_r/10 m/s)^b, v_r the rubbing speed",
        parameters=(_absolute("exponent", "1", -0.4, 0.4, 0.01, 0.1, "brakes.*.pad_speed_exponent"),),
        confounded_with=("aero_drag", "brake_in_stop_rise", "tyre_velocity_fade"),
        separating_manoeuvre="the same pressure from two speeds; the air from a coast-down",
        source=_SAE,
    ),
    _brake(
        name="brake_pad_pressure",
        equation="T ~ (p/30 bar)^a",
        parameters=(_absolute("exponent", "1", -0.3, 0.3, 0.01, 0.08, "brakes.*.pad_pressure_exponent"),),
        confounded_with=("brake_threshold", "caliper_air"),
        separating_manoeuvre="staircase of pressures",
        source=_SAE,
    ),
    _brake(
        name="brake_pad_fade",
        equation="C dT/dt = T_b w - h (T - T_a), mu_p <- mu_p (1 - c max(T - T_f, 0))",
        parameters=(
            _absolute("coefficient", "1/degC", 0.0, 5e-3, 0.0, 8e-4, "brakes.*.fade"),
            _absolute("temperature", "degC", -250.0, 200.0, 10.0, 80.0, "brakes.*.fade_temperature"),
        ),
        confounded_with=("brake_pad_friction", "tyre_temperature_fade"),
        separating_manoeuvre="six stops or more in a row, then cooling",
        source=_LUMPED,
        remarks="without a disc hotter than the fade temperature the data says nothing",
    ),
    _brake(
        name="brake_in_stop_rise",
        equation="mu_p <- mu_p (1 + a E/E0), E the braking energy since release, E0 that of a stop from 100 km/h",
        parameters=(_absolute("rise", "1", -0.2, 0.4, 0.01, 0.1),),
        confounded_with=("brake_pad_speed", "brake_pad_fade"),
        separating_manoeuvre="stops from different speeds to an end speed above zero",
        source="usual in-stop rise of cold pads",
    ),
    _brake(
        name="brake_hysteresis",
        equation="the torque falls only after the pressure fell by dp",
        parameters=(_absolute("pressure", "Pa", 0.0, 5e5, 1e4, 1.2e5),),
        confounded_with=("caliper_lag",),
        separating_manoeuvre="slow triangle of pressure: no rate acts on it",
        source="friction of the piston's seal",
    ),
    _brake(
        name="brake_threshold",
        equation="T = k max(p - p0 - d, 0)",
        parameters=(
            EffectParameter(
                "pressure",
                "Pa",
                -1e6,
                4e5,
                1e4,
                9e4,
                "brakes.*.threshold_pressure",
                relative=False,
                never_negative=True,
            ),
        ),
        confounded_with=("pressure_sensor_offset",),
        separating_manoeuvre="none by driving: zero check of the pressure sensors at rest",
        source=_LUMPED,
    ),
    _brake(
        name="brake_drag_torque",
        equation="T_i <- T_i + d_i without pressure",
        parameters=tuple(_absolute(w, "N m", 0.0, 100.0, 1.0, 18.0, f"brakes.drag_torque_{w}") for w in WHEELS),
        confounded_with=("rolling_resistance", "road_grade", "driveline_drag"),
        separating_manoeuvre="coast-down with hot and with cold brakes, wheel by wheel",
        source=_LUMPED,
        signals=("longitudinal_acceleration", "speed", *_WHEEL_SPEEDS),
    ),
    _brake(
        name="brake_balance",
        equation="k_f <- k_f (1 + b), k_r <- k_r (1 - b k_f/k_r)",
        parameters=(EffectParameter("shift", "1", -0.25, 0.25, 0.02, 0.09, relative=False),),
        confounded_with=("cg_height_change", "tyre_load_sensitivity", "wheel_brake_weak"),
        separating_manoeuvre="low and high deceleration",
        source=_LUMPED,
    ),
    _brake(
        name="wheel_brake_weak",
        equation="T_i <- (1 + d_i) T_i",
        parameters=tuple(EffectParameter(w, "1", -1.0, 0.2, 0.01, 0.2, f"brakes.pad_glazing_{w}") for w in WHEELS),
        confounded_with=("mu_split", "wheel_radius_change"),
        separating_manoeuvre="straight stops on two roads: yaw and that wheel's slip",
        source=_LUMPED,
        signals=(*_BRAKING, "yaw_rate"),
        remarks="the file's parameter is the lost share, 1 less the factor",
    ),
    _brake(
        name="disc_thickness_variation",
        equation="T_i <- T_i (1 + s sin phi + c cos phi), phi the wheel's turning since the start",
        parameters=tuple(
            _absolute(f"{w}_{part}", "1", -0.2, 0.2, 1e-3, 0.04) for w in WHEELS for part in ("sine", "cosine")
        ),
        confounded_with=("tone_ring_error",),
        separating_manoeuvre="constant light braking: the ring shows without braking too",
        source="first order of brake judder",
    ),
    _brake(
        name="caliper_lag",
        equation="tau dT/dt + T = k p",
        parameters=(
            EffectParameter(
                "time_constant",
                "s",
                -0.1,
                0.12,
                0.002,
                0.025,
                "brakes.caliper_time_constant",
                relative=False,
                never_negative=True,
            ),
        ),
        confounded_with=("tyre_relaxation_length", "wheel_speed_delay", "pressure_sensor_lag", "brake_hysteresis"),
        separating_manoeuvre="pressure pulses at two speeds",
        source=_LUMPED,
    ),
)
