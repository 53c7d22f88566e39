"""What a scenario says about cars, roads, signals and phases, checked against what there is, with places."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bench.scenario.cluster_choice import CLUSTER_PARAMETERS
from bench.scenario.estimator_names import estimator_units, kind_of
from bench.scenario.stimulus_file import StimulusEntry, read_table
from bench.scenario.vehicle_choice import flat, load_tyres
from bench.verdict.criteria_file import check_criteria
from signals.catalogue import catalogue
from signals.errors import Fault, FieldError, FileFaults, InputError, nearest_name
from signals.quantities import QuantityError, range_text, to_si
from signals.yaml_files import DataPath, Document
from vehicle_model.parameters import ParameterInfo

if TYPE_CHECKING:
    from bench.scenario.schema import ScenarioFile

_OVERRIDABLE = ("driver", "hydraulics", "powertrain", "bus")


@dataclass
class Context:
    """What is known of the run while its scenario is checked.

    Attributes
    ----------
    document : Document
        The scenario with its places.
    phases : sequence of str, optional
        Steps of the manoeuvre; None if the manoeuvre itself is faulty.
    parameters : dict
        Parameters of car and road by dotted path; empty if the car is faulty.
    units : dict
        Unit of every signal of the run.
    """

    document: Document
    phases: Sequence[str] | None = None
    parameters: dict[str, ParameterInfo] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)

    def add(self, path: Sequence[str | int], problem: str, **details: Any) -> None:
        """Note a fault at a path of the scenario."""
        self.faults.append(self.document.fault(path, problem, **details))

    def add_field_errors(self, path: DataPath, errors: Iterable[FieldError]) -> None:
        """Note faults below a path."""
        for error in errors:
            inner = (*path, *error.at)
            found = error.found or _shown(self.document, inner)
            self.add(inner, error.problem, found=found, allowed=error.allowed, nearest=error.nearest)

    def add_error(self, path: DataPath, error: InputError) -> None:
        """Note what was raised while something that the scenario names was read."""
        if isinstance(error, FileFaults):
            self.faults += error.faults
            return
        first, *rest = error.message.splitlines()
        self.add(path, first, found=error.found, allowed=error.allowed, nearest=error.nearest)
        for line in rest:
            self.add(path, line)


def _shown(document: Document, path: Sequence[str | int]) -> str:
    from signals.validation import brief

    try:
        value = document.value(path)
    except KeyError:
        return ""
    return "" if isinstance(value, (dict, list)) else brief(value)


def check_car(scenario: "ScenarioFile", context: Context) -> None:
    """Vehicle, tyres and sensors; fills the table of parameters."""
    from vehicle_model.road_file import road_parameter_table
    from vehicle_model.vehicle_file import load_vehicle, parameter_table

    try:
        vehicle = load_vehicle(scenario.vehicle)
    except InputError as error:
        context.add_error(("vehicle",), error)
        return
    if scenario.tyres is not None:
        try:
            object.__setattr__(vehicle, "tyres", load_tyres(scenario.tyres))
        except InputError as error:
            context.add_error(("tyres",), error)
    context.parameters = {info.path: info for info in parameter_table(vehicle)}
    context.parameters |= {info.path: info for info in road_parameter_table(scenario.road)}
    if scenario.sensor_cluster.kind != "none":
        context.parameters |= {info.path: info for info in CLUSTER_PARAMETERS}


def check_road(scenario: "ScenarioFile", context: Context) -> None:
    """What of the road the plant would not notice."""
    road, plant = scenario.road, scenario.plant
    if road.roughness.level > 0.0 and plant != "mujoco":
        context.add(
            ("road",), f"a rough road under plant {plant}, which drives on a smooth one", allowed="plant: mujoco"
        )
    films = [road.water.film, *(patch.water_film or 0.0 for patch in road.patches)]
    if (max(films) > 0.0 or road.water.speed_dependence > 0.0) and plant not in ("mujoco", "single_track"):
        allowed = "plant: mujoco or single_track"
        context.add(("road",), f"water under plant {plant}, which knows none", allowed=allowed)


def check_overrides(scenario: "ScenarioFile", context: Context) -> dict[str, float]:
    """Values of overrides and sensors in SI units by dotted path."""
    if not context.parameters:
        return {}
    values: dict[str, float] = {}
    try:
        sensors = flat(scenario.sensors, "sensors")
    except InputError as error:
        context.add_error(("sensors",), error)
        sensors = {}
    for path, value in sensors.items():
        _check_override(tuple(path.split(".")), path, value, context, values)
    for path, value in scenario.overrides.items():
        _check_override(("overrides", path), path, value, context, values)
    return values


def _check_override(place: DataPath, path: str, value: Any, context: Context, values: dict[str, float]) -> None:
    info = context.parameters.get(path)
    if info is None:
        near = nearest_name(path, list(context.parameters))
        context.add(place, f"no parameter {path}", nearest=near, key=True)
        return
    number = _in_range(place, value, info, context)
    if number is not None:
        values[path] = number


def _in_range(place: DataPath, value: Any, info: ParameterInfo, context: Context) -> float | None:
    from signals.validation import brief

    try:
        number = to_si(value, info.unit)
    except QuantityError as error:
        context.add(place, error.problem, found=brief(value), allowed=error.allowed)
        return None
    if (info.low is not None and number < info.low) or (info.high is not None and number > info.high):
        allowed = range_text(info.unit, info.low, info.high)
        context.add(place, "out of range", found=_shown(context.document, place) or brief(value), allowed=allowed)
        return None
    return number


def check_estimators(scenario: "ScenarioFile", context: Context) -> dict[str, dict[str, Any]]:
    """Settings of every estimator with all defaults; adds their outputs to the units."""
    from pydantic import ValidationError

    from estimators import describe
    from signals.validation import explain

    context.units |= {signal.name: signal.unit for signal in catalogue()}
    settings: dict[str, dict[str, Any]] = {}
    for name, given in scenario.estimators.items():
        place = ("estimators", name)
        try:
            model = describe(kind_of(name)).settings
        except InputError as error:
            context.add_error(place, error)
            continue
        context.units |= estimator_units([name])
        try:
            settings[name] = model.model_validate(given).model_dump(exclude_none=True)
        except ValidationError as error:
            for p in explain(error, model, given):
                details = {"found": p.found, "allowed": p.allowed, "nearest": p.nearest, "key": p.key}
                context.add((*place, *p.path), p.problem, **details)
    return settings


def check_faults(scenario: "ScenarioFile", context: Context) -> None:
    """Levels, conditions and phases of the faults on the bus; adds the injector's signals to the units."""
    from bench.injection.signals import injector_signals
    from can_fault_injector.faults.levels import at_least, realised_level

    context.units |= {signal.name: signal.unit for signal in injector_signals(scenario.faults)}
    for number, fault in enumerate(scenario.faults):
        # the most real that it can be; with hardware on a side the injector itself refuses what is less there
        level = realised_level(type(fault.disturbance.model), real_bus=False)
        if fault.requires is not None and not at_least(level, fault.requires):
            problem = f"{fault.disturbance.kind} requires {fault.requires}"
            context.add(("faults", number, "requires"), problem, found=f"here it is realised as {level}")
    if context.phases is None:
        return
    for number, fault in enumerate(scenario.faults):
        place = ("faults", number)
        context.add_field_errors(place, fault.trigger.faults(context.units, context.phases))


