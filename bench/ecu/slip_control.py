"""Phases of a wheel: build-up, hold, release, stepped rebuild, on slip and wheel acceleration.

Slip speed is extrapolated by the wheel's acceleration against the car's over a prediction time that covers hydraulics
and measurement; the thresholds are slips, turned into speeds, with an offset for the low-speed end. Where one build
pulse is much of what the road bears (ice), pulses are rarer and what they overshoot is bled off at once.
"""

from typing import Any

import numpy as np
from numba import njit

from bench.ecu.records import BUILD_UP, OFF, REBUILD, RELEASE, TASK_S, WAIT

LARGEST_DIFFERENCE = 150.0
"""Wheel against car, m/s^2: beyond this a difference is taken for measurement noise."""
LEAST_ROAD_PRESSURE_PA = 2e5
SLICK_ROAD_PA = 6e5
"""What a wheel bears below a friction of about 0.1."""
SLICK_SLIP = 1.2
"""More slip is allowed there: the tyre's peak on ice lies further out and pulses are few."""
FULL_TURN = 5.0
"""Lateral acceleration, m/s^2, at which the rear thresholds are reduced most."""
FALLEN_SINCE = 1.35
"""Pressure when a wheel turned round over that when it is seen, while the outlet is open."""
HEAVY_PULSE, LIGHT_PULSE = 0.3, 0.12
"""Pulse weights: above the first no pulse follows without a gap, below the second pulses are as long as calibrated."""
LEAST_STEP_PA = 1.5e5
CALM_TASKS = 20
"""Rebuilt to the driver's pressure and calm for this long: the wheel needs no control any more."""


@njit(cache=True)
def _pulse_weight(calibration: Any, state: Any, wheel: int) -> float:
    """Pressure of one build pulse over what the road bears; less weight after pulses that had no effect."""
    filled = TASK_S / calibration.pressure_increase_time_constant
    step = filled * (state.master_pressure - state.pressure[wheel])
    return float(step / max(state.road_pressure[wheel], LEAST_ROAD_PRESSURE_PA) * 0.5 ** state.pulses[wheel])


@njit(cache=True)
def _pulse_tasks(calibration: Any, state: Any, wheel: int) -> float:
    """Length of a build pulse: as calibrated, but short enough not to weigh too much."""
    light = np.floor(LIGHT_PULSE / max(_pulse_weight(calibration, state, wheel), 1e-3))
    return float(max(min(calibration.pressure_pulse_tasks, light), 1.0))


@njit(cache=True)
def _turn_share(calibration: Any, state: Any, axle: int) -> float:
    """Share of the slip thresholds that is left in a turn: the rear tyres are needed for guidance."""
    if axle == 0:
        return 1.0
    turn = min(abs(state.yaw_rate) * state.reference / FULL_TURN, 1.0)
    return float(1.0 - calibration.slip_turn_reduction * turn)


@njit(cache=True)
def assess_wheel(calibration: Any, state: Any, wheel: int) -> None:
    """Predicted slip speed of a wheel and the levels that it is compared with, m/s."""
    axle = wheel // 2
    reference = state.reference
    slip_speed = reference - state.path_speed[wheel]
    difference = state.predicted_acceleration - state.acceleration[wheel]
    difference = min(max(difference, -LARGEST_DIFFERENCE), LARGEST_DIFFERENCE)
    offset = calibration.slip_offset[axle]
    predicted = slip_speed + calibration.slip_prediction[axle] * difference
    share = _turn_share(calibration, state, axle)
    if state.abs_active and 0.0 < state.road_pressure[wheel] < SLICK_ROAD_PA:
        share *= SLICK_SLIP
    release = share * calibration.slip_release[axle] * reference + offset
    entry = calibration.slip_entry[axle] * reference + 0.5 * offset
    if slip_speed > entry and difference > calibration.slip_critical_deceleration[axle]:
        predicted = max(predicted, release + 0.01)
    if slip_speed < entry and (state.phase[wheel] <= BUILD_UP or not state.abs_active):
        predicted = min(predicted, release)
    state.predicted_slip_speed[wheel] = predicted
    state.release_level[wheel] = release
    state.end_level[wheel] = share * calibration.slip_release_end[axle] * reference + offset
    caution = min(max(1.2 - 0.3 * _pulse_weight(calibration, state, wheel), 0.6), 1.0)
    state.build_level[wheel] = share * calibration.slip_build[axle] * reference * caution
    state.recovering[wheel] = 1 if -difference > calibration.slip_recovery_acceleration[axle] else 0


