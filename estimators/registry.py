"""Estimators by name: what each is called, reads, writes and can be told; how to build one."""

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from estimators.attitude_settings import (
    ATTITUDE_OUTPUTS,
    AttitudeAugmentedSettings,
    AttitudeBankSettings,
    AttitudeSingleSettings,
    attitude_inputs,
)
from estimators.baseline_settings import (
    CORNERING_STIFFNESS_OUTPUTS,
    SIMPLE_BRAKING_OUTPUTS,
    SLIP_SLOPE_OUTPUTS,
    CorneringStiffnessSettings,
    SimpleBrakingSettings,
    SlipSlopeSettings,
    cornering_stiffness_inputs,
    simple_braking_inputs,
    slip_slope_inputs,
)
from estimators.description import Description
from estimators.force_settings import FORCE_OUTPUTS, ForceEkfSettings, force_inputs
from estimators.friction_outputs import FRICTION_OUTPUTS
from estimators.friction_settings import FrictionEkfSettings, FrictionUkfSettings, friction_inputs
from estimators.neural_force_settings import (
    NEURAL_FORCE_OUTPUTS,
    RANDOM_WALK_OUTPUTS,
    NeuralForceSettings,
    RandomWalkForceSettings,
    neural_force_inputs,
    random_walk_inputs,
)
from estimators.vehicle_state_outputs import (
    CASCADE_OUTPUTS,
    FIT_OUTPUTS,
    GRADE_OUTPUTS,
    LATERAL_OUTPUTS,
    LONGITUDINAL_OUTPUTS,
)
from estimators.vehicle_state_settings import (
    MagicFormulaFitSettings,
    ObserverCascadeSettings,
    RoadGradeSettings,
    VehicleStateSettings,
    WheelSlidingModeSettings,
    lateral_inputs,
    state_inputs,
)
from estimators.vertical_load_settings import (
    VERTICAL_LOAD_OUTPUTS,
    VerticalLoadKalmanSettings,
    VerticalLoadSettings,
    VerticalLoadUkfSettings,
    static_inputs,
    two_sensor_inputs,
    vertical_load_inputs,
)
from signals.errors import InputError, nearest_name, unknown_name
from signals.quantities import FileModel

if TYPE_CHECKING:
    from estimators.interface import Estimator


