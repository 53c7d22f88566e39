"""All checks of manoeuvres: channels against each other, and against the replay where there is one."""

from collections.abc import Iterator, Sequence

import numpy as np

from model_diagnosis.data.command_checks import find_command, without_command
from model_diagnosis.data.delay_acceptance import accepted_delays, settled_delays
from model_diagnosis.data.delay_checks import (
    INERTIAL,
    PLAIN_GAIN,
    LagRelation,
    Late,
    candidates,
    explain_lags,
    fault_of,
    lag_relations,
    refined_delays,
    set_right,
    with_rests,
)
from model_diagnosis.data.drift_checks import check_drift
from model_diagnosis.data.drive_clocks import check_drive_clocks, with_common
from model_diagnosis.data.faults import distinct
from model_diagnosis.data.geometry import Geometry, geometry_of
from model_diagnosis.data.level_checks import check_constant, check_load_sign, restore_wraps
from model_diagnosis.data.low_pass_checks import check_low_pass
from model_diagnosis.data.replayed import ReplayFactory, replayed_manoeuvres
from model_diagnosis.data.replayed_filters import check_replayed_filters
from model_diagnosis.data.swap_checks import check_swapped_wheels
from model_diagnosis.data.undefined_values import check_free_wheels
from model_diagnosis.data.undriven_forces import check_undriven_forces
from model_diagnosis.data.unit_checks import check_units
from model_diagnosis.data.unsure_clock import check_unsure_clock
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.result import DataFault
from signals.errors import InputError
from vehicle_model.vehicle_file import VehicleFile

_LARGE_DELAY_S = 0.15


def check_data(
    manoeuvres: Sequence[Manoeuvre], vehicle: VehicleFile, replay: ReplayFactory | None = None
) -> tuple[list[DataFault], list[Manoeuvre]]:
    """Name what is wrong with the data before any physics, and repair it where that is safe.

    Parameters
    ----------
    replay : the class ``Replay`` (or what builds one from vehicle and manoeuvres). With it lags and filters are judged
        against the car's own answer, and a delay is accepted only where the innovations of a refitted replay shrink.

    Returns
    -------
    faults, those found while reading first; repaired manoeuvres, in the same order
    """
    geometry = geometry_of(vehicle)
    reading = [fault for m in manoeuvres for fault in m.reading_faults]
    faults: list[DataFault] = list(reading)
    repaired = restore_wraps(manoeuvres, reading, geometry)
    for check in (check_constant, check_load_sign, check_free_wheels, check_undriven_forces):
        found, repaired = check(repaired)
        faults += found
    for compare in (check_units, check_swapped_wheels):
        found, repaired = compare(repaired, geometry)
        faults += found
    found, repaired = check_drift(repaired, geometry)
    faults += found
    replayable = replay if replay is not None and _can_be_replayed(repaired, vehicle, replay) else None
    clocks, repaired = check_drive_clocks(repaired, geometry, vehicle, replayable)
    found, repaired = _check_filters(repaired, geometry, vehicle, replayable)
    faults += found
    found, large, small, repaired = _check_delays(repaired, geometry, vehicle, None)
    faults += found
    if replayable is not None:
        unsure, repaired = check_unsure_clock(repaired, geometry, vehicle, replayable)
        large, further = with_rests(large, unsure)
        large += further
        replayed = _replayed(repaired, vehicle, replayable)
        large, repaired = refined_delays(large, lag_relations(repaired, geometry, replayed), repaired)
        found, further, small, repaired = _check_delays(repaired, geometry, vehicle, replayable)
        faults += found
        large, further = with_rests(large, further)
        large, small = with_rests([*large, *further], small)
        large, repaired = settled_delays(large, repaired, vehicle, replayable)
    clocks, (large, small) = with_common(clocks, large, small)
    faults += [clock.fault() for clock in clocks]
    # what was shifted and then shifted back is not late
    faults += [fault_of(late) for late in (*large, *small) if round(late.delay_s / SAMPLE_TIME_S)]
    return distinct(faults), repaired


