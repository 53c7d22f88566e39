"""Estimators on signals that are already there: a recording of the bench gives what the live estimator gave."""

import time
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.estimation.source import Source
from bench.recording.arrays import FloatArray, RunArrays
from bench.scenario.estimator_names import kind_of
from bench.verdict.assessment import Assessment, NoValueError
from bench.verdict.metrics import truth
from bench.verdict.truth import truth_of
from estimators import create, describe
from estimators.registry import validate_settings
from signals.catalogue import Signal
from signals.errors import InputError

_WARM_UP_ROWS = 64


@dataclass(frozen=True)
class Request:
    """An estimator to run: its name here, its kind in the registry, its settings."""

    name: str
    kind: str
    settings: Mapping[str, Any]


@dataclass(frozen=True)
class OfflineEstimate:
    """What an estimator made of the signals.

    Attributes
    ----------
    outputs : tuple of Signal
        Named ``<name>.<output>``.
    time : array, shape (n,)
    values : array, shape (n, len(outputs))
    step_time_us : float
        Mean processor time of a step, the loop over the rows included.
    """

    request: Request
    outputs: tuple[Signal, ...]
    time: FloatArray
    values: FloatArray
    step_time_us: float

    @property
    def name(self) -> str:
        """Name of the estimator here."""
        return self.request.name

    def output(self, name: str) -> FloatArray:
        """Values of an output, by its name without the estimator's."""
        names = [signal.name.partition(".")[2] for signal in self.outputs]
        return self.values[:, names.index(name)]

    def has(self, name: str) -> bool:
        """Whether there is an output of this name."""
        return any(signal.name.partition(".")[2] == name for signal in self.outputs)

    def running(self) -> NDArray[np.bool_]:
        """Rows in which it ran."""
        return self.output("active") > 0.5 if self.has("active") else np.ones(len(self.time), np.bool_)

    def confident(self, name: str) -> NDArray[np.bool_]:
        """Rows in which an output is to be trusted; all where it has no confidence beside it."""
        label = f"{name}_confidence"
        return self.output(label) > 0.5 if self.has(label) else np.ones(len(self.time), np.bool_)


def requests_of(names: Sequence[str], sets: Mapping[str, Any], source: Source) -> list[Request]:
    """Estimators with their settings: those of the recording's scenario, then those of ``--set``.

    Parameters
    ----------
    names : sequence of str
        As in a scenario: ``friction_ekf``, or ``friction_ekf_ANYTHING`` for a second one. Without any, those that the
        scenario ran.
    sets : mapping
        ``KEY`` for every estimator that has it, ``NAME.KEY`` for one.

    Raises
    ------
    InputError
        If there is no estimator to run, or nothing of the name of an estimator or a setting.
    """
    chosen = list(dict.fromkeys(names)) or list(source.estimators)
    if not chosen:
        raise InputError(
            f"{source.path}: which estimator?", mend="name one: --estimator friction_ekf (all: bench estimators list)"
        )
    settings = {name: dict(source.estimators.get(name, {})) for name in chosen}
    for key, value in sets.items():
        for name in _receivers(key, chosen):
            path = key.partition(".")[2] if key.partition(".")[0] == name else key
            settings[name] = _with(settings[name], path.split("."), value)
    requests = [Request(name, kind_of(name), settings[name]) for name in chosen]
    for request in requests:
        validate_settings(request.kind, request.settings)
    return requests


def _receivers(key: str, names: Sequence[str]) -> list[str]:
    first = key.partition(".")[0]
    if first in names:
        return [first]
    knowing = [name for name in names if first in describe(kind_of(name)).settings.model_fields]
    return knowing or list(names[:1])  # the first one says what keys there are


def _with(settings: Mapping[str, Any], path: Sequence[str], value: Any) -> dict[str, Any]:
    """Settings with one value replaced, also one in a group."""
    first, *rest = path
    inner = settings.get(first)
    return {**settings, first: _with(inner if isinstance(inner, Mapping) else {}, rest, value) if rest else value}


