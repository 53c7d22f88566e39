"""Keys of the vehicle-state observers; defaults of the vehicle-state document where it prints any."""

from typing import Literal

from pydantic import Field

from estimators.channels import MOTION_INPUTS, TORQUE_INPUTS
from estimators.wheel_speed_settings import teeth_field, window_field
from signals.quantities import FileModel, parameter

_LISTING = "l. 5574-5660 [C]"
_OWN = "assumed"


class LateralSettings(FileModel):
    """Unscented filter of yaw and lateral motion (3.3)."""

    step_time: float = parameter("s", 0.01, low=0.001, high=0.1, description="step of the filter", source="1.3 [E]")
    noise: Literal["listing", "consistent"] = Field(
        default="consistent",
        description="listing: printed Q and R, with which the slopes follow every sample and nothing holds v_y "
        "(3.3 [E] 2); consistent: slow slopes, and R from the error of the measured friction over slip angle or curve",
    )
    alpha: float = parameter("1", 1.0, low=1e-3, high=1.0, description="spread of the sigma points", source="l. 1269")
    beta: float = parameter("1", 2.0, low=0.0, high=10.0, description="", source="l. 1273")
    kappa: float | None = parameter("1", None, low=-20.0, high=20.0, description="left out: 3 - n", source="l. 1275")
    redraw: bool = Field(
        default=True, description="draw the points anew before the update; false: as printed, exact only for Q = 0"
    )
    exact_arms: bool = Field(
        default=True, description="J_z/(m l) moves a_y to the axles; false: l_1, l_2 as printed (3.3 [E] 4)"
    )
    centripetal_term: bool = Field(
        default=False, description="w_z^2 B/2 counts as friction of a wheel, as printed (3.3 [E] 5)"
    )
    double_projection: bool = Field(
        default=False, description="the curve's front forces are projected twice, as printed (Annex B)"
    )
    roll_compensation: bool = Field(
        default=True, description="take g sin(roll) out of the lateral accelerometer, which leans with the body"
    )
    body_sway: bool = Field(
        default=False,
        description="slip angles know that the centre of gravity sways over the wheels by h times the roll rate; "
        "false: the document's flat car",
    )
    yaw_acceleration: Literal["filtered", "gyroscope"] = Field(
        default="filtered", description="difference of the filtered yaw rate (listing) or of the gyroscope's (text)"
    )
    hand_over: bool = Field(default=True, description="a fit's limit becomes the state's, variance 0.05 (AC-37)")
    gate_speed: float = parameter("m/s", 1.0, low=0.1, high=10.0, description="it rests below", source="l. 5333")
    smallest_slip_angle: float = parameter(
        "rad",
        0.0052360,
        low=0.0,
        high=0.1,
        description="pseudo measurements only above it, 0.3 deg",
        source="3.3 [E] 3",
    )
    signal_time_constant: float = parameter(
        "s", 0.03, low=0.0, high=1.0, description="low-pass of a_y, yaw acceleration and slip angles alike", source=_OWN
    )
    yaw_rate_delay: float = parameter(
        "s",
        0.012,
        low=0.0,
        high=0.1,
        description="mean age of the yaw rate in a step: its low-pass of 50 Hz, frames of 5 ms, mean over 10 ms",
        source=_OWN,
    )
    process_lateral_speed: float | None = parameter(
        "m^2/s^2", None, low=0.0, description="variance per step; listing 0.01, else 1e-6", source=_LISTING
    )
    process_yaw_rate: float | None = parameter(
        "rad^2/s^2", None, low=0.0, description="variance per step; listing 0.1, else 1e-5", source=_LISTING
    )
    process_slope: float | None = parameter(
        "1/rad^2", None, low=0.0, description="variance per step; listing 0.1, else 1e-3", source=_LISTING
    )
    process_limit: float = parameter(
        "1", 1e-5, low=0.0, description="variance per step above the threshold, noise: consistent", source=_OWN
    )
    measurement_yaw_rate: float | None = parameter(
        "rad^2/s^2", None, low=1e-10, description="variance; listing 0.0005, else 2.5e-5", source=_LISTING
    )
    measurement_slope: float = parameter(
        "1/rad^2", 0.001, low=1e-9, description="variance, noise: listing", source=_LISTING
    )
    measurement_friction: float = parameter(
        "1",
        0.02,
        low=1e-4,
        high=1.0,
        description="error of a wheel's measured friction, noise: consistent",
        source=_OWN,
    )
    initial_slope: float = parameter("1/rad", 8.0, low=0.5, high=60.0, description="k_y", source=_OWN)
    initial_limit: float = parameter("1", 0.6, low=0.05, high=1.3, description="mu_m", source=_OWN)
    initial_slope_deviation: float = parameter("1/rad", 3.0, low=0.0, description="of k_y", source=_OWN)
    stuck_after: float = parameter(
        "s", 0.1, low=0.01, high=10.0, description="unchanged lateral accelerometer that may be stuck", source=_OWN
    )
    stuck_difference: float = parameter(
        "m/s^2", 0.7, low=0.0, high=20.0, description="from v_x w_z, at which it is", source=_OWN
    )