def check_conditions(scenario: "ScenarioFile", context: Context) -> None:
    """Conditions of manoeuvre and ECU."""
    if context.phases is None:
        return
    context.add_field_errors(("manoeuvre",), scenario.manoeuvre.faults(context.units))
    if scenario.ecu.kill is not None:
        context.add_field_errors(("ecu", "kill"), scenario.ecu.kill.faults(context.units, context.phases))


def check_all_criteria(scenario: "ScenarioFile", context: Context) -> None:
    """Expressions, phases, limits and conditions of the criteria."""
    if context.phases is None:
        return
    for problem in check_criteria(scenario.criteria, context.units, context.phases, scenario.valid_if):
        path = problem.path if problem.path[:1] == ("valid_if",) else ("criteria", *problem.path)
        context.add(path, problem.message)


def check_stimuli(scenario: "ScenarioFile", context: Context) -> list[StimulusEntry]:
    """Stimuli with their values in SI units and the points of their tables in them."""
    return [_checked_stimulus(entry, ("stimuli", n), context) for n, entry in enumerate(scenario.stimuli)]


def _checked_stimulus(entry: StimulusEntry, place: DataPath, context: Context) -> StimulusEntry:
    if context.phases is not None:
        context.add_field_errors((*place, "when"), entry.when.faults(context.units, context.phases))
    if entry.table is not None and entry.table.file is not None:
        folder = Path(context.document.place((*place, "table", "file")).file).parent
        try:
            entry = entry.model_copy(update={"table": read_table(entry.table, folder)})
        except FieldError as error:
            context.add_field_errors(place, [error])
            return entry
    info = context.parameters.get(entry.target)
    unit = info.unit if info is not None else context.units.get(entry.target)
    if not context.parameters or (unit is None and not context.units):
        return entry
    if unit is None:
        near = nearest_name(entry.target, [*context.parameters, *context.units])
        context.add((*place, "target"), "no parameter or signal", found=repr(entry.target), nearest=near)
        return entry
    if info is None:
        _check_signal_target(entry, place, context)
    elif entry.relative:
        context.add((*place, "relative"), "a parameter is set, not added to", allowed="relative: false")
    return _in_si(entry, place, unit, info, context)


