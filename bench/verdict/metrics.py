"""The metrics of ``vocabulary.METRICS``, each defined once, as functions of an assessment.

A metric with a phase takes its rows as second argument. One that a run has no value for raises NoValueError with the
reason; a value that is never reached is infinite.
"""

import numpy as np

from bench.recording.arrays import FloatArray
from bench.verdict.assessment import Assessment, NoValueError
from bench.verdict.functions import Rows, longest
from bench.verdict.truth import Truth, truth_of

ONSET_SHARE = 0.1
FRICTION_JUMP = 0.1
JUMP_SPAN_S = 0.1
SETTLING_BAND = 0.1
RELEASE_PHASE = 3.0
SIDE_SLIP_FROM_M_S = 10 / 3.6
PERIOD_S = 1e-3


def brake_start_time(run: Assessment) -> float:
    """Time of the brake start, s."""
    return float(run.time[run.brake_row])


def brake_start_speed(run: Assessment) -> float:
    """Speed at the brake start, m/s."""
    return float(run.signal("speed")[run.brake_row])


def _stop_row(run: Assessment) -> int:
    row = run.stop_row()
    if row is None:
        raise NoValueError("the car does not come to a stop")
    return row


def stopping_distance(run: Assessment) -> float:
    """Distance from the brake start to standstill, m."""
    travelled = run.travelled()
    return float(travelled[_stop_row(run)] - travelled[run.brake_row])


def stopping_time(run: Assessment) -> float:
    """Time from the brake start to standstill, s."""
    return float(run.time[_stop_row(run)] - run.time[run.brake_row])


def stopping_distance_corrected(run: Assessment, target_speed: float) -> float:
    """Stopping distance corrected to a target speed, m."""
    return stopping_distance(run) * (target_speed / brake_start_speed(run)) ** 2


def braking_distance(run: Assessment, target_speed: float) -> float:
    """Distance from the instant at which the deceleration passes a tenth of its mean to standstill, m."""
    time, start, stop = run.time, run.brake_row, _stop_row(run)
    threshold = ONSET_SHARE * mean_deceleration(run, run.window("braking"))
    deceleration = run.deceleration()[start:stop]
    above = deceleration >= threshold
    if not above.any():
        raise NoValueError("the deceleration never passes a tenth of its mean")
    row = start + int(np.argmax(above))
    onset = float(time[row])
    if row > start:
        onset = _crossing(time[row - 1 : row + 1], run.deceleration()[row - 1 : row + 1], threshold)
    distance = float(run.travelled()[stop] - np.interp(onset, time, run.travelled()))
    if target_speed > 0:
        distance *= (target_speed / float(np.interp(onset, time, run.signal("speed")))) ** 2
    return distance


def _crossing(time: FloatArray, value: FloatArray, level: float) -> float:
    """Time at which a straight line between two samples passes a level."""
    rise = value[1] - value[0]
    return float(time[1] if rise == 0 else time[0] + (level - value[0]) / rise * (time[1] - time[0]))


def mean_deceleration(run: Assessment, rows: slice) -> float:
    """Loss of speed over time, m/s²."""
    if rows.stop - rows.start < 2:
        raise NoValueError("the phase has less than two rows")
    speed = run.signal("speed")
    first, last = rows.start, rows.stop - 1
    return float((speed[first] - speed[last]) / (run.time[last] - run.time[first]))


def mfdd(run: Assessment) -> float:
    """Mean fully developed deceleration, (v_b² − v_e²)/(2 (s_e − s_b)), m/s²."""
    start, speed = run.brake_row, run.signal("speed")
    initial = float(speed[start])
    fast, slow = 0.8 * initial, 0.1 * initial
    distance = _last_downward_distance(run, slow) - _last_downward_distance(run, fast)
    return (fast**2 - slow**2) / (2 * distance)


def _last_downward_distance(run: Assessment, level: float) -> float:
    """Distance at the last downward crossing of a speed, interpolated linearly."""
    start = run.brake_row
    end = (run.stop_row() or len(run.time) - 1) + 1
    speed, travelled = run.signal("speed")[start:end], run.travelled()[start:end]
    downward = np.flatnonzero((speed[:-1] > level) & (speed[1:] <= level))
    if len(downward) == 0:
        raise NoValueError(f"the speed does not fall through {level * 3.6:.1f} km/h")
    row = int(downward[-1])
    return _crossing(travelled[row : row + 2], speed[row : row + 2], level)


def max_deceleration(run: Assessment, rows: slice) -> float:
    """Largest loss of speed over 0.1 s, m/s²."""
    time, speed = run.time[rows], run.signal("speed")[rows]
    later = np.searchsorted(time, time + JUMP_SPAN_S - 1e-9)
    inside = later < len(time)
    if not inside.any():
        raise NoValueError("the phase is shorter than 0.1 s")
    return float(np.max((speed[inside] - speed[later[inside]]) / (time[later[inside]] - time[inside])))