class LongitudinalSettings(FileModel):
    """Sliding-mode observers of the wheels (3.5)."""

    integrators: Literal[1, 2] = Field(
        default=1, description="of the law; the text prints one integral sign, the listing has two (3.5)"
    )
    gain: float | None = parameter(
        "1/s^2", None, low=1.0, high=1e7, description="K_s; left out: 150000 (l. 3045) with two integrators, listing "
        "110000; 100 1/s (C.1) with one",
    )  # fmt: skip
    surface_error: float = parameter("1", 300.0, low=0.0, high=1e5, description="c_1", source="l. 3045")
    surface_rate: float = parameter("s", 12.0, low=0.0, high=1e4, description="c_2", source="l. 3045")
    reversal: bool = Field(
        default=True, description="turn the law for negative slip, where a larger slope speeds the wheel up (3.5 [E])"
    )
    largest_slope: float = parameter(
        "1", 30.0, low=1.0, high=200.0, description="k_max; listing 12, which clips ice and snow", source="3.5 [E]"
    )
    slew_time: float = parameter(
        "s", 0.05, low=1e-3, high=10.0, description="the slope moves by k_max in it at most", source="l. 6003-6009"
    )
    boundary_layer: float = parameter(
        "rad/s", 0.0, low=0.0, high=1e5, description="of the surface, within which the sign is a line; 0: the sign"
    )
    initial_slope: float = parameter(
        "1", 15.0, low=1.0, high=200.0, description="k_x; B C D of 2.4: 14 to 17 on all surfaces", source="2.4 [E]"
    )
    smallest_slip: float = parameter(
        "1", 0.002, low=0.0, high=0.1, description="the slope is held below: the slip's sign is not known", source=_OWN
    )
    gate_speed: float = parameter("m/s", 1.4, low=0.1, high=10.0, description="it rests below", source="l. 5896")
    anchor: float = parameter(
        "1/s", 5.0, low=0.0, high=100.0, description="L: ties the speed to the free wheels' odometer", source="3.5 [E]"
    )
    towing_slip: bool = Field(
        default=True,
        description="the odometer counts the slip f/k_x that the rolling resistance of a free wheel needs; false: mean "
        "of r omega, as in 3.5 [E]",
    )
    driven_axle: Literal["front", "rear"] = Field(
        default="front", description="the engine's; the wheels of the other axle are the odometer"
    )
    drive_torque: Literal["engine", "reported"] = Field(
        default="engine",
        description="engine: engine torque, speed and gear through the driveline (2.5); reported: the axles' torques "
        "that the powertrain sends",
    )
    brake_torque: Literal["none", "pressure"] = Field(
        default="none",
        description="none: defined for traction only, flagged in braking; pressure: nominal gain times wheel pressures",
    )
    pair_slip: Literal["measured", "model"] = Field(
        default="measured",
        description="slip of the pairs for the fits: from the measured wheel speed, or the wheel's model, which lags",
    )
    pair_time_constant: float = parameter(
        "s", 0.1, low=0.0, high=1.0, description="low-pass of slip and friction alike for the fits", source=_OWN
    )
    settling_time: float = parameter(
        "s", 0.5, low=0.0, high=60.0, description="of running, before pairs are stored for the fits", source=_OWN
    )
    engine_time_constant: float = parameter(
        "s", 0.05, low=0.0, high=1.0, description="low-pass of the engine's acceleration", source=_OWN
    )


