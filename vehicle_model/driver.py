"""The driver's feet, compiled: accelerator, clutch, gear lever and brake pedal; the hands are in `path_follower`.

The driver sees the car's speed and the engine's, moves pedals at human rates, shifts with the clutch, and opens the
clutch before the engine would be stalled.
"""

import math
from typing import Any

import numba
from numba import njit

from signals.record_memory import addresses_at, numbers_at, pointer, record_at
from vehicle_model.driver_record import (
    ACCELERATE,
    BRAKE,
    COAST,
    COMMAND_RECORD,
    HOLD_SPEED,
    MOST_GEARS,
    STATE_RECORD,
)
from vehicle_model.interface import TIME_STEP_S
from vehicle_model.path_follower import steer

# order of block "driver"
PEDAL_FORCE, MASTER_PRESSURE, ACCELERATOR, CLUTCH, GEAR, STEERING = range(6)

AT_COMMAND, AT_STATE, AT_VALUES, AT_TABLE, TABLE_COLUMNS = range(5)
"""Places in the list of addresses: two records, the signal vector, the steering table; then the table's columns."""

_STANDSTILL_M_S = 0.5
_RELEASE_RATE = 12.5  # of the accelerator, 1/s: the foot leaves it within 80 ms
_CLUTCH_OPENING_RATE = 12.5  # 1/s: open within 80 ms
_BRAKE_RELEASE_RATE = 5000.0  # N/s
# the clutch begins to open at idle speed and is open at this share of it
_STALL_SHARE = 0.75
_LAUNCH_PATIENCE_S = 1.0  # after it the clutch closes although the engine does not rev


@njit(cache=True)
def _toward(value: float, target: float, rise: float, fall: float) -> float:
    """Value moved towards a target by at most ``rise`` up or ``fall`` down."""
    if target > value:
        return min(value + rise, target)
    return max(value - fall, target)


@njit(cache=True)
def gear_for_speed(c: Any, speed: float) -> int:
    """Highest gear in which the engine still turns at twice its idle speed; 1 if there is none."""
    for gear in range(c.gears, 1, -1):
        if c.ratio[gear] * speed / c.radius >= 2.0 * c.idle_speed:
            return gear
    return 1


@njit(cache=True)
def _wanted_gear(c: Any, s: Any, speed: float, engine_speed: float) -> int:
    """Gear that the driver wants now."""
    if c.feet == HOLD_SPEED:
        return c.gear if c.gear >= 0 else gear_for_speed(c, c.speed_target)
    if c.feet != ACCELERATE:
        return s.gear
    if c.gear >= 0:
        return c.gear
    gear = max(s.gear, 1)
    if gear < c.highest_gear and s.gear > 0:
        by_speed = c.shift_speed[gear]
        if by_speed > 0.0 and speed >= by_speed:
            return gear + 1
        # a clutch that slips lets the engine rev: that is no reason to shift
        if by_speed <= 0.0 and s.clutch >= 1.0 and engine_speed >= c.shift_engine_speed:
            return gear + 1
    return gear


@njit(cache=True)
def _begin(c: Any, s: Any, speed: float) -> None:
    """State of the driver at the first tick: standing with the clutch open, or driving in a gear that suits."""
    s.started = 1
    wanted = c.initial_gear
    if wanted < 0 and c.feet in (ACCELERATE, HOLD_SPEED):
        wanted = c.gear
    if speed < _STANDSTILL_M_S:
        s.gear, s.clutch = max(c.initial_gear, 0), 0.0
    else:
        s.gear, s.clutch = wanted if wanted >= 0 else gear_for_speed(c, speed), 1.0
    s.next_gear = s.gear
    if c.feet == HOLD_SPEED:
        s.accelerator = c.feedforward


@njit(cache=True)
def _revs_for_launch(c: Any, s: Any, speed: float, engine_speed: float, time: float) -> bool:
    """True while the driver waits with the open clutch for the engine to rev up."""
    standing = c.feet == ACCELERATE and speed < _STANDSTILL_M_S and s.clutch == 0.0
    return standing and engine_speed < c.launch_engine_speed and time - s.feet_began < _LAUNCH_PATIENCE_S


@njit(cache=True)
def _shift(c: Any, s: Any, speed: float, engine_speed: float, time: float) -> None:
    """Gear lever and clutch."""
    if s.shift_left <= 0.0:
        wanted = _wanted_gear(c, s, speed, engine_speed)
        if wanted != s.gear:
            s.next_gear = wanted
            # nothing to disengage from neutral or with the clutch open
            engaged = s.gear > 0 and s.clutch > 0.0
            s.shift_left = max(c.shift_duration, TIME_STEP_S) if engaged else TIME_STEP_S
    if s.shift_left > 0.0:
        s.clutch = _toward(s.clutch, 0.0, 0.0, _CLUTCH_OPENING_RATE * TIME_STEP_S)
        s.shift_left -= TIME_STEP_S
        if s.shift_left <= 0.5 * c.shift_duration or s.clutch == 0.0:
            s.gear = s.next_gear
        return
    closed = s.gear > 0 and c.feet != COAST and not (c.feet == BRAKE and c.brake_declutch == 1)
    target = 1.0 if closed and not _revs_for_launch(c, s, speed, engine_speed, time) else 0.0
    if target > 0.0 and (c.feet != ACCELERATE or speed > _STANDSTILL_M_S):
        above = (engine_speed - _STALL_SHARE * c.idle_speed) / ((1.0 - _STALL_SHARE) * c.idle_speed)
        target = min(max(above, 0.0), 1.0)
    s.clutch = _toward(s.clutch, target, TIME_STEP_S / c.clutch_duration, _CLUTCH_OPENING_RATE * TIME_STEP_S)


