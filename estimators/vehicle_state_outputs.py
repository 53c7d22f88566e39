"""What the vehicle-state observers write: one list of all quantities, of which each estimator takes its own."""

from estimators.description import Output
from signals.wheels import WHEELS

_CONFIDENCE = "1 where the value is to be trusted"
SCALARS: tuple[Output, ...] = (
    Output("active", "1", "1 while it runs, 0 while inputs are lost"),
    Output("input_state", "1", "0 inputs good, 1 a wrong sample was held, 2 inputs lost"),
    Output("resets", "1", "returns to the initial state so far"),
    Output("traction_only", "1", "1 while the driver brakes and no brake torque is taken: defined for traction only"),
    Output("speed", "m/s", "longitudinal speed", ("speed",)),
    Output("speed_confidence", "1", f"longitudinal speed: {_CONFIDENCE}"),
    Output("longitudinal_acceleration", "m/s^2", "of the model", ("true_longitudinal_acceleration",)),
    Output("longitudinal_acceleration_confidence", "1", f"longitudinal acceleration: {_CONFIDENCE}"),
    Output("lateral_speed", "m/s", "lateral speed", ("lateral_speed",)),
    Output("lateral_speed_std", "m/s", "standard deviation: lateral speed"),
    Output("yaw_rate", "rad/s", "yaw rate", ("true_yaw_rate",)),
    Output("yaw_rate_std", "rad/s", "standard deviation: yaw rate"),
    Output("lateral_acceleration", "m/s^2", "of the model", ("true_lateral_acceleration",)),
    Output("lateral_acceleration_confidence", "1", f"lateral acceleration: {_CONFIDENCE}"),
    Output("roll_angle", "rad", "roll of the body"),
    Output("innovation", "1", "normalised innovation squared of the last step of the lateral filter"),
    Output("lateral_acceleration_rejected", "1", "1 while the lateral accelerometer is taken as stuck"),
    Output("road_grade", "1", "rise over run of the road, uphill positive", ("road_grade",)),
    Output("road_grade_std", "1", "standard deviation: rise over run of the road"),
    Output("road_grade_confidence", "1", f"grade: {_CONFIDENCE}"),
    Output("road_grade_with_pitch", "1", "tangent of grade and pitch together"),
    Output("pitch_angle", "rad", "pitch of the body, positive nose down"),
)
_WHEEL_QUANTITIES: tuple[tuple[str, str, str, str], ...] = (
    ("vertical_load", "N", "vertical tyre load", ""),
    ("slip_angle", "rad", "slip angle", "slip_angle"),
    ("slip_angle_confidence", "1", f"slip angle: {_CONFIDENCE}", ""),
    ("slope_lateral", "1/rad", "slope k_y of the linear law", ""),
    ("slope_lateral_std", "1/rad", "standard deviation: slope k_y", ""),
    ("friction_used_lateral", "1", "side force over load, positive to the left", ""),
    ("friction_limit_lateral", "1", "largest lateral friction coefficient", "friction_limit"),
    ("friction_limit_lateral_std", "1", "standard deviation: largest lateral friction coefficient", ""),
    ("friction_limit_lateral_confidence", "1", "1 once a fit has told the lateral limit", ""),
    ("stiffness_lateral", "1/rad", "B of the last lateral fit", ""),
    ("r_squared_lateral", "1", "R^2 of the last lateral fit", ""),
    ("share_lateral", "1", "share of the estimated peak that was attained at the last lateral fit", ""),
    ("fits_lateral", "1", "lateral fits so far", ""),
    ("law_lateral", "1", "0 linear law, 1 curve", ""),
    ("wheel_speed", "rad/s", "rotational speed of the wheel", ""),
    ("slip", "1", "longitudinal slip (R w - v)/max(R w, v)", "slip_ratio"),
    ("slip_confidence", "1", f"slip: {_CONFIDENCE}", ""),
    ("slope_longitudinal", "1", "slope k_x of the linear law", ""),
    ("slope_longitudinal_confidence", "1", "1 while the wheel slips enough for its slope to be told", ""),
    ("friction_used", "1", "longitudinal force over load", "friction_used"),
    ("friction_used_confidence", "1", f"longitudinal force over load: {_CONFIDENCE}", ""),
    ("friction_limit", "1", "largest longitudinal friction coefficient, 0 before the first fit", "friction_limit"),
    ("friction_limit_confidence", "1", "1 once a fit has told the longitudinal limit", ""),
    ("stiffness_longitudinal", "1", "B of the last longitudinal fit", ""),
    ("r_squared_longitudinal", "1", "R^2 of the last longitudinal fit", ""),
    ("share_longitudinal", "1", "share of the estimated peak that was attained at the last longitudinal fit", ""),
    ("fits_longitudinal", "1", "longitudinal fits so far", ""),
    ("law_longitudinal", "1", "0 linear law, 1 curve", ""),
)


