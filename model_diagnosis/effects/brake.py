"""Effects of the wheel brakes: pads, discs, calipers."""

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)
_BRAKING = ("longitudinal_acceleration", *_WHEEL_SPEEDS)
_SAE = "pad friction over pressure and speed, SAE 740415"
_LUMPED = "usual lumped brake model"


def _brake(
    name: str,
    equation: str,
    parameters: tuple[EffectParameter, ...],
    confounded_with: tuple[str, ...],
    separating_manoeuvre: str,
    source: str,
    signals: tuple[str, ...] = _BRAKING,
    remarks: str = "",
) -> Effect:
    return Effect(
        name=name,
        group=Group.BRAKE,
        application=Application.PLANT,
        equation=equation,
        parameters=parameters,
        signals=signals,
        separating_manoeuvre=separating_manoeuvre,
        confounded_with=confounded_with,
        source=source,
        remarks=remarks,
    )


def _absolute(
    name: str, unit: str, low: float, high: float, scatter: float, width: float, path: str = ""
) -> EffectParameter:
    return EffectParameter(name, unit, low, high, scatter, width, path, relative=False)


BRAKE_EFFECTS: tuple[Effect, ...] = (
    _brake(
        "brake_pad_friction",
        "T_b <- (1 + d) T_b, all wheels",
        (EffectParameter("factor", "1", -0.6, 0.6, 0.03, 0.15, "brakes.*.pad_friction"),),
        ("pressure_sensor_scale", "mass_change"),
        "a pressure reference or a torque wheel; mass shows in driving and coasting too",
        _LUMPED,
        remarks="exactly equal to the scale of the pressure sensors where their pressures drive the replay",
    ),
    _brake(
        "brake_pad_speed",
        "mu_p <- mu_p (v_r/10 m/s)^b, v_r the rubbing speed",
        (_absolute("exponent", "1", -0.4, 0.4, 0.01, 0.1, "brakes.*.pad_speed_exponent"),),
        ("aero_drag", "brake_in_stop_rise", "tyre_velocity_fade"),
        "the same pressure from two speeds; the air from a coast-down",
        _SAE,
    ),
    _brake(
        "brake_pad_pressure",
        "T ~ (p/30 bar)^a",
        (_absolute("exponent", "1", -0.3, 0.3, 0.01, 0.08, "brakes.*.pad_pressure_exponent"),),
        ("brake_threshold", "caliper_air"),
        "staircase of pressures",
        _SAE,
    ),
    _brake(
        "brake_pad_fade",
        "C dT/dt = T_b w - h (T - T_a), mu_p <- mu_p (1 - c max(T - T_f, 0))",
        (
            _absolute("coefficient", "1/degC", 0.0, 5e-3, 0.0, 8e-4, "brakes.*.fade"),
            _absolute("temperature", "degC", -250.0, 200.0, 10.0, 80.0, "brakes.*.fade_temperature"),
        ),
        ("brake_pad_friction", "tyre_temperature_fade"),
        "six stops or more in a row, then cooling",
        _LUMPED,
        remarks="without a disc hotter than the fade temperature the data says nothing",
    ),
    _brake(
        "brake_in_stop_rise",
        "mu_p <- mu_p (1 + a E/E0), E the braking energy since release, E0 that of a stop from 100 km/h",
        (_absolute("rise", "1", -0.2, 0.4, 0.01, 0.1),),
        ("brake_pad_speed", "brake_pad_fade"),
        "stops from different speeds to an end speed above zero",
        "usual in-stop rise of cold pads",
    ),
    _brake(
        "brake_hysteresis",
        "the torque falls only after the pressure fell by dp",
        (_absolute("pressure", "Pa", 0.0, 5e5, 1e4, 1.2e5),),
        ("caliper_lag",),
        "slow triangle of pressure: no rate acts on it",
        "friction of the piston's seal",
    ),
    _brake(
        "brake_threshold",
        "T = k max(p - p0 - d, 0)",
        (
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
        ("pressure_sensor_offset",),
        "none by driving: zero check of the pressure sensors at rest",
        _LUMPED,
    ),
    _brake(
        "brake_drag_torque",
        "T_i <- T_i + d_i without pressure",
        tuple(_absolute(w, "N m", 0.0, 100.0, 1.0, 18.0, f"brakes.drag_torque_{w}") for w in WHEELS),
        ("rolling_resistance", "road_grade", "driveline_drag"),
        "coast-down with hot and with cold brakes, wheel by wheel",
        _LUMPED,
        ("longitudinal_acceleration", "speed", *_WHEEL_SPEEDS),
    ),
    _brake(
        "brake_balance",
        "k_f <- k_f (1 + b), k_r <- k_r (1 - b k_f/k_r)",
        (EffectParameter("shift", "1", -0.25, 0.25, 0.02, 0.09),),
        ("cg_height_change", "tyre_load_sensitivity", "wheel_brake_weak"),
        "low and high deceleration",
        _LUMPED,
    ),
    _brake(
        "wheel_brake_weak",
        "T_i <- (1 + d_i) T_i",
        tuple(EffectParameter(w, "1", -1.0, 0.2, 0.01, 0.2, f"brakes.pad_glazing_{w}") for w in WHEELS),
        ("mu_split", "wheel_radius_change"),
        "straight stops on two roads: yaw and that wheel's slip",
        _LUMPED,
        (*_BRAKING, "yaw_rate"),
        remarks="the file's parameter is the lost share, 1 less the factor",
    ),
    _brake(
        "disc_thickness_variation",
        "T_i <- T_i (1 + s sin phi + c cos phi), phi the wheel's turning since the start",
        tuple(_absolute(f"{w}_{part}", "1", -0.2, 0.2, 1e-3, 0.04) for w in WHEELS for part in ("sine", "cosine")),
        ("tone_ring_error",),
        "constant light braking: the ring shows without braking too",
        "first order of brake judder",
    ),
    _brake(
        "caliper_lag",
        "tau dT/dt + T = k p",
        (
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
        ("tyre_relaxation_length", "wheel_speed_delay", "pressure_sensor_lag", "brake_hysteresis"),
        "pressure pulses at two speeds",
        _LUMPED,
    ),
)