@njit(cache=True)
def _accelerator(c: Any, s: Any, speed: float) -> None:
    target = 0.0
    if s.shift_left > 0.0:
        target = 0.0
    elif c.feet == ACCELERATE:
        target = c.accelerator[min(s.gear, MOST_GEARS)]
    elif c.feet == HOLD_SPEED:
        error = c.speed_target - speed
        unlimited = c.feedforward + c.proportional_gain * error + s.integral
        target = min(max(unlimited, 0.0), 1.0)
        # the integral stops where the pedal is at its end
        if target == unlimited or (unlimited - target) * error < 0.0:
            s.integral += c.integral_gain * error * TIME_STEP_S
    s.accelerator = _toward(
        s.accelerator, target, c.accelerator_rate * TIME_STEP_S, max(c.accelerator_rate, _RELEASE_RATE) * TIME_STEP_S
    )


@njit(cache=True)
def _ramp(c: Any, start: float, elapsed: float) -> float:
    """Force or pressure of the brake ramp ``elapsed`` seconds after its begin."""
    change = c.brake_target - start
    way = abs(change)
    if way == 0.0:
        return c.brake_target
    if c.brake_human == 1:
        duration = 0.5 * math.pi * way / c.brake_ramp
        share = 0.5 * (1.0 - math.cos(math.pi * min(elapsed / duration, 1.0)))
    else:
        share = min(c.brake_ramp * elapsed / way, 1.0)
    return start + share * change


@njit(cache=True)
def _boosted(c: Any, pedal_force: float) -> float:
    """Master pressure of a pedal force; above its knee a booster that runs out of vacuum helps less."""
    pressure = c.booster_gain * pedal_force
    if c.booster_slope_loss != 0.0 and pressure > c.booster_knee_pressure:
        pressure -= c.booster_slope_loss * (pressure - c.booster_knee_pressure)
    return pressure


@njit(cache=True)
def _pedal_force(c: Any, pressure: float) -> float:
    """Pedal force that makes a master pressure; that of the full booster where none does."""
    if c.booster_slope_loss != 0.0 and pressure > c.booster_knee_pressure and c.booster_slope_loss < 1.0:
        pressure = c.booster_knee_pressure + (pressure - c.booster_knee_pressure) / (1.0 - c.booster_slope_loss)
    return pressure / c.booster_gain if c.booster_gain > 0.0 else 0.0


@njit(cache=True)
def _brake(c: Any, s: Any, time: float) -> None:
    if c.feet != BRAKE:
        s.pedal_force = _toward(s.pedal_force, 0.0, 0.0, _BRAKE_RELEASE_RATE * TIME_STEP_S)
        s.master_pressure = _boosted(c, s.pedal_force)
        return
    value = _ramp(c, s.brake_start, time - s.feet_began)
    if c.brake_by_pressure == 1:
        s.master_pressure = value
        s.pedal_force = _pedal_force(c, value)
    else:
        s.pedal_force = value
        s.master_pressure = _boosted(c, value)


@njit(cache=True)
def driver_step(memory: int, time: float) -> None:
    """Advance the driver by 1 ms.

    Parameters
    ----------
    memory
        Address of the list of addresses ``AT_…``: records of ``COMMAND_RECORD`` and ``STATE_RECORD``, the signal
        vector, in which block "driver" and ``manoeuvre_phase`` are written, and times and angles of a steering table,
        shape (2, n).
    time : s
    """
    places: Any = addresses_at(memory)
    c, s = record_at(places[AT_COMMAND], COMMAND_RECORD), record_at(places[AT_STATE], STATE_RECORD)
    values = numbers_at(places[AT_VALUES])
    table = numba.carray(pointer(places[AT_TABLE]), (2, places[TABLE_COLUMNS]), numba.float64)
    speed, engine_speed = values[c.speed], values[c.true_engine_speed]
    if s.started == 0:
        _begin(c, s, speed)
    if s.feet_serial != c.feet_serial:
        s.feet_serial = c.feet_serial
        s.feet_began = time
        s.integral = 0.0
        s.brake_start = s.master_pressure if c.brake_by_pressure == 1 else s.pedal_force
    _shift(c, s, speed, engine_speed, time)
    _accelerator(c, s, speed)
    _brake(c, s, time)
    steer(c, s, values, table, time)
    out = c.outputs
    values[c.phase] = c.phase_number
    values[out + PEDAL_FORCE] = s.pedal_force
    values[out + MASTER_PRESSURE] = s.master_pressure
    values[out + ACCELERATOR] = s.accelerator
    values[out + CLUTCH] = s.clutch
    values[out + GEAR] = s.gear
    values[out + STEERING] = s.steering