@cache
def _registry() -> dict[str, Description]:
    entries = (
        Description(
            name="friction_ekf",
            group="friction",
            summary="largest and used friction of each axle, speed and slip, by an extended Kalman filter",
            source="friction document, section 3.6 (Enisz 2015, eqs 88-105)",
            settings=FrictionEkfSettings,
            inputs=friction_inputs,
            outputs=FRICTION_OUTPUTS,
            implementation="estimators.friction_ekf:FrictionEkf",
        ),
        Description(
            name="friction_ukf",
            group="friction",
            summary="the same by an unscented or cubature Kalman filter",
            source="friction document, section 3.8",
            settings=FrictionUkfSettings,
            inputs=friction_inputs,
            outputs=FRICTION_OUTPUTS,
            implementation="estimators.friction_ukf:FrictionUkf",
        ),
        Description(
            name="force_ekf",
            group="friction",
            summary="longitudinal tyre force of each axle, by an extended Kalman filter without a tyre model",
            source="friction document, section 3.5 (Enisz 2015, eqs 81-87)",
            settings=ForceEkfSettings,
            inputs=force_inputs,
            outputs=FORCE_OUTPUTS,
            implementation="estimators.force_ekf:ForceEkf",
        ),
        Description(
            name="slip_slope_rls",
            group="friction",
            summary="friction limit from the slope of force over slip, by recursive least squares",
            source="friction document, section 3.2 (Enisz 2015, eqs 24-34)",
            settings=SlipSlopeSettings,
            inputs=slip_slope_inputs,
            outputs=SLIP_SLOPE_OUTPUTS,
            implementation="estimators.slip_slope:SlipSlopeRls",
        ),
        Description(
            name="cornering_stiffness_rls",
            group="friction",
            summary="nearness of the lateral grip limit from the slope of side friction over slip angle",
            source="friction document, section 3.3 (Enisz 2015, eqs 35-40)",
            settings=CorneringStiffnessSettings,
            inputs=cornering_stiffness_inputs,
            outputs=CORNERING_STIFFNESS_OUTPUTS,
            implementation="estimators.cornering_stiffness:CorneringStiffnessRls",
        ),
        Description(
            name="simple_braking",
            group="friction",
            summary="friction in use during a braking from the accelerometer alone, for the comparison of asphalts",
            source="friction document, section 3.7 (Enisz 2015, eqs 120-127)",
            settings=SimpleBrakingSettings,
            inputs=simple_braking_inputs,
            outputs=SIMPLE_BRAKING_OUTPUTS,
            implementation="estimators.simple_braking:SimpleBraking",
        ),
        Description(
            name="vehicle_state_ukf",
            group="state",
            summary="yaw rate, lateral speed, slip angles and lateral friction of each wheel, by an unscented filter",
            source="vehicle-state document, 3.2 and 3.3",
            settings=VehicleStateSettings,
            inputs=lateral_inputs,
            outputs=LATERAL_OUTPUTS,
            implementation="estimators.vehicle_state_ukf:VehicleStateUkf",
        ),
        Description(
            name="wheel_sliding_mode",
            group="state",
            summary="speed, longitudinal slip and friction in use of each wheel, by sliding-mode observers",
            source="vehicle-state document, 3.5",
            settings=WheelSlidingModeSettings,
            inputs=state_inputs,
            outputs=LONGITUDINAL_OUTPUTS,
            implementation="estimators.wheel_sliding_mode:WheelSlidingMode",
        ),
        Description(
            name="magic_formula_fit",
            group="state",
            summary="largest friction of each wheel and direction before it is reached, by a fit of the friction curve",
            source="vehicle-state document, 3.4",
            settings=MagicFormulaFitSettings,
            inputs=state_inputs,
            outputs=FIT_OUTPUTS,
            implementation="estimators.magic_formula_fit:MagicFormulaFit",
        ),
        Description(
            name="road_grade",
            group="state",
            summary="longitudinal grade of the road, by block averaging of the accelerometer against the model",
            source="vehicle-state document, 3.6",
            settings=RoadGradeSettings,
            inputs=state_inputs,
            outputs=GRADE_OUTPUTS,
            implementation="estimators.road_grade:RoadGrade",
        ),
        Description(
            name="observer_cascade",
            group="state",
            summary="the four vehicle-state observers in a chain, from production sensors only",
            source="vehicle-state document, 1.4 and 3.7",
            settings=ObserverCascadeSettings,
            inputs=state_inputs,
            outputs=CASCADE_OUTPUTS,
            implementation="estimators.observer_cascade:ObserverCascade",
        ),
        Description(
            name="vertical_load_ukf",
            group="load",
            summary="vertical load of each wheel from roll, by an unscented Kalman filter with a roll-rate sensor",
            source="vertical-load document, 3.2 (Kim 2020, eqs 21-34)",
            settings=VerticalLoadUkfSettings,
            inputs=vertical_load_inputs,
            outputs=VERTICAL_LOAD_OUTPUTS,
            implementation="estimators.vertical_load:VerticalLoadUkf",
        ),
        Description(
            name="vertical_load_kf3",
            group="load",
            summary="the same three sensors with the gain of the steady state",
            source="vertical-load document, 3.1 (Kim 2020, eqs 17-20)",
            settings=VerticalLoadKalmanSettings,
            inputs=vertical_load_inputs,
            outputs=VERTICAL_LOAD_OUTPUTS,
            implementation="estimators.vertical_load:three_sensors",
        ),
        Description(
            name="vertical_load_kf2",
            group="load",
            summary="the prior method: lateral acceleration and yaw rate, gain of the steady state",
            source="vertical-load document, 3.1 (Kim 2020, eqs 17-20)",
            settings=VerticalLoadKalmanSettings,
            inputs=two_sensor_inputs,
            outputs=VERTICAL_LOAD_OUTPUTS,
            implementation="estimators.vertical_load:two_sensors",
        ),
        Description(
            name="vertical_load_static",
            group="load",
            summary="the loads at rest, which every observer has to beat",
            source="vertical-load document, 4",
            settings=VerticalLoadSettings,
            inputs=static_inputs,
            outputs=VERTICAL_LOAD_OUTPUTS,
            implementation="estimators.vertical_load:VerticalLoadStatic",
        ),
        Description(
            name="neural_force_observer",
            group="force",
            summary="longitudinal force of each axle and lateral speed, by observers that learn the forces",
            source="force document, section 3 (Boufadene 2017, eqs 16-26)",
            settings=NeuralForceSettings,
            inputs=neural_force_inputs,
            outputs=NEURAL_FORCE_OUTPUTS,
            implementation="estimators.neural_force:NeuralForceObserver",
        ),
        Description(
            name="random_walk_force_ekf",
            group="force",
            summary="the same by an extended Kalman filter with the forces as random walks",
            source="force document, section 4, baseline B2",
            settings=RandomWalkForceSettings,
            inputs=random_walk_inputs,
            outputs=RANDOM_WALK_OUTPUTS,
            implementation="estimators.random_walk_force:RandomWalkForce",
        ),
        Description(
            name="attitude_bank",
            group="attitude",
            summary="roll, pitch and offsets of gyroscopes and accelerometers, by a bank of Kalman filters",
            source="attitude document, section 3 (virtual sensor offsets, eqs 22-30)",
            settings=AttitudeBankSettings,
            inputs=attitude_inputs,
            outputs=ATTITUDE_OUTPUTS,
            implementation="estimators.attitude_bank:AttitudeBank",
        ),
        Description(
            name="attitude_single",
            group="attitude",
            summary="the same by one filter of the bank alone, which is told that the offset is zero",
            source="attitude document, 7.1 (one filter) and example 4",
            settings=AttitudeSingleSettings,
            inputs=attitude_inputs,
            outputs=ATTITUDE_OUTPUTS,
            implementation="estimators.attitude_bank:attitude_single",
        ),
        Description(
            name="attitude_augmented",
            group="attitude",
            summary="the same by one filter with the offset as one more state, the fair reference of the bank",
            source="attitude document, 7.9 (extra state)",
            settings=AttitudeAugmentedSettings,
            inputs=attitude_inputs,
            outputs=ATTITUDE_OUTPUTS,
            implementation="estimators.attitude_bank:attitude_augmented",
        ),
    )
    return {entry.name: entry for entry in entries}