@njit(cache=True)
def _enter(state: Any, wheel: int, phase: int) -> None:
    state.phase[wheel] = phase
    state.timer[wheel] = 0


@njit(cache=True)
def _begin_release(state: Any, wheel: int) -> None:
    if state.phase[wheel] <= BUILD_UP:
        state.road_pressure[wheel] = state.pressure[wheel]
    state.release_start[wheel] = state.pressure[wheel]
    state.pulses[wheel] = 0
    state.calm_tasks[wheel] = 0
    state.bleeding[wheel] = 0
    _enter(state, wheel, RELEASE)


@njit(cache=True)
def begin_hold(state: Any, wheel: int) -> None:
    """Close the inlet valve of a wheel that was not controlled before."""
    state.road_pressure[wheel] = state.pressure[wheel]
    state.pulses[wheel] = 0
    state.calm_tasks[wheel] = 0
    state.since_pulse[wheel] = 0
    state.bleeding[wheel] = 0
    _enter(state, wheel, WAIT)


@njit(cache=True)
def _learn_road_pressure(state: Any, wheel: int) -> None:
    """What the road bears: brake and tyre balance where a falling wheel turns round; a calm wheel bears what it has."""
    rising = state.acceleration[wheel] > state.predicted_acceleration
    turned = rising and not state.was_rising[wheel] and state.phase[wheel] in (RELEASE, WAIT)
    state.was_rising[wheel] = 1 if rising else 0
    if turned and state.returning_tasks[wheel] == 0:
        # while the outlet is open, pressure has fallen on since the wheel really turned
        late = FALLEN_SINCE if state.phase[wheel] == RELEASE else 1.1
        state.road_pressure[wheel] = min(state.road_pressure[wheel], late * state.pressure[wheel])
    if state.phase[wheel] == REBUILD and not state.bleeding[wheel] and state.timer[wheel] > 3:
        state.road_pressure[wheel] = max(state.road_pressure[wheel], state.pressure[wheel])


@njit(cache=True)
def _is_deep(state: Any, wheel: int) -> bool:
    """Slip so far beyond the release level that pressure is released without awaiting the effect."""
    return bool(state.predicted_slip_speed[wheel] > 2.0 * state.release_level[wheel])


@njit(cache=True)
def _step_done(calibration: Any, state: Any, wheel: int) -> bool:
    """Has this release taken its share of the pressure?"""
    rest = (1.0 - calibration.pressure_release_step) * state.release_start[wheel]
    return bool(state.pressure[wheel] <= min(rest, 1.25 * state.road_pressure[wheel]) and not _is_deep(state, wheel))


@njit(cache=True)
def _release_has_acted(calibration: Any, state: Any, wheel: int) -> bool:
    """After a release step its effect is awaited before the next one."""
    if state.phase[wheel] != WAIT or _is_deep(state, wheel):
        return True
    return bool(state.timer[wheel] > calibration.pressure_release_gap_tasks)


@njit(cache=True)
def _gap_tasks(calibration: Any, state: Any, wheel: int) -> float:
    """Hold between two build pulses: none far below what the road bears, longer where a pulse weighs much."""
    weight = _pulse_weight(calibration, state, wheel)
    if state.pressure[wheel] < calibration.pressure_fast_rebuild * state.road_pressure[wheel] and weight < HEAVY_PULSE:
        return 0.0
    gap = calibration.pressure_pulse_gap_tasks * (1.0 + weight)
    return gap / 3.0 if state.pulses[wheel] > calibration.pressure_quick_after_pulses else gap


