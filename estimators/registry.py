"""Estimators by name: what each is called, reads, writes and can be told; how to build one."""

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

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
from signals.errors import InputError, nearest_name, unknown_name
from signals.quantities import FileModel

if TYPE_CHECKING:
    from estimators.interface import Estimator


@cache
def _registry() -> dict[str, Description]:
    entries = (
        Description(
            name="friction_ekf",
            summary="largest and used friction of each axle, speed and slip, by an extended Kalman filter",
            source="friction document, section 3.6 (Enisz 2015, eqs 88-105)",
            settings=FrictionEkfSettings,
            inputs=friction_inputs,
            outputs=FRICTION_OUTPUTS,
            implementation="estimators.friction_ekf:FrictionEkf",
        ),
        Description(
            name="friction_ukf",
            summary="the same by an unscented or cubature Kalman filter",
            source="friction document, section 3.8",
            settings=FrictionUkfSettings,
            inputs=friction_inputs,
            outputs=FRICTION_OUTPUTS,
            implementation="estimators.friction_ukf:FrictionUkf",
        ),
        Description(
            name="force_ekf",
            summary="longitudinal tyre force of each axle, by an extended Kalman filter without a tyre model",
            source="friction document, section 3.5 (Enisz 2015, eqs 81-87)",
            settings=ForceEkfSettings,
            inputs=force_inputs,
            outputs=FORCE_OUTPUTS,
            implementation="estimators.force_ekf:ForceEkf",
        ),
        Description(
            name="slip_slope_rls",
            summary="friction limit from the slope of force over slip, by recursive least squares",
            source="friction document, section 3.2 (Enisz 2015, eqs 24-34)",
            settings=SlipSlopeSettings,
            inputs=slip_slope_inputs,
            outputs=SLIP_SLOPE_OUTPUTS,
            implementation="estimators.slip_slope:SlipSlopeRls",
        ),
        Description(
            name="cornering_stiffness_rls",
            summary="nearness of the lateral grip limit from the slope of side friction over slip angle",
            source="friction document, section 3.3 (Enisz 2015, eqs 35-40)",
            settings=CorneringStiffnessSettings,
            inputs=cornering_stiffness_inputs,
            outputs=CORNERING_STIFFNESS_OUTPUTS,
            implementation="estimators.cornering_stiffness:CorneringStiffnessRls",
        ),
        Description(
            name="simple_braking",
            summary="friction in use during a braking from the accelerometer alone, for the comparison of asphalts",
            source="friction document, section 3.7 (Enisz 2015, eqs 120-127)",
            settings=SimpleBrakingSettings,
            inputs=simple_braking_inputs,
            outputs=SIMPLE_BRAKING_OUTPUTS,
            implementation="estimators.simple_braking:SimpleBraking",
        ),
    )
    return {entry.name: entry for entry in entries}


def names() -> tuple[str, ...]:
    """Names of all estimators."""
    return tuple(_registry())


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