class CurveSettings(FileModel):
    """Predictive fit of the friction curves (3.4)."""

    optimiser: Literal["exact", "slsqp"] = Field(
        default="exact", description="exact: compiled search for the least absolute deviations; slsqp: the document's"
    )
    shape: float = parameter("1", 1.5, low=1.05, high=1.9, description="C, fixed", source="l. 5706")
    initial_stiffness: float = parameter(
        "1/rad", 15.0, low=1.0, high=200.0, description="B at the start", source="l. 5495"
    )
    threshold: Literal["automatic", "fixed"] = Field(
        default="automatic", description="automatic: share_... / B of the last fit; fixed"
    )
    threshold_lateral: float = parameter(
        "rad", 0.0261799, low=0.002, high=0.3, description="at the start (listing: 2 deg), or fixed: 3.5, 2.5, 1.5 "
        "deg on dry, wet, ice", source="l. 2657, 5369",
    )  # fmt: skip
    threshold_longitudinal: float = parameter(
        "1", 0.0085, low=0.001, high=0.5, description="at the start, or fixed", source=_OWN
    )
    lowest_lateral: float = parameter("rad", 0.0261799, low=0.0, high=0.3, description="1.5 deg", source="3.4 [E]")
    highest_lateral: float = parameter("rad", 0.0610865, low=0.0, high=0.3, description="3.5 deg", source="3.4 [E]")
    lowest_longitudinal: float = parameter("1", 0.006, low=0.0, high=0.5, description="", source=_OWN)
    highest_longitudinal: float = parameter("1", 0.15, low=0.0, high=1.0, description="", source=_OWN)
    share_lateral: float = parameter(
        "1", 0.42, low=0.05, high=2.0, description="B times threshold; 3.4 [E]: 0.44", source=_OWN
    )
    share_longitudinal: float = parameter(
        "1", 0.63, low=0.05, high=2.0, description="B times threshold", source="3.4 [E]"
    )
    start_doubt: float = parameter(
        "1",
        0.05,
        low=0.0,
        high=1.0,
        description="the next start is at the threshold of the stiffest curve whose J is larger by it at most",
        source=_OWN,
    )
    agreement: float = parameter(
        "1",
        0.2,
        low=0.0,
        high=1.0,
        description="B is that of the wheel's earlier curves, and D with it, where J is larger by it at most; 0: best",
        source=_OWN,
    )
    doubtful_share: float = parameter(
        "1", 0.725, low=0.1, high=0.95, description="lateral: share of the peak up to which data may grow", source=_OWN
    )
    doubt: float = parameter(
        "1",
        0.2,
        low=0.0,
        high=1.0,
        description="J above the best at which a curve that has reached doubtful_share ends the wait for more data",
        source=_OWN,
    )
    latest_lateral: float = parameter(
        "1",
        0.765,
        low=0.1,
        high=0.99,
        description="share of the peak beyond which a fit is not `early`",
        source="AC-34",
    )
    latest_longitudinal: float = parameter("1", 0.8, low=0.1, high=0.99, description="the same", source="AC-35")
    hysteresis: float = parameter(
        "1", 0.1, low=0.0, high=0.9, description="share of the threshold, back to the linear law", source="3.4 [E]"
    )
    fewest_points: int = Field(default=8, ge=3, le=100, description="pairs below which no fit is tried")
    lowest_r_squared: float = parameter("1", 0.9, low=-1.0, high=1.0, description="of a fit", source="AC-34, AC-35")
    straightness: float = parameter(
        "1", 0.95, low=0.0, high=1.0, description="largest J of a fit over that of a straight line", source=_OWN
    )
    lowest_limit: float = parameter("1", 0.05, low=0.01, high=1.0, description="bound of D", source=_OWN)
    highest_limit: float = parameter("1", 1.3, low=0.1, high=3.0, description="bound of D", source=_OWN)
    lowest_stiffness_lateral: float = parameter(
        "1/rad", 3.0, low=0.1, high=100.0, description="bound of B", source=_OWN
    )
    highest_stiffness_lateral: float = parameter(
        "1/rad", 40.0, low=1.0, high=1e3, description="bound of B", source=_OWN
    )
    lowest_stiffness_longitudinal: float = parameter(
        "1", 4.0, low=0.1, high=100.0, description="bound of B", source=_OWN
    )
    highest_stiffness_longitudinal: float = parameter(
        "1", 120.0, low=1.0, high=1e3, description="bound of B", source=_OWN
    )