def run_offline(source: Source, vehicle: Mapping[str, float], requests: Sequence[Request]) -> list[OfflineEstimate]:
    """Run estimators over the rows of a source.

    Parameters
    ----------
    vehicle : mapping
        Numbers of the nominal vehicle: dotted path to SI value.

    Raises
    ------
    InputError
        If a signal is missing that an estimator reads, or the vehicle lacks a number.
    """
    for request in requests:
        _check_inputs(source, request)
    return [_run(source, vehicle, request) for request in requests]


def _check_inputs(source: Source, request: Request) -> None:
    description = describe(request.kind)
    settings = validate_settings(request.kind, request.settings)
    missing = source.missing(description.inputs(settings))
    if not missing:
        return
    if source.measured:
        mend = ["name them in the channel map: channels: {" + missing[0] + ": {source: COLUMN, unit: UNIT}}"]
    else:
        mend = ['record them: recording: {signals: ["*"]} in the scenario']
    mend += [f"or do without: --set {key}={choice}" for key, choice in _frugal_choices(source, request)]
    raise InputError(f"{source.path}: {request.name} needs {', '.join(missing)}", mend="\n".join(mend))


def _frugal_choices(source: Source, request: Request) -> list[tuple[str, Any]]:
    """Settings with which the estimator would need no signal that is missing."""
    description = describe(request.kind)
    found = []
    for key, field in description.settings.model_fields.items():
        if typing.get_origin(field.annotation) is not typing.Literal:
            continue
        for choice in typing.get_args(field.annotation):
            settings = validate_settings(request.kind, {**request.settings, key: choice})
            if not source.missing(description.inputs(settings)):
                found.append((key, choice))
    return found


def _run(source: Source, vehicle: Mapping[str, float], request: Request) -> OfflineEstimate:
    estimator = create(request.kind, vehicle, request.settings)
    inputs = estimator.inputs
    columns, ages = source.columns(inputs), source.ages(inputs)
    first = slice(0, _WARM_UP_ROWS)
    # compiling is no part of the time of a step
    create(request.kind, vehicle, request.settings).replay(
        {name: values[first] for name, values in columns.items()}, {name: age[first] for name, age in ages.items()}
    )
    began = time.process_time()
    values = estimator.replay(columns, ages)
    step_time_us = 1e6 * (time.process_time() - began) / len(values)
    outputs = tuple(
        Signal(
            f"{request.name}.{signal.name.partition('.')[2]}", signal.unit, signal.description, signal.block,
            signal.display_unit, signal.display_factor,
        )
        for signal in estimator.outputs
    )  # fmt: skip
    return OfflineEstimate(request, outputs, source.data.time, values, step_time_us)


@dataclass(frozen=True)
class Comparison:
    """An output beside its reference, over the rows in which the estimator ran and the reference is known.

    ``rmse_confident`` is that of the rows with the output's confidence; None where it has none, or never was sure.
    """

    reference: FloatArray
    signals: tuple[str, ...]
    rmse: float
    mean_error: float
    rmse_confident: float | None = None


def with_estimates(data: RunArrays, estimates: Sequence[OfflineEstimate]) -> RunArrays:
    """Signals of a run with the estimates beside them, in place of live ones of the same name."""
    columns = {name: data.array(name) for name in data.names}
    units = dict(data.units)
    for estimate in estimates:
        for position, signal in enumerate(estimate.outputs):
            columns[signal.name] = estimate.values[:, position]
            units[signal.name] = signal.unit
    return RunArrays(
        data.time, columns, units, phase_names=data.phase_names, timing=data.timing, information=data.information
    )


def compare(data: RunArrays, estimate: OfflineEstimate) -> dict[str, Comparison]:
    """Outputs that the source has a reference of, by their name without the estimator's."""
    assessment = Assessment(data)
    found: dict[str, Comparison] = {}
    for position, signal in enumerate(estimate.outputs):
        expected = truth_of(signal.name)
        if expected is None:
            continue
        try:
            reference = truth(assessment, signal.name)
        except NoValueError:
            continue
        name = signal.name.partition(".")[2]
        known = estimate.running() & np.isfinite(reference)
        error = estimate.values[:, position] - reference
        if known.any():
            sure = known & estimate.confident(name)
            confident = _rms(error[sure]) if estimate.has(f"{name}_confidence") and sure.any() else None
            mean = float(np.mean(error[known]))
            found[name] = Comparison(reference, expected.signals, _rms(error[known]), mean, confident)
    return found


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
