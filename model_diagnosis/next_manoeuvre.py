"""The next manoeuvre for one vehicle: its library simulated by the replay, and the pairs that have to be told apart."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.answer import CauseDetail
from model_diagnosis.evidence.manoeuvre_library import PlannedManoeuvre
from model_diagnosis.evidence.plan import Pair, plan
from model_diagnosis.evidence.quadratic import total
from model_diagnosis.evidence.replay_model import ReplayModel
from model_diagnosis.evidence.search import Search
from model_diagnosis.evidence.selection import Selection
from model_diagnosis.evidence.stage import ratios
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from model_diagnosis.result import NextManoeuvre
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]

MOVING_M_S = 4.5
SHORTEST_SAMPLES = 100


def simulator(vehicle: VehicleFile, like: Replay) -> Callable[[PlannedManoeuvre, FloatArray], ReplayModel | None]:
    """Simulation of planned manoeuvres with the signals that ``like`` compares; None where the car stops at once."""
    signals = list(dict.fromkeys(name for number in range(len(like.manoeuvres)) for name in like.signals(number)))
    signals = [name for name in signals if not name.startswith(("brake_pressure", "master_pressure"))]
    axles = {"front": "f", "rear": "r", "all": "fr"}.get(str(vehicle.driveline.drive), "fr")

    def simulate(planned: PlannedManoeuvre, theta: FloatArray) -> ReplayModel | None:
        time, inputs = planned.inputs(axles)
        guess = {name: np.zeros_like(time) for name in signals}
        guess["speed"] = np.full_like(time, planned.speed)
        for wheel in WHEELS:
            guess[f"wheel_speed_{wheel}"] = guess["speed"] / getattr(vehicle.wheels, wheel).radius
        first = Replay(vehicle, [_manoeuvre(planned.name, time, guess | inputs)], like.effects)
        run = first.free_run(theta, 0)
        made = {name: run[:, column] for column, name in enumerate(first.signals(0))}
        moving = made["speed"] > MOVING_M_S
        end = len(time) if moving.all() else int(np.argmin(moving))
        if end < SHORTEST_SAMPLES:
            return None
        kept = set(signals) | {f"wheel_speed_{wheel}" for wheel in WHEELS}
        channels = {name: values[:end] for name, values in (made | inputs).items() if name in kept or name in inputs}
        return Replay(vehicle, [_manoeuvre(planned.name, time[:end], channels)], like.effects)

    return simulate


def _manoeuvre(name: str, time: FloatArray, channels: dict[str, FloatArray]) -> Manoeuvre:
    weights = {channel: np.ones_like(time) for channel in channels}
    return Manoeuvre(name, time, channels, weights, source="planned")


def next_manoeuvre(
    vehicle: VehicleFile, replay: Replay, search: Search, selection: Selection, details: Sequence[CauseDetail]
) -> NextManoeuvre | None:
    """What would separate the first cause that stands in a group; None where every cause stands alone."""
    for detail in details:
        others = [number for number in detail.alike.group if number != detail.accepted.hypothesis.effect]
        if others:
            return _separate(vehicle, replay, search, selection, detail, others)
    return None


def _separate(
    vehicle: VehicleFile,
    replay: Replay,
    search: Search,
    selection: Selection,
    detail: CauseDetail,
    others: Sequence[int],
) -> NextManoeuvre | None:
    problem, own = search.problem, detail.accepted.hypothesis
    rest = [one.hypothesis for one in selection.accepted if one.hypothesis is not own]
    theta = selection.fit.theta
    size = problem.scaled(theta)[list(own.columns)]
    pairs = [
        Pair(
            replay.effects[own.effect].name,
            replay.effects[other].name,
            own.columns,
            size,
            tuple(int(column) for column in np.flatnonzero(replay.owner == other)),
        )
        for other in others
    ]
    parts = problem.quadratics(selection.linearisation, problem.rows(theta), theta)
    columns = set(search.related(selection.linearisation, own, rest))
    columns |= {column for pair in pairs for column in pair.other}
    channels = {name for manoeuvre in replay.manoeuvres for name in manoeuvre.channels}
    return plan(
        problem,
        total(parts).information,
        theta,
        pairs,
        ratios(problem, rest),
        channels,
        simulator(vehicle, replay),
        sorted(columns),
    )