def _locked(run: Assessment, rows: slice, locked_below: float) -> np.ndarray:
    """Wheels slower than a share of the car's speed, shape (rows, 4)."""
    return run.slip[rows] <= -(1.0 - locked_below)


def wheel_lock(run: Assessment, rows: slice, above_speed: float, locked_below: float) -> FloatArray:
    """Longest time each wheel is locked above a speed, shape (4,), s."""
    fast = run.signal("speed")[rows, None] > above_speed
    return longest(Rows.of(run.time, rows), _locked(run, rows, locked_below) & fast)[0]


def lock_share(run: Assessment, rows: slice, above_speed: float, locked_below: float) -> FloatArray:
    """Share of the time above a speed during which each wheel is locked, shape (4,)."""
    return _share_while_fast(run, rows, _locked(run, rows, locked_below), above_speed)


def _share_while_fast(run: Assessment, rows: slice, condition: np.ndarray, above_speed: float) -> FloatArray:
    weight = Rows.of(run.time, rows).weight * (run.signal("speed")[rows] > above_speed)
    if weight.sum() == 0:
        raise NoValueError(f"the car is never faster than {above_speed * 3.6:.1f} km/h in this phase")
    share: FloatArray = weight @ condition.astype(np.float64) / weight.sum()
    return share


def lock_speed_ratio(run: Assessment, locked_below: float) -> float:
    """Speed at which both axles have a locked wheel, over the speed at the brake start; 0 if that never happens."""
    rows = run.window("brake")
    locked = _locked(run, rows, locked_below)
    front, rear = locked[:, :2].any(axis=1), locked[:, 2:].any(axis=1)
    if not (front.any() and rear.any()):
        return 0.0
    row = rows.start + max(int(np.argmax(front)), int(np.argmax(rear)))
    return float(run.signal("speed")[row]) / brake_start_speed(run)


def slip_mean_wheel(run: Assessment, rows: slice) -> FloatArray:
    """Mean magnitude of slip of each wheel, shape (4,)."""
    mean: FloatArray = np.abs(run.slip[rows]).mean(axis=0)
    return mean


def slip_mean(run: Assessment, rows: slice) -> float:
    """Mean magnitude of slip over wheels and time."""
    return float(slip_mean_wheel(run, rows).mean())


def slip_high_share_wheel(run: Assessment, rows: slice, above_slip: float, above_speed: float) -> FloatArray:
    """Share of time of high slip of each wheel while the car is fast enough, shape (4,)."""
    return _share_while_fast(run, rows, np.abs(run.slip[rows]) > above_slip, above_speed)


def slip_high_share(run: Assessment, rows: slice, above_slip: float, above_speed: float) -> float:
    """The same over all wheels."""
    return float(slip_high_share_wheel(run, rows, above_slip, above_speed).mean())


def slip_band(run: Assessment, rows: slice, low: float, high: float) -> float:
    """Share of time, over all wheels, of slip between two limits."""
    slip = np.abs(run.slip[rows])
    weight = Rows.of(run.time, rows).weight
    inside = ((slip >= low) & (slip <= high)).mean(axis=1)
    return float(weight @ inside / weight.sum()) if weight.sum() > 0 else float(inside.mean())


def yaw(run: Assessment, rows: slice) -> float:
    """Largest change of the yaw angle since the start of the phase, rad."""
    if "yaw_angle" in run.data:
        angle = run.data.array("yaw_angle")[rows]
        return float(np.max(np.abs(angle - angle[0])))
    rate, time = run.signal("true_yaw_rate", "yaw_rate")[rows], run.time[rows]
    steps = np.diff(time) * 0.5 * (rate[1:] + rate[:-1])
    return float(np.max(np.abs(np.concatenate(([0.0], np.cumsum(steps))))))


def max_abs_yaw_rate(run: Assessment, rows: slice) -> float:
    """Largest magnitude of the yaw rate, rad/s."""
    return float(np.max(np.abs(run.signal("true_yaw_rate", "yaw_rate")[rows])))


def max_abs_side_slip_angle(run: Assessment, rows: slice) -> float:
    """Largest magnitude of the side-slip angle above 10 km/h, rad."""
    fast = run.signal("speed")[rows] > SIDE_SLIP_FROM_M_S
    if not fast.any():
        raise NoValueError("the car is never faster than 10 km/h in this phase")
    return float(np.max(np.abs(run.signal("side_slip_angle")[rows][fast])))


def lateral_offset(run: Assessment, rows: slice) -> float:
    """Largest distance from the straight line along which the car stood at the start of the phase, m."""
    x = run.signal("position_x")[rows]
    y = run.signal("position_y")[rows]
    heading = float(run.signal("yaw_angle")[rows.start])
    offset = (y - y[0]) * np.cos(heading) - (x - x[0]) * np.sin(heading)
    return float(np.max(np.abs(offset)))


def steering_wheel_peak(run: Assessment, rows: slice) -> float:
    """Largest magnitude of the steering-wheel angle, rad."""
    return float(np.max(np.abs(run.signal("driver_steering_wheel_angle", "steering_wheel_angle")[rows])))


