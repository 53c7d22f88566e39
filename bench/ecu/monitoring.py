"""Watching the inputs: what is missing, refused or implausible, what is still allowed, and how faults heal."""

from typing import Any

from numba import njit

from bench.ecu.fault_memory import (
    forget_at_key_on,
    forget_messages,
    heal_after_healthy_drive,
    set_fault,
    store_and_select,
)
from bench.ecu.faults import (
    IMPLAUSIBLE_BRAKE,
    IMPLAUSIBLE_INERTIAL,
    IMPLAUSIBLE_WHEEL,
    MISSING_WHEEL,
    PROTECTION,
    TIMEOUT,
)
from bench.ecu.records import (
    AGE_TICKS,
    BRAKE,
    EDGES_FL,
    INERTIAL,
    PERIOD_TICKS,
    PRESENT,
    REJECTED,
    SOURCES,
    SPEED_FRONT,
    SPEED_REAR,
    STATUS,
    TASK_S,
    TASK_TICKS,
    bus_position,
)

_SOURCES = len(SOURCES)
_SPEED = bus_position("wheel_speed_fl")
_ACCELERATION = bus_position("longitudinal_acceleration")
_SWITCH = bus_position("brake_switch")
_MASTER = bus_position("master_pressure")
_IGNITION = bus_position("ignition")

NEVER_TICKS = 100_000_000
SLEEP_TICKS = 5_000
LARGEST_CAR_ACCELERATION = 15.0
ACCELERATION_CONTRADICTION = 4.0
SWITCH_PRESSURE_PA = 1e6
SWITCH_TIME_S = 1.0
JUMP_WEIGHT, JUMP_LIMIT = 8, 40
"""A jump of a wheel's speed weighs that many tasks; a fault once the sum is reached."""
REFUSED_WEIGHT = 2
STANDING_M_S = 0.5
UNBRAKED_PA = 3e5


@njit(cache=True)
def _watch_message(calibration: Any, state: Any, health: Any, source: int) -> None:
    """Missing and refused frames of one source."""
    if not health[source, PRESENT]:
        return
    age, period = health[source, AGE_TICKS], max(health[source, PERIOD_TICKS], TASK_TICKS)
    refused = health[source, REJECTED] - state.rejected_before[source]
    state.rejected_before[source] = health[source, REJECTED]
    bucket = state.rejected_run[source] + REFUSED_WEIGHT * refused
    if refused == 0 and age < period:
        bucket = max(bucket - 1, 0)
    limit = REFUSED_WEIGHT * int(calibration.monitoring_rejected_frames)
    state.rejected_run[source] = min(bucket, 2 * limit)
    if age < NEVER_TICKS:
        state.seen[source] = 1
    starting = not state.seen[source] and state.age_tasks * TASK_S < calibration.monitoring_start_time
    late = not starting and age > calibration.monitoring_timeout_periods * period
    # silence in which frames came but were refused is the protection's fault, not the sender's
    by_protection = state.rejected_run[source] > limit or (late and state.rejected_run[source] > 0)
    set_fault(state, PROTECTION + source, by_protection)
    set_fault(state, TIMEOUT + source, late and not by_protection)


@njit(cache=True)
def _moving_wheels(state: Any, speed: float) -> int:
    count = 0
    for wheel in range(4):
        if state.previous_speed[wheel] > speed:
            count += 1
    return count


@njit(cache=True)
def _is_dead(calibration: Any, state: Any, wheel: int) -> bool:
    """Does a wheel stand although nothing brakes it and the car moves?"""
    if state.previous_speed[wheel] > STANDING_M_S:
        return False
    driving = _moving_wheels(state, calibration.monitoring_healing_speed) >= 2
    unbraked = not state.braking or state.pressure[wheel] < UNBRAKED_PA
    return bool(driving and unbraked)


