"""Effects of the tyres and the wheels' radii."""

from functools import partial

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)
_LATERAL = ("lateral_acceleration", "yaw_rate")


_tyre = partial(Effect, group=Group.TYRE, application=Application.PLANT, remarks="")


def _radius(wheel: str) -> EffectParameter:
    return EffectParameter(wheel, "1", -0.03, 0.03, 0.002, 0.012, f"wheels.{wheel}.radius")


_PACEJKA = "Pacejka, Tire and Vehicle Dynamics, 3rd ed."

TYRE_EFFECTS: tuple[Effect, ...] = (
    _tyre(
        name="tyre_friction",
        equation="mu <- (1 + d) mu, by axle",
        parameters=(
            EffectParameter("front", "1", -0.85, 0.5, 0.03, 0.18, "wheels.f*.friction_factor"),
            EffectParameter("rear", "1", -0.85, 0.5, 0.03, 0.18, "wheels.r*.friction_factor"),
        ),
        signals=("longitudinal_acceleration", *_WHEEL_SPEEDS, *_LATERAL),
        confounded_with=("tyre_load_sensitivity", "road_grade", "mu_step"),
        separating_manoeuvre="full stop on a level road, and the same at half load",
        source=f"{_PACEJKA}, 4.3.2 (scale factor of the peak)",
        remarks="seen only near the limit: below it the slip stiffness acts",
        needs_limit=True,
    ),
    _tyre(
        name="tyre_longitudinal_stiffness",
        equation="K_kappa <- (1 + d) K_kappa",
        parameters=(EffectParameter("factor", "1", -0.5, 1.0, 0.03, 0.2, "tyres.*.longitudinal.stiffness"),),
        signals=_WHEEL_SPEEDS,
        confounded_with=("wheel_radius_change",),
        separating_manoeuvre="three brake levels of 2, 4 and 6 m/s^2: slip by force, not a constant ratio",
        source=f"{_PACEJKA}, 4.3.2 (scale factor of the slip stiffness)",
    ),
    _tyre(
        name="tyre_cornering_stiffness",
        equation="K_alpha <- (1 + d) K_alpha, by axle",
        parameters=(
            EffectParameter("front", "1", -0.4, 0.5, 0.03, 0.15, "tyres.front.lateral.stiffness"),
            EffectParameter("rear", "1", -0.4, 0.5, 0.03, 0.15, "tyres.rear.lateral.stiffness"),
        ),
        signals=_LATERAL,
        confounded_with=("steering_ratio", "yaw_inertia", "steering_compliance", "cg_longitudinal"),
        separating_manoeuvre="steady circle and sine sweep from 0.2 to 3 Hz",
        source=f"{_PACEJKA}, 4.3.2 (scale factor of the cornering stiffness)",
    ),
    _tyre(
        name="tyre_load_sensitivity",
        equation="mu(Fz) = mu_0 (1 - (c + d) (Fz/Fz0 - 1))",
        parameters=(EffectParameter("loss", "1", -0.3, 0.35, 0.01, 0.08, "tyres.*.load_sensitivity", relative=False),),
        signals=("longitudinal_acceleration", *_WHEEL_SPEEDS, *_LATERAL),
        confounded_with=("cg_height_change", "brake_balance", "tyre_friction"),
        separating_manoeuvre="limit stop, limit circle, and both at another load",
        source=f"{_PACEJKA}, 4.3.2 (PDX2, PDY2)",
        needs_limit=True,
    ),
    _tyre(
        name="tyre_relaxation_length",
        equation="sigma dkappa'/dt + |v| kappa' = |v| kappa, the same across; sigma <- sigma + d",
        parameters=(
            EffectParameter(
                "length", "m", -0.6, 0.8, 0.01, 0.15, "tyres.*.relaxation_length_*", relative=False, never_negative=True
            ),
        ),
        signals=(*_WHEEL_SPEEDS, "yaw_rate"),
        confounded_with=("wheel_speed_delay", "caliper_lag"),
        separating_manoeuvre="pressure pulses at two speeds: this lag shrinks with speed, the others do not",
        source=f"{_PACEJKA}, 7.2",
    ),
    _tyre(
        name="tyre_peak_shape",
        equation="g(1) <- g(1) - d_s at slip 1, kappa_peak <- (1 + d_k) kappa_peak at the same stiffness",
        parameters=(
            EffectParameter("sliding_loss", "1", -0.3, 0.4, 0.01, 0.1, relative=False),
            EffectParameter("peak_slip", "1", -0.4, 0.8, 0.03, 0.2),
        ),
        signals=_WHEEL_SPEEDS,
        confounded_with=("tyre_friction", "wheel_inertia_reflected"),
        separating_manoeuvre="ABS stop and a slide with locked wheels",
        source=f"{_PACEJKA}, 4.3.2 (shape and curvature factors)",
        needs_limit=True,
    ),
    _tyre(
        name="tyre_temperature_fade",
        equation="C dT/dt = F v_s / 2 - b T, mu <- mu (1 - c T^2), T the tread's rise, C = 5.4 kJ/K, b = C/60 s",
        parameters=(EffectParameter("coefficient", "1/K^2", 0.0, 5e-5, 0.0, 1e-5, relative=False),),
        signals=("longitudinal_acceleration", *_WHEEL_SPEEDS),
        confounded_with=("brake_pad_fade", "tyre_friction"),
        separating_manoeuvre="repeated stops at and below the limit",
        source="lumped tread: half of the sliding power warms 3 kg of rubber",
        needs_limit=True,
    ),
    _tyre(
        name="tyre_velocity_fade",
        equation="mu <- mu (1 - a v)",
        parameters=(EffectParameter("slope", "s/m", 0.0, 0.01, 3e-4, 0.003, relative=False),),
        signals=("longitudinal_acceleration", *_WHEEL_SPEEDS),
        confounded_with=("aero_lift_front_rear", "brake_pad_speed", "tyre_friction"),
        separating_manoeuvre="limit stops from 40 and from 100 km/h",
        source="Burckhardt, Fahrwerktechnik: Radschlupf-Regelsysteme (c4)",
        needs_limit=True,
    ),
    _tyre(
        name="tyre_camber_conicity",
        equation="Fy <- Fy + gamma Fz + F_c, all wheels",
        parameters=(
            EffectParameter("camber", "rad", -0.06, 0.06, 0.001, 0.015, relative=False),
            EffectParameter("conicity", "N", -200.0, 200.0, 5.0, 70.0, relative=False),
        ),
        signals=_LATERAL,
        confounded_with=("steering_offset", "road_bank", "gyro_offset"),
        separating_manoeuvre="the same straight road in both directions",
        source=f"{_PACEJKA}, 4.3.2 (SHy, SVy); camber stiffness 1/rad of the load",
    ),
    _tyre(
        name="tyre_ageing_pressure",
        equation="p <- (1 + d) p: K_alpha ~ p^0.4, K_kappa ~ p^-0.1, sigma ~ p^-0.3, f0 ~ p^-0.4, R = R0 - Fz/(k p)",
        parameters=(EffectParameter("pressure", "1", -0.4, 0.4, 0.02, 0.13),),
        signals=(*_WHEEL_SPEEDS, *_LATERAL),
        confounded_with=("wheel_radius_change", "rolling_resistance", "tyre_cornering_stiffness"),
        separating_manoeuvre="one cause for several small shifts: coast-down, circle and constant speed together",
        source="Besselink, Schmeitz, Pacejka 2010 (pressure terms of MF 6.1), rounded exponents",
    ),
    _tyre(
        name="rolling_resistance",
        equation="F = Fz f0 (1 + d + f1 v)",
        parameters=(
            EffectParameter("constant", "1", -0.75, 1.5, 0.05, 0.35, "wheels.*.rolling_resistance"),
            EffectParameter("speed", "s/m", -0.005, 0.03, 0.001, 0.008, relative=False),
        ),
        signals=("longitudinal_acceleration", "speed"),
        confounded_with=("brake_drag_torque", "road_grade", "aero_drag"),
        separating_manoeuvre="coast-down from 100 to 10 km/h in both directions, with hot and with cold brakes",
        source="ISO 28580 for the usual range",
    ),
    _tyre(
        name="wheel_radius_change",
        equation="R_i <- (1 + d_i) R_i",
        parameters=tuple(_radius(wheel) for wheel in WHEELS),
        signals=_WHEEL_SPEEDS,
        confounded_with=("tyre_ageing_pressure",),
        separating_manoeuvre="none: a scale of the wheel speed is the same effect; the load's part shows in a circle",
        source="usual tolerance and wear of tyres",
    ),
    _tyre(
        name="wheel_radius_load",
        equation="R = R0 - q_F (Fz - Fz_rest) + q_v v^2",
        parameters=(
            EffectParameter("load", "m/N", -2e-7, 2e-6, 2e-8, 4e-7, relative=False),
            EffectParameter("speed", "s^2/m", -1e-6, 5e-6, 1e-7, 1.2e-6, relative=False),
        ),
        signals=_WHEEL_SPEEDS,
        confounded_with=("wheel_radius_change",),
        separating_manoeuvre="constant speeds from 30 to 150 km/h",
        source=f"{_PACEJKA}, 9.3 (effective rolling radius)",
    ),
)