def steering_wheel_peak_2s(run: Assessment) -> float:
    """The same in the first 2 s after the brake start, rad."""
    start = run.brake_row
    return steering_wheel_peak(run, slice(start, int(np.searchsorted(run.time, run.time[start] + 2.0, "right"))))


def abs_cycles(run: Assessment, rows: slice) -> FloatArray:
    """Release phases that begin at each wheel, shape (4,)."""
    if "ecu_phase_fl" in run.data:
        release = run.data.wheels("ecu_phase")[rows] == RELEASE_PHASE
    else:
        release = run.wheel_signal("valve_outlet")[rows] > 0.5
    cycles: FloatArray = np.sum(release[1:] & ~release[:-1], axis=0, dtype=np.float64)
    return cycles


def _jump_row(run: Assessment, truth: FloatArray, rows: slice) -> int:
    """Row before the largest relative jump of a truth within 0.1 s; NoValueError if it stays within 10 %."""
    values = truth[rows]
    reach = max(1, round(JUMP_SPAN_S / run.step_time_s))
    if len(values) <= reach:
        raise NoValueError("the phase is shorter than 0.1 s")
    change = np.abs(values[reach:] - values[:-reach])
    relative = change / np.maximum(np.maximum(np.abs(values[reach:]), np.abs(values[:-reach])), 1e-9)
    if relative.max() < FRICTION_JUMP:
        raise NoValueError("the true value does not jump")
    # a jump inside the span shows in every difference across it; its own row is the steepest single step there
    begin = int(np.argmax(relative >= 0.999 * relative.max()))
    single = np.abs(np.diff(values[begin : begin + reach + 1]))
    return rows.start + begin + int(np.argmax(single))


def friction_jump_time(run: Assessment) -> float:
    """Time of the largest jump of the friction limit under the front axle, s."""
    limit = run.wheel_signal("friction_limit")[:, :2].mean(axis=1)
    return float(run.time[_jump_row(run, limit, run.window("brake")) + 1])


def truth(run: Assessment, estimate: str) -> FloatArray:
    """True value of an estimate in every row, shape (n,)."""
    compared = truth_of(estimate)
    if compared is None:
        raise NoValueError(f"the simulated car has no true value of {estimate}")
    value = compared.sign * _combined(run, compared)
    if not compared.over:
        return value
    divisor = np.sum([run.signal(name) for name in compared.over], axis=0)
    # an axle without load carries no force either
    return value / np.where(divisor == 0.0, 1.0, divisor)


def _combined(run: Assessment, compared: Truth) -> FloatArray:
    signals = np.array([run.signal(name) for name in compared.signals])
    if compared.total:
        return signals.sum(axis=0)
    if not compared.weights:
        return signals[0] if len(signals) == 1 else signals.mean(axis=0)
    weights = np.array([run.signal(name) for name in compared.weights])
    # at rest on lifted wheels the weights may all be zero; the plain mean stands in
    total = weights.sum(axis=0)
    weights[:, total == 0] = 1.0
    return np.average(signals, axis=0, weights=weights)


def estimator_error(run: Assessment, estimate: str, rows: slice) -> float:
    """Root mean squared error of an estimate."""
    difference = run.signal(estimate)[rows] - truth(run, estimate)[rows]
    return float(np.sqrt(np.mean(difference**2)))


def settling_time(run: Assessment, estimate: str, rows: slice) -> float:
    """Time from the largest jump of the truth until the estimate stays within ±10 % of it; infinite if it does not."""
    true_value = truth(run, estimate)
    jump = _jump_row(run, true_value, rows)
    after = slice(jump + 1, rows.stop)
    outside = ~(np.abs(run.signal(estimate)[after] - true_value[after]) <= SETTLING_BAND * np.abs(true_value[after]))
    if not outside.any():
        return 0.0
    last_outside = len(outside) - 1 - int(np.argmax(outside[::-1]))
    if last_outside == len(outside) - 1:
        return float("inf")
    return float(run.time[after][last_outside + 1] - run.time[after][0])


def _timing(run: Assessment, name: str, signal: str | None = None) -> float:
    value = run.data.timing.get(name)
    if value is not None:
        return float(value)
    if signal is not None and signal in run.data and len(run.data):
        return float(run.data.array(signal)[-1])
    if run.data.timing.get("mode") == "lockstep":
        return 0.0
    raise NoValueError(f"the recording has no timing block with {name!r}")


def real_time_overruns(run: Assessment) -> float:
    """Ticks that ended after the next deadline."""
    return _timing(run, "overruns", "overruns")


def late_ticks(run: Assessment) -> float:
    """Ticks that began more than a period late."""
    try:
        return _timing(run, "late_ticks")
    except NoValueError:
        return float(np.count_nonzero(run.signal("lateness") > PERIOD_S))


def skipped_ticks(run: Assessment) -> float:
    """Ticks that were left out after a stall."""
    return _timing(run, "skipped_ticks")