@njit(cache=True)
def _watch_wheel(calibration: Any, state: Any, values: Any, wheel: int, compare: bool) -> None:
    """Missing pulses, contradiction with the wheel-speed frame, impossible jumps."""
    state.stopped_tasks[wheel] = state.stopped_tasks[wheel] + 1 if _is_dead(calibration, state, wheel) else 0
    patience = calibration.monitoring_missing_wheel_time
    if state.braking:
        patience = 0.3 * patience
    set_fault(state, MISSING_WHEEL + wheel, state.stopped_tasks[wheel] * TASK_S > patience)

    own = state.wheel_speed[wheel]
    difference = abs(own - values[_SPEED + wheel]) * calibration.wheel_radius[wheel]
    allowed = 2.0 + calibration.monitoring_speed_difference * own * calibration.wheel_radius[wheel]
    contradiction = compare and difference > allowed
    state.contradiction_tasks[wheel] = state.contradiction_tasks[wheel] + 1 if contradiction else 0
    # a jump that the frame confirms is the wheel's own; the first task after power-on is none
    jumped = abs(state.raw_acceleration[wheel]) > calibration.monitoring_wheel_acceleration and state.age_tasks > 20
    jumps = state.jump_tasks[wheel] + JUMP_WEIGHT if jumped else max(state.jump_tasks[wheel] - 1, 0)
    state.jump_tasks[wheel] = min(jumps, 2 * JUMP_LIMIT)
    lasting = state.contradiction_tasks[wheel] * TASK_S > calibration.monitoring_implausible_time
    set_fault(state, IMPLAUSIBLE_WHEEL + wheel, lasting or jumps >= JUMP_LIMIT)


@njit(cache=True)
def _comparable(state: Any, health: Any, wheel: int, with_edges: bool) -> bool:
    """Did both the pulses and the speed frame of a wheel arrive within this task?"""
    source = SPEED_FRONT if wheel < 2 else SPEED_REAR
    arrived = health[source, AGE_TICKS] < TASK_TICKS and state.fresh[wheel] == 1
    return bool(with_edges and state.seen[source] and state.seen[EDGES_FL + wheel] and arrived)


@njit(cache=True)
def _watch_brake(state: Any, values: Any, present: bool) -> None:
    contradiction = present and values[_MASTER] > SWITCH_PRESSURE_PA and values[_SWITCH] < 0.5
    state.pedal_tasks = state.pedal_tasks + 1 if contradiction else 0
    set_fault(state, IMPLAUSIBLE_BRAKE, state.pedal_tasks * TASK_S > SWITCH_TIME_S)


@njit(cache=True)
def _watch_inertial(state: Any, values: Any) -> None:
    """Range always, agreement with the wheels while nobody brakes."""
    measured = values[_ACCELERATION]
    wrong = not abs(measured) < LARGEST_CAR_ACCELERATION
    if not state.braking and state.reference > 3.0:
        wrong = wrong or abs(measured - state.learned_acceleration) > ACCELERATION_CONTRADICTION
    state.inertial_tasks = min(state.inertial_tasks + 1, 120) if wrong else max(state.inertial_tasks - 1, 0)
    set_fault(state, IMPLAUSIBLE_INERTIAL, state.inertial_tasks * TASK_S > 0.3)


@njit(cache=True)
def _active(state: Any, code: int) -> bool:
    return bool(state.fault_present[code] or state.fault_stored[code])


@njit(cache=True)
def _wheel_is_sound(state: Any, wheel: int, with_edges: bool) -> bool:
    source = EDGES_FL + wheel if with_edges else (SPEED_FRONT if wheel < 2 else SPEED_REAR)
    if _active(state, TIMEOUT + source) or _active(state, PROTECTION + source):
        return False
    return not (_active(state, MISSING_WHEEL + wheel) or _active(state, IMPLAUSIBLE_WHEEL + wheel))