class GradeSettings(FileModel):
    """Grade by discrete accumulation (3.6)."""

    block_time: float = parameter("s", 0.1, low=0.01, high=1.0, description="Delta t, 10 to 100 ms", source="l. 3117")
    pitch_compensation: bool = Field(default=True, description="take the model's pitch out of the accelerometer")
    model_acceleration: Literal["virtual", "inertial"] = Field(
        default="virtual",
        description="a_x,calc: what the model's accelerometer would show; inertial: eq. 3.1, runs away",
    )
    largest_grade: float = parameter("rad", 0.4, low=0.05, high=1.0, description="bound", source=_OWN)
    standstill_time: float = parameter(
        "s",
        0.5,
        low=0.0,
        high=10.0,
        description="of standing, after which the accelerometer tells the grade",
        source=_OWN,
    )


class StateSettings(FileModel):
    """What all vehicle-state observers have."""

    input_timeout: float = parameter(
        "s", 0.1, low=0.002, high=5.0, description="time without a good sample after which an input is lost"
    )
    wheel_speed_teeth: float | None = teeth_field()
    wheel_speed_window: float | None = window_field()
    longitudinal: LongitudinalSettings = Field(default_factory=LongitudinalSettings, description="wheels and speed")


class VehicleStateSettings(StateSettings):
    """Settings of the lateral filter."""

    lateral: LateralSettings = Field(default_factory=LateralSettings, description="unscented filter")
    fit: CurveSettings = Field(default_factory=CurveSettings, description="friction curves")


class WheelSlidingModeSettings(StateSettings):
    """Settings of the wheels' sliding-mode observers."""


class MagicFormulaFitSettings(VehicleStateSettings):
    """Settings of the friction curves' fit, lateral and longitudinal."""


class RoadGradeSettings(StateSettings):
    """Settings of the grade observer."""

    grade: GradeSettings = Field(default_factory=GradeSettings, description="grade")


class ObserverCascadeSettings(VehicleStateSettings):
    """Settings of the four observers in a chain."""

    grade: GradeSettings = Field(default_factory=GradeSettings, description="grade")


MOTION_ROWS = (*MOTION_INPUTS, "lateral_acceleration", "yaw_rate", "steering_wheel_angle")
DRIVE_ROWS = ("engine_torque", "engine_speed", "gear", "drive_torque_f", "drive_torque_r", "brake_switch")
PRESSURE_ROWS = TORQUE_INPUTS[:4]


def state_inputs(settings: StateSettings) -> tuple[str, ...]:
    """Decoded signals that a vehicle-state observer reads, production sensors only (AC-60), in the tick's order."""
    pressures = PRESSURE_ROWS if settings.longitudinal.brake_torque == "pressure" else ()
    return (*MOTION_ROWS, *DRIVE_ROWS, *pressures)


def lateral_inputs(settings: StateSettings) -> tuple[str, ...]:
    """Those of the lateral filter alone: its speed is the odometer's, so that it asks for no torque."""
    return (*MOTION_ROWS, "brake_switch")