def _check_signal_target(entry: StimulusEntry, place: DataPath, context: Context) -> None:
    blocks = {signal.name: signal.block for signal in catalogue()}
    if blocks.get(entry.target) not in _OVERRIDABLE:
        allowed = "a parameter, or a signal of driver, hydraulics, powertrain or bus"
        context.add(
            (*place, "target"), "an outcome of the run cannot be set", found=repr(entry.target), allowed=allowed
        )


def _in_si(
    entry: StimulusEntry, place: DataPath, unit: str, info: ParameterInfo | None, context: Context
) -> StimulusEntry:
    """The stimulus with every value that has the target's unit as a number."""
    from signals.validation import brief

    data: Any = entry.model_dump()
    for path, value in entry.values():
        try:
            number = to_si(value, unit)
        except QuantityError as error:
            context.add((*place, *path), error.problem, found=brief(value), allowed=error.allowed)
            continue
        absolute = path[-1] in ("step", "from", "to") or path[1:2] == ("values",)
        if info is not None and absolute and _in_range((*place, *path), number, info, context) is None:
            continue
        target: Any = data
        for part in path[:-1]:
            target = target[part]
        target[path[-1]] = number
    return StimulusEntry.model_validate(data)


def check_ecu(scenario: "ScenarioFile", context: Context) -> None:
    """Database, mapping, calibration and link of the ECU."""
    ecu = scenario.ecu
    if not _ships(ecu.calibration) and ecu.kind in ("emulated", "inprocess"):
        from bench.ecu.calibration import load_calibration

        try:
            load_calibration(ecu.calibration)
        except InputError as error:
            context.add_error(("ecu", "calibration"), error)
    if ecu.dbc is not None or ecu.mapping is not None:
        _check_database(ecu.dbc, ecu.mapping, context)
    if ecu.link == "virtual" and ecu.kind not in ("inprocess", "none"):
        allowed = "kind: inprocess or none with it"
        context.add(("ecu", "link"), "the virtual link reaches no other process", found="'virtual'", allowed=allowed)
    if ecu.kind == "external" and ecu.link is None:
        context.add(("ecu", "kind"), "an external ECU needs a link", allowed="link: socketcan:can0 beside it")


def _ships(calibration: str) -> bool:
    """Whether a calibration of that name ships; told by its file, as the schema takes long to import."""
    import bench.ecu

    return (
        calibration.isidentifier()
        and (Path(bench.ecu.__file__).parent / "calibrations" / f"{calibration}.yaml").exists()
    )


def _check_database(dbc: str | None, mapping: str | None, context: Context) -> None:
    from bench.codec.resolve import load_layout

    try:
        load_layout(dbc, mapping)
    except InputError as error:
        context.add_error(("ecu", "dbc" if dbc is not None else "mapping"), error)
