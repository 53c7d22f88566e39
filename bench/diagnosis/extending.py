"""What was found as a vehicle file that the plant runs, and what it changes in a stop with the ECU in the loop."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bench.diagnosis.recordings import recording_of
from bench.diagnosis_report.words import accepted
from model_diagnosis.effects.effect import EffectParameter
from model_diagnosis.findings import Findings
from model_diagnosis.gain import is_proven, is_worse_than_a_refit
from model_diagnosis.result import Cause, Diagnosis, Gain, ParameterEstimate
from signals.errors import BenchError
from vehicle_model.vehicle_file import VehicleFile

STOP = "stops/dry"
GENTLE_PEDAL_FORCE = "150 N"
BEFORE, AFTER = "vehicle file", "extended"


def write_extension(findings: Findings, path: Path, vehicle: VehicleFile, vehicle_argument: str) -> Diagnosis:
    """Write the extended vehicle file where what was found gains; the diagnosis with its name, or why there is none."""
    from bench.loop.versions import versions
    from model_diagnosis.extension.extended_vehicle import extensions_of, hashes_of_logs, write_extended_vehicle
    from vehicle_model.extension_file import Provenance

    diagnosis = findings.diagnosis
    if not diagnosis.causes and not findings.terms and not findings.numbers:
        return diagnosis
    if why := _why_not(diagnosis.gain):
        return _remarked(diagnosis, [f"no extended vehicle file: {why}"])
    provenance = Provenance(data=hashes_of_logs(_files(findings.logs)), versions=versions())
    found = [_found(cause, diagnosis) for cause in accepted(diagnosis)] or findings.numbers
    extensions, remarks = extensions_of(vehicle, found, findings.terms, provenance)
    if not extensions:
        return _remarked(diagnosis, remarks)
    write_extended_vehicle(path, vehicle_argument, vehicle, extensions, remarks)
    return _remarked(diagnosis, remarks).model_copy(update={"extension_file": path.name})


def _why_not(gain: Gain | None) -> str:
    """Why an extension with this gain is not written, or an empty text."""
    if gain is None:
        return "no data is left to measure a gain on"
    if not is_proven(gain):
        return "no gain on data that took no part"
    if is_worse_than_a_refit(gain):
        return "a refit of the vehicle file's own numbers does better; bench vehicle fit makes one"
    return ""


def with_stops(diagnosis: Diagnosis, vehicle_argument: str, extended: Path) -> Diagnosis:
    """The diagnosis with figures of two stops in the closed loop, by the vehicle file and by the extended one."""
    if diagnosis.gain is None:
        return diagnosis
    try:
        figures = _stop_figures(vehicle_argument, extended)
    except BenchError as error:
        return _remarked(diagnosis, [f"no stop with the extended car: {error.message}"])
    gain = diagnosis.gain.model_copy(update={"user_figures": diagnosis.gain.user_figures | figures})
    return diagnosis.model_copy(update={"gain": gain})


def deviation_of(estimate: ParameterEstimate, parameter: EffectParameter, value: float) -> float:
    """Deviation from the vehicle file that stands for a physical value."""
    if parameter.relative:
        return value / estimate.nominal - 1.0 if estimate.nominal != 0.0 else value
    return value - estimate.nominal


def _stop_figures(vehicle_argument: str, extended: Path) -> dict[str, dict[str, float]]:
    """Distance, ABS cycles and the friction estimate's error, each by the vehicle file and by the extended one."""
    figures: dict[str, dict[str, float]] = {}
    for when, car in ((BEFORE, vehicle_argument), (AFTER, str(extended))):
        hard, gentle = _stop(car, {}), _stop(car, {"manoeuvre.steps.brake.brake.pedal_force": GENTLE_PEDAL_FORCE})
        told = {
            "stop with ABS from 100 km/h [m]": hard.metrics.get("stopping_distance_m"),
            f"stop with {GENTLE_PEDAL_FORCE} from 100 km/h [m]": gentle.metrics.get("stopping_distance_m"),
            "ABS cycles of the busiest wheel": max(hard.metrics.get("abs_cycles") or [0.0]),
            "error of the friction estimate [1]": _friction_error(hard),
        }
        for name, value in told.items():
            if isinstance(value, (int, float)):
                figures.setdefault(name, {})[when] = float(value)
    return {name: values for name, values in figures.items() if len(values) == 2}


def _stop(car: str, changes: dict[str, str]) -> Any:
    from bench.api import run

    sets = {"road.surface": "own_curve"} | changes
    return run(STOP, vehicle=car, ecu="inprocess", pacing="lockstep", record=False, sets=sets).verdict


def _friction_error(verdict: Any) -> float | None:
    for estimator in verdict.estimators.values():
        error = estimator.get("rmse", {}).get("friction_limit_mean")
        if error is not None:
            return float(error)
    return None


def _found(cause: Cause, diagnosis: Diagnosis) -> Any:
    from model_diagnosis.effects.catalogue import effect as find_effect
    from model_diagnosis.effects.conditions import everywhere
    from model_diagnosis.extension.extended_vehicle import FoundEffect, Interval

    effect = find_effect(cause.effect)
    by_name = {parameter.name: parameter for parameter in effect.parameters}
    deviations = {}
    for name, estimate in cause.parameters.items():
        value, *ends = (
            deviation_of(estimate, by_name[everywhere(name)], quantity)
            for quantity in (estimate.value, estimate.low, estimate.high)
        )
        deviations[name] = Interval(value, min(ends), max(ends))
    gain = diagnosis.gain
    evidence = "" if gain is None else f"error left on data that took no part: {100 * gain.overall.ratio:.0f} %"
    return FoundEffect(effect, deviations, cause.probability, cause.evidence, tuple(cause.group), evidence)


def _files(logs: Sequence[str]) -> list[Path]:
    """Files behind the logs; of a run its recording."""
    files = []
    for log in logs:
        recording = recording_of(log)
        path = recording / "signals.mf4" if recording is not None and recording.is_dir() else recording or Path(log)
        files += [path] if path.is_file() else []
    return files


def _remarked(diagnosis: Diagnosis, remarks: Sequence[str]) -> Diagnosis:
    return diagnosis.model_copy(update={"remarks": [*diagnosis.remarks, *remarks]})
