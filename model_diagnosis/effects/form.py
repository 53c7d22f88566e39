"""Differences of form between cars and the replay, as deviations that are allowed but never named.

What a model describes differently (how a contact patch follows a rolling body, how stiff a tyre stands under its rim, a
sensor's own lag) would otherwise go into whatever effect is determined weakest (model discrepancy anchor, sections 3.4a
and 4.3). Each is a column of the replay with its own scatter, so that what it explains is taken out of all evidence.
"""

from model_diagnosis.effects.catalogue import EFFECTS
from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)
_WHEEL_PRESSURES = tuple(f"brake_pressure_{wheel}" for wheel in WHEELS)
_MOTION = ("lateral_acceleration", "longitudinal_acceleration", "yaw_rate", "roll_rate", "pitch_rate")


def _form(name: str, group: Group, equation: str, signals: tuple[str, ...], *parameters: EffectParameter) -> Effect:
    return Effect(name, group, Application.PLANT, equation, parameters, signals, "none: not a cause")


FORM_EFFECTS: tuple[Effect, ...] = (
    _form(
        "form_contact_scrub",
        Group.SUSPENSION,
        "v_contact = v + (1 + d)(roll rate or pitch rate) h - (1 + d_links) tan(link) travel rate: real ones carry the "
        "wheel along less, and their bushings give way",
        _MOTION,
        EffectParameter("roll", "1", -1.0, 0.3, 0.5, 0.5),
        EffectParameter("pitch", "1", -1.0, 0.3, 0.5, 0.5),
        # a rigid link (0) and none (-1) are 0.7 of this scatter from their middle, as likely as each other
        EffectParameter("links", "1", -1.5, 0.5, 0.7, 0.7),
    ),
    _form(
        "form_guide_lean",
        Group.SUSPENSION,
        "wheels move along (1 + d) of the body's lean: real links keep them more upright than a slide in the body",
        _MOTION,
        EffectParameter("share", "1", -1.0, 0.5, 1.0, 1.0),
    ),
    _form(
        "form_support",
        Group.SUSPENSION,
        "links push up each side by F_x tan(eps) of its own wheel, or of both wheels' mean (d = -1): a rigid axle",
        ("roll_rate",),
        EffectParameter("apart", "1", -1.0, 0.3, 1.0, 1.0),
    ),
    _form(
        "form_heave",
        Group.SUSPENSION,
        "a share d of what the links lift in all does not heave the body: one that only pitches holds it by its weight",
        (*_MOTION, *_WHEEL_SPEEDS),
        EffectParameter("held", "1", -0.5, 1.3, 1.0, 1.0),
    ),
    _form(
        "form_weight_arm",
        Group.BODY,
        "the weight tips the body by m g (h - R + d): it turns about its wheels' axes, its roll axis or the ground",
        ("roll_rate", "pitch_rate"),
        EffectParameter("roll", "m", -0.2, 0.4, 0.25, 0.25, relative=False),
        EffectParameter("pitch", "m", -0.2, 0.4, 0.25, 0.25, relative=False),
    ),
    _form(
        "form_pitch_pole",
        Group.BODY,
        "the body pitches about a point d of the way from its centre of gravity to the springs' centre (1: no heave)",
        ("pitch_rate",),
        EffectParameter("share", "1", -0.5, 1.5, 1.0, 1.0),
    ),
    _form(
        "form_transient",
        Group.TYRE,
        "a share d of the relaxation lengths lets the force follow, the rest lets the slip: apart near the limit",
        (*_MOTION, *_WHEEL_SPEEDS),
        EffectParameter("share", "1", 0.0, 1.0, 1.0, 1.0),
    ),
    _form(
        "form_trail",
        Group.TYRE,
        "n = n_0 (1 - s/s_peak)(1 + d s/s_peak): straight down to the peak (brush), or a parabola (d = 1); s is the "
        "whole slip, or by a share d_across the slip across alone",
        _MOTION,
        EffectParameter("bulge", "1", -1.0, 3.0, 1.0, 1.0),
        EffectParameter("across", "1", 0.0, 1.0, 1.0, 1.0),
    ),
    _form(
        "form_steering_link",
        Group.STEERING,
        "a share d of the difference between the front wheels' aligning moments turns neither: the rack and the column "
        "yield to their sum, only the tie rods to each wheel's own",
        _MOTION,
        EffectParameter("share", "1", 0.0, 1.0, 1.0, 1.0),
    ),
    _form(
        "form_tyre_spring",
        Group.TYRE,
        "1/k_t <- (1 + d)/k_t, the tyre's vertical compliance in series with the springs: -1 is a rigid tyre",
        ("roll_rate", "pitch_rate"),
        EffectParameter("compliance", "1", -0.98, 3.0, 1.0, 1.0),
    ),
    _form(
        "form_wheel_inertia",
        Group.DRIVELINE,
        "J_w <- (1 + d) J_w of an axle's wheels: a number of the data sheet that is off, and no cause of its own",
        (*_WHEEL_SPEEDS, "longitudinal_acceleration"),
        EffectParameter("front", "1", -0.3, 0.3, 0.03, 0.03, "wheels.f*.inertia"),
        EffectParameter("rear", "1", -0.3, 0.3, 0.03, 0.03, "wheels.r*.inertia"),
    ),
    _form(
        "form_body_inertia",
        Group.BODY,
        "I_xx <- (1 + d) I_xx, I_yy <- (1 + d) I_yy of the sprung body",
        ("roll_rate", "pitch_rate"),
        EffectParameter("roll", "1", -0.4, 1.0, 0.25, 0.25),
        EffectParameter("pitch", "1", -0.4, 1.0, 0.25, 0.25),
    ),
    _form(
        "form_damper_split",
        Group.SUSPENSION,
        "c_compression <- (1 + d) c_compression, c_rebound falls by as much",
        ("roll_rate", "pitch_rate"),
        EffectParameter("share", "1", -0.6, 0.6, 0.25, 0.25),
    ),
    _form(
        "form_axles_alike",
        Group.SUSPENSION,
        "k <- (1 + d + d_axle) k of both axles: what is off at one axle of a car is half off at the other",
        _MOTION,
        *(
            EffectParameter(name, unit, low, high, scatter, scatter, relative=unit == "1", common_path=path)
            for name, unit, low, high, scatter, path in (
                ("spring_rate", "1", -0.3, 0.3, 0.03, "suspension.*.spring_rate"),
                ("damping", "1", -0.5, 0.5, 0.05, "suspension.*.damping_scale"),
                ("anti_roll_rate", "1", -0.5, 0.5, 0.05, "suspension.*.anti_roll_rate"),
                ("roll_centre_height", "m", -0.1, 0.1, 0.01, "suspension.*.roll_centre_height"),
                ("support_angle", "rad", -0.1, 0.1, 0.01, "suspension.*.brake_support_angle"),
                ("friction_factor", "1", -0.3, 0.3, 0.03, "wheels.*.friction_factor"),
            )
        ),
    ),
    _form(
        "form_inferred_braking",
        Group.DRIVELINE,
        "the front axle's share of braking that no channel tells is the pads' + d: part of it may be the engine's",
        _WHEEL_SPEEDS,
        EffectParameter("front", "1", -1.0, 1.0, 0.3, 0.3, relative=False),
    ),
    _form(
        "form_lag",
        Group.SENSOR,
        "tau <- tau + d of accelerometers, gyro, wheel speeds, speed and steering; loggers align by whole samples",
        _MOTION,
        EffectParameter("accelerometer", "s", -0.003, 0.02, 0.003, 0.003, relative=False),
        EffectParameter("gyro", "s", -0.02, 0.02, 0.003, 0.003, relative=False),
        EffectParameter("wheel_speed", "s", -0.02, 0.02, 0.003, 0.003, relative=False),
        # half a sample of the shift, and 5 ms by which the car's pitch leads the correlation astray
        EffectParameter("speed", "s", -0.02, 0.02, 0.006, 0.006, relative=False),
        EffectParameter("steering", "1", -0.9, 4.0, 0.3, 0.3),
    ),
)