def names() -> tuple[str, ...]:
    """Names of all estimators."""
    return tuple(_registry())


def groups() -> dict[str, tuple[str, ...]]:
    """Names of the estimators of each group, in the order of the registry."""
    found: dict[str, list[str]] = {}
    for entry in _registry().values():
        found.setdefault(entry.group, []).append(entry.name)
    return {group: tuple(members) for group, members in found.items()}


def describe(name: str) -> Description:
    """What an estimator reads, writes and can be told.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    try:
        return _registry()[name]
    except KeyError:
        raise unknown_name("estimator", name, names()) from None


def create(
    name: str,
    vehicle: Mapping[str, float],
    settings: Mapping[str, Any] | None = None,
    sample_time_s: float = 0.001,
) -> "Estimator":
    """Build an estimator.

    Parameters
    ----------
    name : str
        Name in the registry.
    vehicle : mapping
        Nominal vehicle: dotted path to number in SI units.
    settings : mapping, optional
        Keys of the estimator's settings; nested mappings or dotted keys (``process_noise.slip``).
    sample_time_s : float
        Time between two ticks [s].

    Raises
    ------
    InputError
        If there is no such estimator, a setting is wrong or the vehicle lacks a number.
    """
    description = describe(name)
    checked = validate_settings(name, settings or {})
    module, function = description.implementation.split(":")
    built: Estimator = getattr(import_module(module), function)(vehicle, checked, sample_time_s)
    return built


def validate_settings(name: str, settings: Mapping[str, Any]) -> Any:
    """Settings of an estimator as its model, defaults filled in.

    Raises
    ------
    InputError
        Naming every wrong key, what was found and what is allowed.
    """
    description = describe(name)
    try:
        return description.settings.model_validate(_nested(settings))
    except ValidationError as error:
        lines = [_problem(name, problem, description.settings) for problem in error.errors()]
        raise InputError("\n".join(lines)) from None


def _problem(name: str, problem: Any, model: type[FileModel]) -> str:
    path = [str(part) for part in problem["loc"]]
    place = ".".join(("estimators", name, *path))
    if not path:
        return f"{place}: {problem['msg']}"
    if problem["type"] != "extra_forbidden":
        return f"{place}: found {problem['input']!r}; {problem['msg']}"
    *parents, key = path
    for parent in parents:
        model = model.model_fields[parent].annotation  # type: ignore[assignment]
    nearest = nearest_name(key, list(model.model_fields))
    hint = f"did you mean {nearest}?" if nearest else f"allowed: {', '.join(model.model_fields)}"
    return f"{place}: unknown key; {hint}"


def _nested(settings: Mapping[str, Any]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for key, value in settings.items():
        *parents, last = key.split(".")
        place = result
        for parent in parents:
            place = place.setdefault(parent, {})
        place[last] = dict(value) if isinstance(value, Mapping) else value
    return result
