"""Words of the criteria language: functions, phases, constants and metrics, as tables that need no numpy.

The tables are what `bench check` compares a file with and what ``docs/verdicts.md`` lists; the computations are the
functions of the same names in ``functions`` and ``metrics``.
"""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Function:
    """A function of the expression language.

    Attributes
    ----------
    arguments : str
        How the call is written, for messages and documentation.
    least, most : int
        Allowed number of arguments.
    unit : str
        "first" (that of the first argument), "second", "per_s" or "times_s" (that of the first by or times second),
        "unknown", or a unit.
    takes : str
        "values", or what the only argument names: "phase", "wheels" (a signal without its wheel), "estimate".
    """

    name: str
    arguments: str
    least: int
    most: int
    unit: str
    description: str
    takes: str = "values"


_MANY = 20

_FUNCTIONS = (
    Function("abs", "x", 1, 1, "first", "magnitude"),
    Function("sign", "x", 1, 1, "1", "-1, 0 or 1"),
    Function("sqrt", "x", 1, 1, "unknown", "square root"),
    Function("hypot", "x, y", 2, 2, "first", "square root of x² + y²"),
    Function("sin", "x", 1, 1, "1", "sine of an angle in rad"),
    Function("cos", "x", 1, 1, "1", "cosine of an angle in rad"),
    Function("tan", "x", 1, 1, "1", "tangent of an angle in rad"),
    Function("clip", "x, low, high", 3, 3, "first", "x limited to low … high"),
    Function("where", "condition, x, y", 3, 3, "second", "x where the condition holds, else y"),
    Function("select", "x, condition", 2, 2, "first", "the samples of x at which the condition holds"),
    Function("max", "x or x, y, …", 1, _MANY, "first", "largest value of x; of several arguments sample by sample"),
    Function("min", "x or x, y, …", 1, _MANY, "first", "smallest value of x; of several arguments sample by sample"),
    Function("mean", "x", 1, 1, "first", "mean over all samples (and wheels)"),
    Function("std", "x", 1, 1, "first", "standard deviation"),
    Function("rms", "x", 1, 1, "first", "root of the mean square"),
    Function("rmse", "x, y", 2, 2, "first", "root of the mean squared difference"),
    Function("percentile", "x, p", 2, 2, "first", "value that p % of the samples do not exceed"),
    Function("integral", "x", 1, 1, "times_s", "integral over time, trapezoidal"),
    Function("derivative", "x", 1, 1, "per_s", "derivative with respect to time"),
    Function("moving_mean", "x, span", 2, 2, "first", "mean over the last span seconds"),
    Function("first", "x", 1, 1, "first", "value at the start of the phase"),
    Function("last", "x", 1, 1, "first", "value at the end of the phase"),
    Function("at", "x, time", 2, 2, "first", "value at a time of the run, interpolated linearly"),
    Function("first_time", "condition", 1, 1, "s", "time of the run at which it first holds; never: infinity"),
    Function("last_time", "condition", 1, 1, "s", "time of the run at which it last holds; never: minus infinity"),
    Function("duration", "condition", 1, 1, "s", "time during which the condition holds, in all"),
    Function("longest", "condition", 1, 1, "s", "longest time without a break during which the condition holds"),
    Function("share", "condition", 1, 1, "1", "share of the time during which the condition holds"),
    Function("count_rising", "condition", 1, 1, "1", "how often the condition becomes true"),
    Function("any", "condition", 1, 1, "1", "the condition holds at least once"),
    Function("all", "condition", 1, 1, "1", "the condition holds throughout"),
    Function("wheels", "signal", 1, 1, "first", "the four wheels of a signal, as in wheels(slip_ratio)", "wheels"),
    Function("front", "signal", 1, 1, "first", "mean of the front wheels", "wheels"),
    Function("rear", "signal", 1, 1, "first", "mean of the rear wheels", "wheels"),
    Function("start", "phase", 1, 1, "s", "time of the run at which a phase begins", "phase"),
    Function("end", "phase", 1, 1, "s", "time of the run at which a phase ends", "phase"),
    Function("in_phase", "phase", 1, 1, "1", "condition: the phase is on", "phase"),
    Function("truth", "estimate", 1, 1, "first", "the simulated car's value of what is estimated", "estimate"),
    Function("estimator_error", "estimate", 1, 1, "first", "root mean squared error of an estimate", "estimate"),
    Function(
        "settling_time",
        "estimate",
        1,
        1,
        "s",
        "time from the largest jump of the truth until the estimate stays within ±10 % of it; never: infinity",
        "estimate",
    ),
)

FUNCTIONS: dict[str, Function] = {function.name: function for function in _FUNCTIONS}

CONSTANTS: dict[str, float] = {"pi": 3.141592653589793, "g": 9.81, "inf": float("inf")}

PHASES: dict[str, str] = {
    "run": "the whole recording",
    "brake": "from the brake start until the car stands, else until the end",
    "braking": "from 0.4 s after the onset of braking until the speed is below 5 m/s",
}