def _at_wheels(name: str, unit: str, description: str, reference: str) -> tuple[Output, ...]:
    stem, ending = name, ""
    for known in ("_std", "_confidence"):
        if name.endswith(known):
            stem, ending = name.removesuffix(known), known
    return tuple(
        Output(
            f"{stem}_{wheel}{ending}", unit, f"{description}, {wheel}", (f"{reference}_{wheel}",) if reference else ()
        )
        for wheel in WHEELS
    )


WHEEL_BLOCKS: dict[str, tuple[Output, ...]] = {row[0]: _at_wheels(*row) for row in _WHEEL_QUANTITIES}
ALL_OUTPUTS: tuple[Output, ...] = (*SCALARS, *(output for block in WHEEL_BLOCKS.values() for output in block))
_POSITION = {output.name: position for position, output in enumerate(ALL_OUTPUTS)}

_STATUS = ("active", "input_state", "resets", "traction_only")
_LATERAL = (
    "lateral_speed",
    "lateral_speed_std",
    "yaw_rate",
    "yaw_rate_std",
    "lateral_acceleration",
    "lateral_acceleration_confidence",
    "roll_angle",
    "innovation",
    "lateral_acceleration_rejected",
)
_LONGITUDINAL = (
    "speed",
    "speed_confidence",
    "longitudinal_acceleration",
    "longitudinal_acceleration_confidence",
)
_GRADE = ("road_grade", "road_grade_std", "road_grade_confidence", "road_grade_with_pitch", "pitch_angle")
_NAMES = [name for name, *_ in _WHEEL_QUANTITIES]
_LATERAL_WHEELS = tuple(_NAMES[1 : _NAMES.index("wheel_speed")])
_LATERAL_FIT = tuple(_NAMES[_NAMES.index("friction_limit_lateral") : _NAMES.index("wheel_speed")])
_LONGITUDINAL_WHEELS = tuple(_NAMES[_NAMES.index("wheel_speed") : _NAMES.index("friction_limit")])
_LONGITUDINAL_FIT = tuple(_NAMES[_NAMES.index("friction_limit") :])
_FIT_WHEELS = (*_LATERAL_FIT, *_LONGITUDINAL_FIT)


def _chosen(scalars: tuple[str, ...], wheels: tuple[str, ...]) -> tuple[Output, ...]:
    blocks = tuple(output for name in wheels for output in WHEEL_BLOCKS[name])
    return (*(SCALARS[_POSITION[name]] for name in scalars), *blocks)


LATERAL_OUTPUTS = _chosen((*_STATUS, "speed", "speed_confidence", *_LATERAL), ("vertical_load", *_LATERAL_WHEELS))
LONGITUDINAL_OUTPUTS = _chosen((*_STATUS, *_LONGITUDINAL), ("vertical_load", *_LONGITUDINAL_WHEELS))
FIT_OUTPUTS = _chosen((*_STATUS, *_LONGITUDINAL), _FIT_WHEELS)
GRADE_OUTPUTS = _chosen((*_STATUS, *_LONGITUDINAL, *_GRADE), ())
CASCADE_OUTPUTS = ALL_OUTPUTS


def first_of(quantity: str) -> int:
    """Place of a quantity of the wheels, that of the first wheel, or of the whole car among all."""
    block = WHEEL_BLOCKS.get(quantity)
    return _POSITION[quantity if block is None else block[0].name]


def positions_of(outputs: tuple[Output, ...]) -> list[int]:
    """Places of an estimator's outputs among all."""
    return [_POSITION[output.name] for output in outputs]
