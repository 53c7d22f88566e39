"""What the friction filters write, in order, and the names under which the car's truth is found."""

from estimators.description import Output, with_deviation

_FRONT = ("fl", "fr")
_REAR = ("rl", "rr")


def _truth(name: str, wheels: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(f"{name}_{wheel}" for wheel in wheels)


def _friction(name: str, description: str, truth: str, wheels: tuple[str, ...]) -> tuple[Output, Output]:
    """A friction coefficient of an axle or the car: its truth is weighted by the loads of the wheels."""
    return with_deviation(name, "1", description, _truth(truth, wheels), _truth("vertical_load", wheels))


FRICTION_OUTPUTS: tuple[Output, ...] = (
    Output("active", "1", "1 while the filter runs, 0 at standstill and while inputs are lost"),
    Output("resets", "1", "returns to the initial state so far"),
    Output("input_state", "1", "0 inputs good, 1 a wrong sample was held, 2 inputs lost"),
    *with_deviation("speed", "m/s", "vehicle speed", ("speed",)),
    *with_deviation("wheel_speed_front", "rad/s", "mean front wheel speed", _truth("true_wheel_speed", _FRONT)),
    *with_deviation("wheel_speed_rear", "rad/s", "mean rear wheel speed", _truth("true_wheel_speed", _REAR)),
    *with_deviation("slip_front", "1", "slip of the front axle", _truth("slip_ratio", _FRONT)),
    *with_deviation("slip_rear", "1", "slip of the rear axle", _truth("slip_ratio", _REAR)),
    *_friction("friction_limit_front", "largest friction coefficient, front axle", "friction_limit", _FRONT),
    Output("friction_limit_front_confidence", "1", "1 where enough friction is used to tell the limit, front"),
    *with_deviation("friction_limit_rate_front", "1/s", "rate of change of the friction limit, front axle"),
    *_friction("friction_limit_rear", "largest friction coefficient, rear axle", "friction_limit", _REAR),
    Output("friction_limit_rear_confidence", "1", "1 where enough friction is used to tell the limit, rear"),
    *with_deviation("friction_limit_rate_rear", "1/s", "rate of change of the friction limit, rear axle"),
    *_friction("friction_limit_mean", "friction limit of the car, weighted by load", "friction_limit", _FRONT + _REAR),
    Output("friction_limit_mean_confidence", "1", "1 where enough friction is used to tell the limit, whole car"),
    *_friction("friction_used_front", "friction coefficient in use, front axle", "friction_used", _FRONT),
    *_friction("friction_used_rear", "friction coefficient in use, rear axle", "friction_used", _REAR),
    *_friction("friction_used_mean", "friction coefficient in use, whole car", "friction_used", _FRONT + _REAR),
    Output("friction_limit_front_filtered", "1", "friction limit after the post-filter, front axle"),
    Output("friction_limit_rear_filtered", "1", "friction limit after the post-filter, rear axle"),
    Output("friction_limit_mean_filtered", "1", "friction limit after the post-filter, whole car"),
    Output("innovation", "1", "normalised innovation squared of this step"),
)

POSITION = {output.name: position for position, output in enumerate(FRICTION_OUTPUTS)}