@njit(cache=True)
def _start_pulse(state: Any, wheel: int) -> None:
    step = max(0.1 * state.road_pressure[wheel], LEAST_STEP_PA) * 2.0 ** min(state.pulses[wheel], 10)
    state.goal[wheel] = max(state.pressure[wheel] + step, 0.9 * state.road_pressure[wheel])
    state.bleeding[wheel] = 0
    state.since_pulse[wheel] = 0
    state.pulses[wheel] += 1
    _enter(state, wheel, REBUILD)


@njit(cache=True)
def _may_pulse(calibration: Any, state: Any, wheel: int) -> bool:
    cycle = _pulse_tasks(calibration, state, wheel) + _gap_tasks(calibration, state, wheel)
    return bool(state.since_pulse[wheel] >= cycle and not state.bleeding[wheel])


@njit(cache=True)
def _rebuild(calibration: Any, state: Any, wheel: int) -> None:
    """Pulse, bleed off what it overshot, hold; then the next pulse, or a hold while slip is moderate."""
    pulse = _pulse_tasks(calibration, state, wheel)
    if state.timer[wheel] >= pulse:
        above = state.pressure[wheel] > 1.1 * state.goal[wheel]
        state.bleeding[wheel] = 1 if above and (state.timer[wheel] == pulse or state.bleeding[wheel]) else 0
        if state.predicted_slip_speed[wheel] > state.build_level[wheel] and not state.bleeding[wheel]:
            _enter(state, wheel, WAIT)
        elif _may_pulse(calibration, state, wheel):
            _start_pulse(state, wheel)
    state.calm_tasks[wheel] += 1
    if state.pressure[wheel] > 0.98 * state.master_pressure and state.calm_tasks[wheel] > CALM_TASKS:
        _enter(state, wheel, BUILD_UP)


@njit(cache=True)
def _wait(calibration: Any, state: Any, wheel: int, probe: bool) -> None:
    """Hold until slip is small enough for a pulse, or so long that a probing pulse is due."""
    patience = calibration.pressure_hold_tasks * (1.0 + 4.0 * _pulse_weight(calibration, state, wheel))
    small = state.predicted_slip_speed[wheel] < state.build_level[wheel]
    if (small and _may_pulse(calibration, state, wheel)) or (probe and state.timer[wheel] > patience):
        _start_pulse(state, wheel)


@njit(cache=True)
def _release(calibration: Any, state: Any, wheel: int) -> None:
    ended = state.predicted_slip_speed[wheel] < state.end_level[wheel] or state.recovering[wheel]
    if ended or _step_done(calibration, state, wheel):
        _enter(state, wheel, WAIT)


@njit(cache=True)
def advance_phase(calibration: Any, state: Any, wheel: int, probe: bool) -> None:
    """Next phase of a wheel; ``probe`` allows pulses after a long hold at moderate slip."""
    phase = state.phase[wheel]
    state.timer[wheel] += 1
    state.since_pulse[wheel] += 1
    _learn_road_pressure(state, wheel)
    unstable = state.predicted_slip_speed[wheel] > state.release_level[wheel] and not state.recovering[wheel]
    if phase == RELEASE:
        _release(calibration, state, wheel)
    elif unstable and _release_has_acted(calibration, state, wheel):
        _begin_release(state, wheel)
    elif phase == WAIT:
        _wait(calibration, state, wheel, probe)
    elif phase == REBUILD:
        _rebuild(calibration, state, wheel)


@njit(cache=True)
def set_valves(calibration: Any, state: Any, wheel: int) -> None:
    """Valves of a wheel for its phase."""
    phase = state.phase[wheel]
    pulse = phase == REBUILD and state.timer[wheel] < _pulse_tasks(calibration, state, wheel)
    open_inlet = phase in (OFF, BUILD_UP) or pulse
    state.inlet[wheel] = 0 if open_inlet else 1
    state.outlet[wheel] = 1 if phase == RELEASE or (phase == REBUILD and state.bleeding[wheel] and not pulse) else 0