@dataclass(frozen=True)
class Metric:
    """A quantity with one definition, usable by name in every expression.

    Attributes
    ----------
    unit : str
        SI unit of its value.
    phase : str or None
        Phase over which it is taken unless the criterion names another; None if it has its own instants.
    per_wheel : bool
        Four values in wheel order.
    parameters : dict
        Name to (default in SI, unit).
    source : str
        Where the definition comes from; "unverified" where the clause itself was not read.
    """

    name: str
    unit: str
    description: str
    phase: str | None = None
    per_wheel: bool = False
    parameters: dict[str, tuple[float, str]] = field(default_factory=dict)
    source: str = ""


_KMH = 1 / 3.6
_EU = "71/320/EEC annex II 1.1.2"

_METRICS = (
    Metric("brake_start_time", "s", "instant at which the driver begins to actuate the brake", source=_EU),
    Metric("brake_start_speed", "m/s", "speed at the brake start", source=_EU),
    Metric("stopping_distance", "m", "distance from the brake start to standstill", source=_EU),
    Metric("stopping_time", "s", "time from the brake start to standstill"),
    Metric(
        "stopping_distance_corrected",
        "m",
        "stopping distance times (target speed / speed at the brake start)²",
        parameters={"target_speed": (100 * _KMH, "m/s")},
        source="friction document 4.5, rule 9",
    ),
    Metric(
        "braking_distance",
        "m",
        "distance from the instant at which the deceleration passes 10 % of its mean to standstill; "
        "with a target speed, corrected to it",
        parameters={"target_speed": (0.0, "m/s")},
        source="friction document 4.6, v²/2s",
    ),
    Metric("mean_deceleration", "m/s^2", "loss of speed over time", phase="braking", source="friction document 4.8"),
    Metric("mfdd", "m/s^2", "mean fully developed deceleration, from 80 % to 10 % of the initial speed", source=_EU),
    Metric("max_deceleration", "m/s^2", "largest deceleration as the mean over 0.1 s", phase="brake"),
    Metric(
        "wheel_lock",
        "s",
        "longest time a wheel is locked while the car is faster than above_speed",
        phase="brake",
        per_wheel=True,
        parameters={"above_speed": (15 * _KMH, "m/s"), "locked_below": (0.01, "1")},
        source="FMVSS 135 S7.5, unverified; locked is less than 1 % of the car's speed: own definition",
    ),
    Metric(
        "lock_share",
        "1",
        "share of the time above above_speed during which a wheel is locked",
        phase="brake",
        per_wheel=True,
        parameters={"above_speed": (15 * _KMH, "m/s"), "locked_below": (0.01, "1")},
    ),
    Metric(
        "lock_speed_ratio",
        "1",
        "speed at which a wheel of each axle has locked, over the speed at the brake start; none: 0",
        parameters={"locked_below": (0.01, "1")},
        source="friction document 4.8, A3",
    ),
    Metric("slip_mean", "1", "mean magnitude of slip, wheels and time", phase="braking", source="friction document A4"),
    Metric("slip_mean_wheel", "1", "mean magnitude of slip of each wheel", phase="braking", per_wheel=True),
    Metric(
        "slip_high_share",
        "1",
        "share of time, over all wheels, of slip above above_slip while the car is faster than above_speed",
        phase="brake",
        parameters={"above_slip": (0.4, "1"), "above_speed": (10 * _KMH, "m/s")},
        source="friction document A4",
    ),
    Metric(
        "slip_high_share_wheel",
        "1",
        "the same for each wheel",
        phase="brake",
        per_wheel=True,
        parameters={"above_slip": (0.4, "1"), "above_speed": (10 * _KMH, "m/s")},
    ),
    Metric(
        "slip_band",
        "1",
        "share of time, over all wheels, of slip between low and high",
        phase="braking",
        parameters={"low": (0.05, "1"), "high": (0.30, "1")},
    ),
    Metric("yaw", "rad", "largest change of the yaw angle since the brake start", phase="brake"),
    Metric("max_abs_yaw_rate", "rad/s", "largest magnitude of the yaw rate", phase="run"),
    Metric("max_abs_side_slip_angle", "rad", "largest magnitude of the side-slip angle above 10 km/h", phase="brake"),
    Metric("lateral_offset", "m", "largest lateral offset from the line driven at the brake start", phase="brake"),
    Metric("steering_wheel_peak", "rad", "largest magnitude of the steering-wheel angle", phase="brake"),
    Metric("steering_wheel_peak_2s", "rad", "the same in the first 2 s after the brake start"),
    Metric("abs_cycles", "1", "number of release phases of the ECU", phase="brake", per_wheel=True),
    Metric("friction_jump_time", "s", "instant of the largest jump of the road's friction under the front axle"),
    Metric("real_time_overruns", "1", "ticks that ended after the next deadline"),
    Metric("late_ticks", "1", "ticks that began more than a period late"),
    Metric("skipped_ticks", "1", "ticks that were left out after a stall"),
)

METRICS: dict[str, Metric] = {metric.name: metric for metric in _METRICS}