@njit(cache=True)
def _message_is_sound(state: Any, health: Any, source: int) -> bool:
    if not health[source, PRESENT]:
        return True
    return bool(state.seen[source] and not _active(state, TIMEOUT + source) and not _active(state, PROTECTION + source))


@njit(cache=True)
def _decide(calibration: Any, state: Any, health: Any, with_edges: bool) -> None:
    """What may still act."""
    sound = True
    for wheel in range(4):
        state.wheel_valid[wheel] = 1 if _wheel_is_sound(state, wheel, with_edges) else 0
        sound = sound and state.wheel_valid[wheel] == 1
    for source in range(_SOURCES):
        needed = source != INERTIAL or calibration.monitoring_inertial_required > 0.5
        if needed and not _message_is_sound(state, health, source):
            sound = False
    brake_sound = _message_is_sound(state, health, BRAKE) and not _active(state, IMPLAUSIBLE_BRAKE)
    inertial_sound = _message_is_sound(state, health, INERTIAL) and not _active(state, IMPLAUSIBLE_INERTIAL)
    if calibration.monitoring_inertial_required > 0.5 and not inertial_sound:
        sound = False
    front = state.wheel_valid[0] or state.wheel_valid[1]
    rear = state.wheel_valid[2] or state.wheel_valid[3]
    state.inertial_ok = 1 if inertial_sound and health[INERTIAL, PRESENT] and state.seen[INERTIAL] else 0
    state.abs_available = 1 if sound and brake_sound and state.ignition else 0
    state.ebd_available = 1 if front and rear and brake_sound and state.ignition else 0


@njit(cache=True)
def _switch_lamp(calibration: Any, state: Any) -> None:
    """Bulb check after key-on, then on while the ABS is off."""
    checking = state.age_tasks * TASK_S < calibration.monitoring_bulb_check_time
    state.lamp = 1 if state.ignition and (checking or not state.abs_available) else 0


@njit(cache=True)
def _is_asleep(health: Any) -> bool:
    """A bus on which nothing was heard for long is switched off, not faulty."""
    awake = 0
    for source in range(_SOURCES):
        if health[source, PRESENT] and health[source, AGE_TICKS] < SLEEP_TICKS:
            awake += 1
    return awake == 0


@njit(cache=True)
def _watch_ignition(state: Any, values: Any, health: Any) -> None:
    """Key-on starts the watching anew; so does a bus that wakes up."""
    asleep = _is_asleep(health)
    if asleep:
        forget_messages(state)
    known = health[STATUS, PRESENT] and state.seen[STATUS]
    on = 1 if not asleep and (not known or values[_IGNITION] > 0.5) else 0
    if on and not state.ignition:
        state.age_tasks = 0
        # the car may be rolling already: the reference speed starts from the wheels, not from the speed it had
        state.started = 0
        forget_at_key_on(state)
    state.ignition = on
    state.age_tasks += 1


@njit(cache=True)
def watch_inputs(calibration: Any, state: Any, values: Any, health: Any, with_edges: bool) -> None:
    """Judge the inputs of this task.

    Parameters
    ----------
    values : layout of block "bus"
    health : int64, shape (sources, 4), columns ``AGE_TICKS``, ``REJECTED``, ``PERIOD_TICKS``, ``PRESENT``
    with_edges : False where the bus has no pulse counters
    """
    _watch_ignition(state, values, health)
    if state.ignition:
        for source in range(_SOURCES):
            _watch_message(calibration, state, health, source)
        for wheel in range(4):
            _watch_wheel(calibration, state, values, wheel, _comparable(state, health, wheel, with_edges))
        _watch_brake(state, values, health[BRAKE, PRESENT] == 1 and state.seen[BRAKE] == 1)
        if state.seen[INERTIAL]:
            _watch_inertial(state, values)
        heal_after_healthy_drive(calibration, state)
        store_and_select(state)
    _decide(calibration, state, health, with_edges)
    _switch_lamp(calibration, state)
