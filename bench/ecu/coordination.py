"""What the wheels do together: release for the reference speed, yaw-moment delay, brake-force distribution, pump."""

from typing import Any

from numba import njit

from bench.ecu.records import BUILD_UP, OFF, RELEASE, TASK_S, WAIT
from bench.ecu.slip_control import advance_phase, assess_wheel, begin_hold, set_valves

_FRONT_LEFT, _FRONT_RIGHT, _REAR_LEFT, _REAR_RIGHT = range(4)
EQUAL, EQUAL_PA = 0.95, 4e5
"""Select low: rear pressures that differ by less than this are taken for equal."""
RETURN_TASKS, RETURNED = 60, 0.8
"""Time that a wheel has to come back after it was released to find the car's speed, and the share when it is back."""


@njit(cache=True)
def _underbrake(calibration: Any, state: Any, wheel: int) -> None:
    """Release a wheel down to where it rolls and keep it there until its speed has been read."""
    goal = 0.8 * calibration.reference_anchor_pressure_ratio * state.road_pressure[wheel]
    state.phase[wheel] = RELEASE if state.pressure[wheel] > goal else WAIT
    state.returning_tasks[wheel] = RETURN_TASKS
    state.timer[wheel] = 0


@njit(cache=True)
def _select_low(state: Any) -> None:
    """Keep the rear wheel with more pressure near the other one: the wheel nearer to locking leads both."""
    higher = _REAR_LEFT if state.pressure[_REAR_LEFT] > state.pressure[_REAR_RIGHT] else _REAR_RIGHT
    lower = 5 - higher
    lead = state.pressure[lower]
    if state.returning_tasks[lower] > 0:
        # released to find the car's speed: what counts is the pressure that it had
        lead = max(lead, state.road_pressure[lower])
    too_high = state.pressure[higher] > lead / EQUAL + EQUAL_PA
    if too_high and state.phase[higher] <= BUILD_UP:
        begin_hold(state, higher)
    if too_high:
        state.inlet[higher] = 1
    if state.phase[lower] == RELEASE and state.returning_tasks[lower] == 0 and state.phase[higher] > BUILD_UP:
        state.inlet[higher], state.outlet[higher] = 1, 1


@njit(cache=True)
def assess_wheels(calibration: Any, state: Any) -> bool:
    """Judge all wheels; True if one of them needs slip control."""
    for wheel in range(4):
        assess_wheel(calibration, state, wheel)
    for wheel in range(4):
        if state.wheel_valid[wheel] and state.predicted_slip_speed[wheel] > state.release_level[wheel]:
            return True
    return False


@njit(cache=True)
def control_slip(calibration: Any, state: Any) -> None:
    """Phases and valves of all wheels while slip is controlled."""
    controlled = 0
    for wheel in range(4):
        if wheel == state.underbraked_wheel and state.phase[wheel] > BUILD_UP:
            _underbrake(calibration, state, wheel)
        else:
            back = state.pressure[wheel] > RETURNED * state.road_pressure[wheel]
            state.returning_tasks[wheel] = 0 if back else max(state.returning_tasks[wheel] - 1, 0)
            advance_phase(calibration, state, wheel, True)
        if state.phase[wheel] > BUILD_UP:
            controlled += 1
        elif state.phase[wheel] == OFF:
            state.phase[wheel] = BUILD_UP
        set_valves(calibration, state, wheel)
    if calibration.slip_rear_select_low > 0.5:
        _select_low(state)
    if controlled == 0:
        state.abs_active = 0


@njit(cache=True)
def rest_valves(state: Any, keep_rear: bool) -> None:
    """Plain braking: valves at rest; ``keep_rear`` leaves the rear wheels to brake-force distribution."""
    state.ebd_active = 0
    state.underbraked_wheel = -1
    for wheel in range(2 if keep_rear else 4):
        state.phase[wheel] = OFF
        state.inlet[wheel], state.outlet[wheel] = 0, 0
    for wheel in range(4):
        state.rolling_tasks[wheel] = 0


@njit(cache=True)
def delay_yaw_moment(calibration: Any, state: Any) -> None:
    """Keep the front wheel on the better side from leaving the other one too fast."""
    left_low = state.phase[_FRONT_LEFT] > BUILD_UP
    right_low = state.phase[_FRONT_RIGHT] > BUILD_UP
    if not left_low and not right_low:
        state.split_difference = calibration.split_allowed_difference
        return
    state.split_difference += calibration.split_difference_rate * TASK_S
    low, high = _FRONT_LEFT, _FRONT_RIGHT
    if not left_low or (right_low and state.road_pressure[_FRONT_RIGHT] < state.road_pressure[_FRONT_LEFT]):
        low, high = _FRONT_RIGHT, _FRONT_LEFT
    allowed = state.road_pressure[low] + state.split_difference
    if state.inlet[high] == 0 and state.pressure[high] > allowed:
        state.inlet[high] = 1


@njit(cache=True)
def _front_speed(state: Any) -> float:
    speed = 0.0
    for wheel in (_FRONT_LEFT, _FRONT_RIGHT):
        if state.wheel_valid[wheel]:
            speed = max(speed, state.path_speed[wheel])
    return speed


@njit(cache=True)
def _compare_with_front(calibration: Any, state: Any, wheel: int, front: float) -> None:
    """Judge a rear wheel by its slip against the front wheels instead of against the reference."""
    offset = calibration.distribution_offset
    hold = calibration.distribution_hold * front + offset
    state.predicted_slip_speed[wheel] = front - state.path_speed[wheel]
    state.release_level[wheel] = calibration.distribution_release * front + offset
    state.end_level[wheel] = hold
    state.build_level[wheel] = 0.5 * hold
    state.recovering[wheel] = 0
    if state.phase[wheel] <= BUILD_UP and state.predicted_slip_speed[wheel] > hold:
        begin_hold(state, wheel)


@njit(cache=True)
def distribute(calibration: Any, state: Any) -> None:
    """Brake-force distribution: keep the rear wheels' slip near the front wheels', without any reference speed."""
    front = _front_speed(state)
    if front < calibration.distribution_least_speed:
        rest_valves(state, False)
        return
    state.ebd_active = 0
    for wheel in (_REAR_LEFT, _REAR_RIGHT):
        judged = wheel if state.wheel_valid[wheel] else 5 - wheel
        if state.wheel_valid[judged]:
            _compare_with_front(calibration, state, judged, front)
            state.predicted_slip_speed[wheel] = state.predicted_slip_speed[judged]
            state.release_level[wheel] = state.release_level[judged]
            state.end_level[wheel] = state.end_level[judged]
            state.build_level[wheel] = state.build_level[judged]
        advance_phase(calibration, state, wheel, False)
        set_valves(calibration, state, wheel)
        if state.phase[wheel] > BUILD_UP:
            state.ebd_active = 1


@njit(cache=True)
def run_pump(calibration: Any, state: Any) -> bool:
    """The return pump runs with every release and a while after the last one."""
    for wheel in range(4):
        if state.outlet[wheel]:
            state.pump_tasks = int(calibration.pressure_pump_run_on / TASK_S) + 1
    if state.pump_tasks > 0:
        state.pump_tasks -= 1
        return True
    return False