FORM_HYDRAULICS_EFFECTS: tuple[Effect, ...] = (
    _form(
        "form_build_up",
        Group.HYDRAULICS,
        "tau <- (1 + d) tau of the pressure's build-up at all wheels: a number of the data sheet that is off",
        _WHEEL_PRESSURES,
        EffectParameter("time_constant", "1", -0.5, 1.0, 0.03, 0.03, "hydraulics.increase_time_constant"),
    ),
    _form(
        "form_release",
        Group.HYDRAULICS,
        "tau <- (1 + d) tau of the pressure's release at all wheels: a number of the data sheet that is off",
        _WHEEL_PRESSURES,
        EffectParameter("time_constant", "1", -0.5, 1.0, 0.03, 0.03, "hydraulics.decrease_time_constant"),
    ),
    _form(
        "form_return",
        Group.HYDRAULICS,
        "p falls to a lower supply by tau dp/dt = p_supply - p, past a check valve that throttles",
        _WHEEL_PRESSURES,
        EffectParameter("lag", "s", 0.0, 0.05, 0.01, 0.01, relative=False),
    ),
    _form(
        "form_pump_back_pressure",
        Group.HYDRAULICS,
        "p_outlet = d p_accumulator while the pump runs: a weak pump does not keep the line behind the outlets empty",
        _WHEEL_PRESSURES,
        EffectParameter("share", "1", 0.0, 1.0, 0.3, 0.3, "hydraulics.pump_back_pressure", relative=False),
    ),
    _form(
        "form_booster",
        Group.HYDRAULICS,
        "tau dp/dt + p = k_b F_pedal",
        ("master_pressure",),
        EffectParameter("lag", "s", 0.0, 0.3, 0.04, 0.04, relative=False),
    ),
    _form(
        "form_valve_overlap",
        Group.HYDRAULICS,
        "V <- V - q_in d as an inlet valve closes and the outlet valve opens: what passes both fills no accumulator",
        _WHEEL_PRESSURES,
        EffectParameter("time", "s", 0.0, 0.01, 0.001, 0.001, relative=False),
    ),
)
"""Those that act before the wheel brakes."""

