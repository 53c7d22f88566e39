"""Effects of the tyres and the wheels' radii."""

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)
_LATERAL = ("lateral_acceleration", "yaw_rate")


def _tyre(
    name: str,
    equation: str,
    parameters: tuple[EffectParameter, ...],
    signals: tuple[str, ...],
    confounded_with: tuple[str, ...],
    separating_manoeuvre: str,
    source: str,
    remarks: str = "",
) -> Effect:
    return Effect(
        name=name,
        group=Group.TYRE,
        application=Application.PLANT,
        equation=equation,
        parameters=parameters,
        signals=signals,
        separating_manoeuvre=separating_manoeuvre,
        confounded_with=confounded_with,
        source=source,
        remarks=remarks,
    )


def _radius(wheel: str) -> EffectParameter:
    return EffectParameter(wheel, "1", -0.03, 0.03, 0.002, 0.012, f"wheels.{wheel}.radius")


_PACEJKA = "Pacejka, Tire and Vehicle Dynamics, 3rd ed."

TYRE_EFFECTS: tuple[Effect, ...] = (
    _tyre(
        "tyre_friction",
        "mu <- (1 + d) mu, by axle",
        (
            EffectParameter("front", "1", -0.85, 0.5, 0.03, 0.18, "wheels.f*.friction_factor"),
            EffectParameter("rear", "1", -0.85, 0.5, 0.03, 0.18, "wheels.r*.friction_factor"),
        ),
        ("longitudinal_acceleration", *_WHEEL_SPEEDS, *_LATERAL),
        ("tyre_load_sensitivity", "road_grade", "mu_step"),
        "full stop on a level road, and the same at half load",
        f"{_PACEJKA}, 4.3.2 (scale factor of the peak)",
        "seen only near the limit: below it the slip stiffness acts",
    ),
    _tyre(
        "tyre_longitudinal_stiffness",
        "K_kappa <- (1 + d) K_kappa",
        (EffectParameter("factor", "1", -0.5, 1.0, 0.03, 0.2, "tyres.*.longitudinal.stiffness"),),
        _WHEEL_SPEEDS,
        ("wheel_radius_change",),
        "three brake levels of 2, 4 and 6 m/s^2: slip by force, not a constant ratio",
        f"{_PACEJKA}, 4.3.2 (scale factor of the slip stiffness)",
    ),
    _tyre(
        "tyre_cornering_stiffness",
        "K_alpha <- (1 + d) K_alpha, by axle",
        (
            EffectParameter("front", "1", -0.4, 0.5, 0.03, 0.15, "tyres.front.lateral.stiffness"),
            EffectParameter("rear", "1", -0.4, 0.5, 0.03, 0.15, "tyres.rear.lateral.stiffness"),
        ),
        _LATERAL,
        ("steering_ratio", "yaw_inertia", "steering_compliance", "cg_longitudinal"),
        "steady circle and sine sweep from 0.2 to 3 Hz",
        f"{_PACEJKA}, 4.3.2 (scale factor of the cornering stiffness)",
    ),
    _tyre(
        "tyre_load_sensitivity",
        "mu(Fz) = mu_0 (1 - (c + d) (Fz/Fz0 - 1))",
        (EffectParameter("loss", "1", -0.3, 0.35, 0.01, 0.08, "tyres.*.load_sensitivity", relative=False),),
        ("longitudinal_acceleration", *_WHEEL_SPEEDS, *_LATERAL),
        ("cg_height_change", "brake_balance", "tyre_friction"),
        "limit stop, limit circle, and both at another load",
        f"{_PACEJKA}, 4.3.2 (PDX2, PDY2)",
    ),
    _tyre(
        "tyre_relaxation_length",
        "sigma dkappa'/dt + |v| kappa' = |v| kappa, the same across; sigma <- sigma + d",
        (
            EffectParameter(
                "length", "m", -0.6, 0.8, 0.01, 0.15, "tyres.*.relaxation_length_*", relative=False, never_negative=True
            ),
        ),
        (*_WHEEL_SPEEDS, "yaw_rate"),
        ("wheel_speed_delay", "caliper_lag"),
        "pressure pulses at two speeds: this lag shrinks with speed, the others do not",
        f"{_PACEJKA}, 7.2",
    ),
    _tyre(
        "tyre_peak_shape",
        "g(1) <- g(1) - d_s at slip 1, kappa_peak <- (1 + d_k) kappa_peak at the same stiffness",
        (
            EffectParameter("sliding_loss", "1", -0.3, 0.4, 0.01, 0.1, relative=False),
            EffectParameter("peak_slip", "1", -0.4, 0.8, 0.03, 0.2),
        ),
        _WHEEL_SPEEDS,
        ("tyre_friction", "wheel_inertia_reflected"),
        "ABS stop and a slide with locked wheels",
        f"{_PACEJKA}, 4.3.2 (shape and curvature factors)",
    ),
    _tyre(
        "tyre_temperature_fade",
        "C dT/dt = F v_s / 2 - b T, mu <- mu (1 - c T^2), T the tread's rise, C = 5.4 kJ/K, b = C/60 s",
        (EffectParameter("coefficient", "1/K^2", 0.0, 5e-5, 0.0, 1e-5, relative=False),),
        ("longitudinal_acceleration", *_WHEEL_SPEEDS),
        ("brake_pad_fade", "tyre_friction"),
        "repeated stops at and below the limit",
        "lumped tread: half of the sliding power warms 3 kg of rubber",
    ),
    _tyre(
        "tyre_velocity_fade",
        "mu <- mu (1 - a v)",
        (EffectParameter("slope", "s/m", 0.0, 0.01, 3e-4, 0.003, relative=False),),
        ("longitudinal_acceleration", *_WHEEL_SPEEDS),
        ("aero_lift_front_rear", "brake_pad_speed", "tyre_friction"),
        "limit stops from 40 and from 100 km/h",
        "Burckhardt, Fahrwerktechnik: Radschlupf-Regelsysteme (c4)",
    ),
    _tyre(
        "tyre_camber_conicity",
        "Fy <- Fy + gamma Fz + F_c, all wheels",
        (
            EffectParameter("camber", "rad", -0.06, 0.06, 0.001, 0.015, relative=False),
            EffectParameter("conicity", "N", -200.0, 200.0, 5.0, 70.0, relative=False),
        ),
        _LATERAL,
        ("steering_offset", "road_bank", "gyro_offset"),
        "the same straight road in both directions",
        f"{_PACEJKA}, 4.3.2 (SHy, SVy); camber stiffness 1/rad of the load",
    ),
    _tyre(
        "tyre_ageing_pressure",
        "p <- (1 + d) p: K_alpha ~ p^0.4, K_kappa ~ p^-0.1, sigma ~ p^-0.3, f0 ~ p^-0.4, R = R0 - Fz/(k p)",
        (EffectParameter("pressure", "1", -0.4, 0.4, 0.02, 0.13),),
        (*_WHEEL_SPEEDS, *_LATERAL),
        ("wheel_radius_change", "rolling_resistance", "tyre_cornering_stiffness"),
        "one cause for several small shifts: coast-down, circle and constant speed together",
        "Besselink, Schmeitz, Pacejka 2010 (pressure terms of MF 6.1), rounded exponents",
    ),
    _tyre(
        "rolling_resistance",
        "F = Fz f0 (1 + d) (1 + f1 v)",
        (
            EffectParameter("constant", "1", -0.7, 1.5, 0.05, 0.35, "wheels.*.rolling_resistance"),
            EffectParameter("speed", "s/m", -0.005, 0.03, 0.001, 0.008, relative=False),
        ),
        ("longitudinal_acceleration", "speed"),
        ("brake_drag_torque", "road_grade", "aero_drag"),
        "coast-down from 100 to 10 km/h in both directions, with hot and with cold brakes",
        "ISO 28580 for the usual range",
    ),
    _tyre(
        "wheel_radius_change",
        "R_i <- (1 + d_i) R_i",
        tuple(_radius(wheel) for wheel in WHEELS),
        _WHEEL_SPEEDS,
        ("tyre_ageing_pressure",),
        "none: a scale of the wheel speed is the same effect; the load's part shows in a circle",
        "usual tolerance and wear of tyres",
    ),
    _tyre(
        "wheel_radius_load",
        "R = R0 - q_F (Fz - Fz_rest) + q_v v^2",
        (
            EffectParameter("load", "m/N", -2e-7, 2e-6, 2e-8, 4e-7, relative=False),
            EffectParameter("speed", "s^2/m", -1e-6, 5e-6, 1e-7, 1.2e-6, relative=False),
        ),
        _WHEEL_SPEEDS,
        ("wheel_radius_change",),
        "constant speeds from 30 to 150 km/h",
        f"{_PACEJKA}, 9.3 (effective rolling radius)",
    ),
)