def _can_be_replayed(manoeuvres: Sequence[Manoeuvre], vehicle: VehicleFile, replay: ReplayFactory) -> bool:
    try:
        replay(vehicle, manoeuvres)
    except InputError:
        return False
    return True


def _replayed(
    manoeuvres: Sequence[Manoeuvre], vehicle: VehicleFile, replay: ReplayFactory | None
) -> list[Manoeuvre] | None:
    if replay is None:
        return None
    model = replay(vehicle, manoeuvres)
    return replayed_manoeuvres(model, manoeuvres, np.zeros(len(model.columns)))


def _check_filters(
    manoeuvres: Sequence[Manoeuvre], geometry: Geometry, vehicle: VehicleFile, replay: ReplayFactory | None
) -> tuple[list[DataFault], list[Manoeuvre]]:
    """Low-passed channels: inertial ones that a replay predicts are judged by it, the others by their twins."""
    replayed = _replayed(manoeuvres, vehicle, replay)
    if replay is None or replayed is None:
        return check_low_pass(manoeuvres, geometry)
    driven = any(name.startswith(("drive_torque", "engine_torque")) for m in manoeuvres for name in m.channels)
    # without a torque the replay is driven by this channel and follows it
    own = () if driven else ("longitudinal_acceleration",)
    predicted = [channel for channel in INERTIAL if channel not in own]
    faults, repaired = check_replayed_filters(manoeuvres, replayed, predicted, vehicle, replay)
    found, repaired = check_low_pass(repaired, geometry, replayed, (*own, "speed"))
    return faults + found, repaired


def _check_delays(
    manoeuvres: Sequence[Manoeuvre], geometry: Geometry, vehicle: VehicleFile, replay: ReplayFactory | None
) -> tuple[list[DataFault], list[Late], list[Late], list[Manoeuvre]]:
    """Commands among the measurements, late channels by correlation, those by innovations, repaired manoeuvres.

    With a replay the small delays too, each accepted by its innovations unless it is plainly large.
    """
    replayed = _replayed(manoeuvres, vehicle, replay)
    relations = lag_relations(manoeuvres, geometry, replayed)
    repaired = list(manoeuvres)
    named: list[DataFault] = []
    for command in find_command(repaired, relations, vehicle):
        fault, repaired = without_command(repaired, command)
        named.append(fault)
    if named:  # what drives the replay is another thing now
        replayed = _replayed(repaired, vehicle, replay)
        relations = lag_relations(repaired, geometry, replayed)
    sets = candidates(repaired)
    late_sets = explain_lags(relations, sets, proposed=replay is not None)
    large = [
        late for late in late_sets if replay is None or (abs(late.delay_s) > _LARGE_DELAY_S and late.gain > PLAIN_GAIN)
    ]
    for late in large:
        repaired = [set_right(m, late.channels, late.delay_s) for m in repaired]
    small: list[Late] = []
    if replay is not None:
        for proposed in _explanations([late for late in late_sets if late not in large], large, relations, sets):
            small, repaired = accepted_delays(proposed, repaired, vehicle, replay)
            if small:
                break
    return named, large, small, repaired


def _explanations(
    likeliest: Sequence[Late], large: Sequence[Late], relations: Sequence[LagRelation], sets: Sequence[Late]
) -> Iterator[Sequence[Late]]:
    """Explanations of the lags that the large delays leave, the likeliest first and then simpler ones.

    Where the innovations refuse several late sets, one of them may be late by itself, by another delay than it has
    beside the others; else something else is.
    """
    if likeliest:
        yield likeliest
    if len(likeliest) < 2:
        return
    known, refused = [late.groups for late in large], [late.groups for late in likeliest]
    others = [one for one in sets if one.groups not in refused]
    for candidate_sets in (sets, others):
        found = explain_lags(relations, candidate_sets, proposed=True, most=len(known) + len(likeliest) - 1)
        simpler = [late for late in found if late.groups not in known]
        if 0 < len(simpler) < len(likeliest):
            yield simpler