_RIG_FORCES = ("longitudinal_force_fl", "lateral_force_fl")

FORM_RIG_EFFECTS: tuple[Effect, ...] = (
    _form(
        "form_rig_forces",
        Group.SENSOR,
        "F_x <- F_x + a F_z + b_x, F_y <- F_y + b_y, each later by tau: what a hub's load cells read of a tyre's force",
        _RIG_FORCES,
        # a slip that is counted from free rolling leaves the rolling resistance in the force along
        EffectParameter("rolling", "1", -0.05, 0.05, 0.02, 0.02, relative=False),
        EffectParameter("offset_along", "N", -100.0, 100.0, 10.0, 10.0, relative=False),
        EffectParameter("offset_across", "N", -100.0, 100.0, 10.0, 10.0, relative=False),
        EffectParameter("lag", "s", -0.02, 0.02, 0.003, 0.003, relative=False),
    ),
    _form(
        "form_rig_slips",
        Group.SENSOR,
        "alpha <- alpha + d_alpha, kappa <- kappa + d_kappa: where a rig's slips are 0",
        _RIG_FORCES,
        EffectParameter("angle", "rad", -0.01, 0.01, 0.001, 0.001, relative=False),
        EffectParameter("ratio", "1", -0.02, 0.02, 0.002, 0.002, relative=False),
    ),
)
"""Those of one wheel on a rig.

Scatters are assumed: 0.02 is a whole rolling resistance, 10 N some thousandths of a hub's range, 1 mrad and 0.002
the care with which slips are set to 0; 3 ms is the lag's scatter of every sensor above.
"""

OTHER_FORMS = {"form_transient.share": 1.0}
"""Columns that stand for a choice between two forms, and their value in the other one; between the two no way leads."""

FORM_NAMES = frozenset(effect.name for effect in (*FORM_EFFECTS, *FORM_HYDRAULICS_EFFECTS, *FORM_RIG_EFFECTS))
"""Names of effects that are no causes."""

REPLAYED: tuple[Effect, ...] = (*EFFECTS, *FORM_EFFECTS, *FORM_HYDRAULICS_EFFECTS)
"""What a replay carries: the catalogue, and what is allowed without ever being named."""
