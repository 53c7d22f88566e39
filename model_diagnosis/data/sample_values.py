"""Checks of one channel's values by themselves: wraps, holds, stuck and clipped stretches.

A check names a fault only where chance cannot explain it; what it finds is repaired (unwrapped) or masked.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.data.sample_timing import NAMED_LOSS, SampleCheck
from model_diagnosis.data.samples import BoolArray, FloatArray, Samples
from model_diagnosis.result import DataFault
from signals.measured.measured_log import is_stepped

CHANCE = 1e-9
"""Probability below which a stretch of equal samples is no coincidence."""
_MIN_SAMPLES = 50
_MOTION = ("wheel_speed_", "speed", "lateral_speed", "longitudinal_acceleration", "lateral_acceleration", "yaw_rate")
_RATES = ("roll_rate", "pitch_rate", "vertical_acceleration", "side_slip_angle")
_STUCK_S = 0.2
_CONTEXT_S = 1.0
_NEVER_WRAPS = ("brake_pressure_", "master_pressure", "drive_torque_", "engine_torque", "pedal_force")
_APPROACHES, _SLOPE_STD = (11, 33, 100), 3.0
"""Samples on either side of a jump in which a counter goes on its way: as few as show it in its noise."""
_PRESSURES = ("brake_pressure_", "master_pressure")
_REST_S = 1.0
_FINE_OF_SPAN = 2e-3
_END_OF_SPAN = 0.05
_MOVING_HALF = 5
_NOISE_OF_SPAN = 2e-4
"""Noise over a channel's span below which it is the rounding of a noise-free signal, which may well stand still."""
_FEWEST_RUNS, _MANY_RUNS, _HELD_ALIKE = 5, 10, 0.15
"""Stretches of equal values that may be a hold, that are one by their lengths alone, and the share by which those may
differ. Of the steps between five, chance makes most of them multiples of the smallest in 6 % of held signals."""
_QUANTA = 0.1
"""Share of the smallest step by which multiples of it may be off; of steps of any size a fifth are so near to one."""
_FEWEST_TEETH = 40
"""Fewer than cars' tone rings have (43 to 100 are usual); a wheel that turns by less in a sample repeats itself."""


def is_motion(name: str) -> bool:
    """True for what a moving car's sensors read, which never stays exactly equal for long."""
    return name.startswith(_MOTION) or name in _RATES


IndexArray = NDArray[np.int64]


@dataclass(frozen=True)
class Runs:
    """Stretches of equal neighbouring values among the samples that carry a number."""

    start: FloatArray
    length: FloatArray
    value: FloatArray


def _runs(values: FloatArray) -> Runs:
    change = np.flatnonzero(np.diff(values) != 0.0) + 1
    start = np.concatenate(([0], change))
    length = np.diff(np.concatenate((start, [len(values)])))
    return Runs(start.astype(np.float64), length.astype(np.float64), values[start])


def resolution(values: FloatArray) -> float:
    """Smallest step between two different neighbouring values, 0 where there is none."""
    steps = np.abs(np.diff(values))
    steps = steps[steps > 0.0]
    return float(np.percentile(steps, 0.5)) if len(steps) else 0.0


def noise_of(values: FloatArray) -> float:
    """Standard deviation of the noise, of third differences, which leave no smooth motion (20 times its variance)."""
    if len(values) < 10:
        return 0.0
    return float(1.4826 * np.median(np.abs(np.diff(values, 3))) / np.sqrt(20.0))


_TURNS, _OF_A_TURN = (2.0 * np.pi, 360.0), 1e-3
"""A full turn in rad and degrees, and the share of it by which the measured wrap of an angle that turns may be off."""

_RANGE_STD = 5.0
"""Standard deviations of the noise by which a measured wrap may be off: two samples' noise and the trend's, thrice."""


def check_wrap(channel: Samples) -> tuple[Samples, list[DataFault]]:
    """Unwrap a counter: jumps that all have one size, far above any other step, with the trend going on across them."""
    if is_stepped(channel.name) or channel.name.startswith(_NEVER_WRAPS):
        return channel, []
    rows = np.flatnonzero(channel.valid)
    values = channel.values[rows]
    if len(values) < _MIN_SAMPLES:
        return channel, []
    steps = np.diff(values)
    span = float(np.ptp(values))
    close = np.diff(channel.time[rows]) < 3.0 * max(channel.period_s(), 1e-9)
    jumps = np.flatnonzero((np.abs(steps) > 0.6 * span) & close)
    usual = float(np.percentile(np.abs(np.delete(steps, jumps)), 99.0)) if len(jumps) < len(steps) else 0.0
    if span == 0.0 or not len(jumps) or len(jumps) > len(steps) // 10 or span < 20.0 * usual:
        return channel, []
    low, high = float(values.min()), float(values.max())
    upper, lower = np.maximum(values[jumps], values[jumps + 1]), np.minimum(values[jumps], values[jumps + 1])
    at_the_ends = (high - upper < _END_OF_SPAN * span) & (lower - low < _END_OF_SPAN * span)
    if np.mean(at_the_ends) < 0.5:
        return channel, []
    jumps = jumps[at_the_ends]
    trend = np.array([_trend(steps, int(k), set(jumps.tolist())) for k in jumps])
    sizes = np.abs(steps[jumps] - trend)
    wrap = float(np.median(sizes))
    passes = max(1.0, abs(float(np.sum(np.sign(steps[jumps])))))  # to and fro in noise, steps grow with the noise
    wrap = _range_of_a_counter(wrap, _RANGE_STD * noise_of(values) / np.sqrt(passes))
    alike = np.abs(sizes - wrap) <= max(4.0 * usual, 0.02 * wrap)
    if np.mean(alike) < 0.5:
        return channel, []
    jumps = jumps[alike]
    turns = np.zeros(len(values))
    turns[1:][jumps] = -np.sign(steps[jumps])
    unwrapped = values + wrap * np.cumsum(turns)
    if not _goes_on(unwrapped, jumps):
        return channel, []  # switched on and off
    repaired = channel.values.copy()
    repaired[rows] = unwrapped
    message = f"{channel.name} wraps {len(jumps)} times by {wrap:.6g} {channel.unit}; unwrapped"
    return channel.with_values(repaired), [
        DataFault(
            kind="counter_wrap", channel=channel.name, value=wrap, unit=channel.unit, repaired=True, message=message
        )
    ]


def _range_of_a_counter(measured: float, uncertainty: float) -> float:
    """The number nearest to a measured wrap that a counter is likely to end at, the measured one where there is none.

    A full turn, a power of two times a resolution in powers of ten, else the number with the fewest decimal digits.
    """
    for turn in _TURNS:
        if abs(measured - turn) <= max(uncertainty, _OF_A_TURN * turn):
            return turn
    counters = np.ldexp(1.0, np.arange(1, 33))[:, None] * 10.0 ** np.arange(-9, 1)
    nearest = float(counters.flat[np.argmin(np.abs(counters - measured))])
    if abs(nearest - measured) <= uncertainty:
        return nearest
    first = int(np.floor(np.log10(measured)))
    rounded = (round(measured, digits) for digits in range(-first, 9 - first))
    return next((one for one in rounded if abs(one - measured) <= uncertainty), measured)


def _goes_on(unwrapped: FloatArray, jumps: IndexArray) -> bool:
    """True where the unwrapped series moves the same way before and after most jumps, by more than its noise."""
    for window in _APPROACHES:
        whole = jumps[(jumps >= window - 1) & (jumps + window < len(unwrapped))]
        before = np.array([_slope(unwrapped[k - window + 1 : k + 1]) for k in whole])
        after = np.array([_slope(unwrapped[k + 1 : k + 1 + window]) for k in whole])
        if len(whole) and np.mean(before * after > 0.0) > 0.5:
            return True
    return False


def _slope(values: FloatArray) -> float:
    """Slope of a straight line per sample, zero where it is less than three of its standard errors."""
    at = np.arange(len(values)) - 0.5 * (len(values) - 1)
    slope = float(at @ values / (at @ at))
    left = values - values.mean() - slope * at
    error = float(np.sqrt(left @ left / ((len(values) - 2) * (at @ at))))
    return slope if abs(slope) > _SLOPE_STD * error else 0.0


def _trend(steps: FloatArray, jump: int, jumps: set[int]) -> float:
    near = [k for k in range(jump - 3, jump + 4) if 0 <= k < len(steps) and k not in jumps]
    return float(np.median(steps[near])) if near else 0.0


def check_periodic_hold(channel: Samples) -> tuple[Samples, list[DataFault]]:
    """Mask all but the fresh samples of a slower sensor that was written at the log's rate (held GNSS)."""
    rows = np.flatnonzero(channel.valid)
    if len(rows) < _MIN_SAMPLES or is_stepped(channel.name):
        return channel, []
    values = channel.values[rows]
    runs = _runs(values)
    inner = runs.length[1:-1]
    if len(inner) < _FEWEST_RUNS or (len(inner) < _MANY_RUNS and _moves_by_quanta(runs)):
        return channel, []
    # stretches where the signal rests are not of the pattern: they hold whole multiples of it
    held = float(np.median(inner))
    if (
        held < 2.0
        or np.mean(np.abs(inner - held) <= max(1.0, _HELD_ALIKE * held)) < 0.8
        or _is_slow_quantised(runs, values)
    ):
        return channel, []
    fresh = np.zeros(len(values), dtype=bool)
    fresh[runs.start.astype(int)] = True
    stale = np.zeros(len(channel.values), dtype=bool)
    stale[rows[~fresh]] = True
    period = held * channel.period_s()
    kind = "gps_hold" if channel.name in ("speed", "lateral_speed", "side_slip_angle") else "frame_drop_hold"
    message = f"{channel.name} holds each value for {held:.0f} samples ({period:.3g} s); only fresh samples count"
    return channel.masked(stale), [
        DataFault(kind=kind, channel=channel.name, value=held, unit="samples", repaired=True, message=message)
    ]


def _moves_by_quanta(runs: Runs) -> bool:
    """True where most steps are multiples of the smallest: a coarse signal that changes slowly holds its values too."""
    steps = np.abs(np.diff(runs.value))
    multiples = steps / steps.min()
    return bool(np.mean(np.abs(multiples - np.round(multiples)) < _QUANTA) > 0.5)


def _is_slow_quantised(runs: Runs, values: FloatArray) -> bool:
    """True where neighbouring values differ by one step of the resolution: a slow signal, no hold."""
    steps = np.abs(np.diff(runs.value))
    quantum = resolution(values)
    return bool(
        quantum > 0.0 and np.mean(steps < 1.5 * quantum) > 0.5 and len(np.unique(values)) < 0.5 * len(runs.value)
    )


def check_random_hold(channel: Samples) -> tuple[Samples, list[DataFault]]:
    """Mask repeated samples of a moving signal: frames that were lost and filled with the value before.

    While the signal moves by more than its resolution per sample, a step of zero is no likelier than the steps beside
    it; the surplus of zeros is the share of held samples. A wheel whose sensor saw no tooth since the last sample holds
    its value and has lost nothing.
    """
    rows = np.flatnonzero(channel.valid)
    if len(rows) < _MIN_SAMPLES or is_stepped(channel.name):
        return channel, []
    values = channel.values[rows]
    steps = np.diff(values)
    quantum = resolution(values)
    if quantum == 0.0:
        return channel, []
    moving = _moving(values, steps, quantum)
    if channel.name.startswith("wheel_speed_"):
        moving &= np.abs(values[:-1]) * channel.period_s() > 2.0 * np.pi / _FEWEST_TEETH
    if np.sum(moving) < 2 * _MIN_SAMPLES:
        return channel, []
    share = float(np.mean(steps[moving] == 0.0))
    by_chance = _share_by_chance(steps[moving], quantum)
    surplus = share - by_chance
    spread = np.sqrt(max(share, 1.0 / len(steps)) / np.sum(moving))
    if surplus < NAMED_LOSS or surplus < 5.0 * spread:
        return channel, []
    repeated = np.concatenate(([False], (steps == 0.0) & moving))
    stale = np.zeros(len(channel.values), dtype=bool)
    stale[rows[repeated]] = True
    message = f"{channel.name}: {100.0 * surplus:.1f} % of the samples only repeat the one before; masked"
    return channel.masked(stale), [
        DataFault(
            kind="frame_drop_hold",
            channel=channel.name,
            value=surplus,
            unit="1",
            evidence=float((surplus / spread) ** 2 / 2.0),
            repaired=True,
            message=message,
        )
    ]


def _moving(values: FloatArray, steps: FloatArray, quantum: float) -> BoolArray:
    """(n − 1,) True where a step of zero is no likelier than its neighbours: a steep trend, or noise of several steps
    of the resolution; never at the ends of the range or at zero, where signals rest."""
    window = np.lib.stride_tricks.sliding_window_view
    half = _MOVING_HALF
    padded = np.pad(values, (half, half + 1), mode="edge")
    trend = np.abs(padded[2 * half + 1 :] - padded[: -2 * half - 1])[: len(steps)] / (2 * half + 1)
    span = float(np.ptp(values))
    fine = quantum < 1e-6 * span
    steep = trend > (1e-4 * span if fine else 1.5 * quantum)
    sizes = np.where(steps == 0.0, np.nan, np.abs(steps))
    around = window(np.pad(sizes, half, constant_values=np.nan), 2 * half + 1)
    enough = np.sum(np.isfinite(around), axis=1) >= 3
    usual = np.zeros(len(steps))
    usual[enough] = np.nanmedian(around[enough], axis=1)
    rests = np.isin(values[:-1], (0.0, values.min(), values.max()))
    noisy = noise_of(values) > _NOISE_OF_SPAN * span
    active: BoolArray = (steep | ((usual > 2.5 * quantum) & noisy)) & ~rests
    return active


def _share_by_chance(steps: FloatArray, quantum: float) -> float:
    """Share of the likeliest step near zero other than zero itself, in multiples of the resolution."""
    multiples = np.round(steps / quantum)
    return max(float(np.mean(multiples == k)) for k in (-3, -2, -1, 1, 2, 3))


def check_stuck(channel: Samples) -> tuple[Samples, list[DataFault]]:
    """Mask stretches where a noisy signal stays exactly equal: stuck, or clipped at the end of its range."""
    rows = np.flatnonzero(channel.valid)
    pressure = channel.name.startswith(("brake_pressure_", "master_pressure"))
    if len(rows) < _MIN_SAMPLES or not (is_motion(channel.name) or pressure):
        return channel, []
    values = channel.values[rows]
    runs = _runs(values)
    context = max(10, round(_CONTEXT_S / max(channel.period_s(), 1e-3)))
    shortest = max(8, round(_STUCK_S / max(channel.period_s(), 1e-3)))
    long_runs = [int(k) for k in np.flatnonzero(runs.length >= shortest)]
    stuck = [k for k in long_runs if _is_improbable(values, runs, k, context)]
    if not stuck:
        return channel, []
    wrong = np.zeros(len(channel.values), dtype=bool)
    for k in stuck:
        begin = int(runs.start[k])
        wrong[rows[begin + 1 : begin + int(runs.length[k])]] = True
    clipped = [k for k in stuck if runs.value[k] in (values.max(), values.min())]
    share = float(np.sum(wrong)) / len(rows)
    if len(clipped) == len(stuck) and (len(clipped) > 1 or _enters_steeply(values, runs, clipped[0])):
        limit = float(runs.value[clipped[0]])
        message = f"{channel.name} is clipped at {limit:.6g} {channel.unit} in {100.0 * share:.1f} % of the samples"
        fault = DataFault(
            kind="saturated_channel", channel=channel.name, value=limit, unit=channel.unit, message=message
        )
    else:
        seconds = float(np.sum(wrong)) * channel.period_s()
        message = f"{channel.name} is stuck for {seconds:.3g} s in all; masked"
        fault = DataFault(
            kind="stuck_channel", channel=channel.name, value=seconds, unit="s", repaired=True, message=message
        )
    return channel.masked(wrong), [fault]


def _is_improbable(values: FloatArray, runs: Runs, k: int, context: int) -> bool:
    """True where equal neighbours are so rare before and after the stretch that chance cannot have made it."""
    begin, length = int(runs.start[k]), int(runs.length[k])
    if values[begin] == 0.0:
        return False  # at rest, pedal released
    before = np.diff(values[max(0, begin - context) : begin])
    after = np.diff(values[begin + length : begin + length + context])
    sides = [side for side in (before, after) if len(side) >= 10]
    if not sides:
        return False
    least_noise = _NOISE_OF_SPAN * float(np.ptp(values))
    for side in sides:
        noisy = noise_of(np.cumsum(side)) > least_noise
        equal = max(float(np.mean(side == 0.0)), 1.0 / len(side))
        if not noisy or (length - 1) * np.log(equal) > np.log(CHANCE):
            return False
    return True


def _enters_steeply(values: FloatArray, runs: Runs, k: int) -> bool:
    begin = int(runs.start[k])
    entry = values[max(0, begin - 5) : begin + 1]
    sign = 1.0 if runs.value[k] == values.max() else -1.0
    return len(entry) > 3 and sign * (entry[-1] - entry[0]) > 3.0 * float(np.std(np.diff(values)))


VALUE_CHECKS: tuple[SampleCheck, ...] = (check_wrap, check_periodic_hold, check_stuck, check_random_hold)


def fresh_values(channel: Samples) -> tuple[FloatArray, FloatArray]:
    """(time, values) of the samples that are measurements."""
    fresh: BoolArray = channel.valid & np.isfinite(channel.values)
    return channel.time[fresh], channel.values[fresh]


def check_resting_pressures(channels: Mapping[str, Samples]) -> list[DataFault]:
    """Name pressures that stay exactly at one value other than zero for a second beside sensors that have noise.

    A finely resolved sensor never does that; a commanded value does.
    """
    named = [n for n in channels if n.startswith(_PRESSURES) and _rests_exactly(channels[n])]
    if not named or not any(_is_noisy(channel) for name, channel in channels.items() if is_motion(name)):
        return []
    return [
        DataFault(
            kind="command_not_measurement",
            channel=name,
            unit="s",
            message=f"{name} has no sensor noise and stays exactly at one value for a second and more: a command. The "
            "lag of what carries it out stays unknown",
        )
        for name in named
    ]


def _rests_exactly(channel: Samples) -> bool:
    values = channel.values[channel.valid]
    if len(values) < _MIN_SAMPLES or resolution(values) >= _FINE_OF_SPAN * float(np.ptp(values)):
        return False
    runs = _runs(values)
    rests = (runs.length * channel.period_s() >= _REST_S) & (runs.value != 0.0)
    return bool(rests.any())


def _is_noisy(channel: Samples) -> bool:
    values = channel.values[channel.valid]
    return noise_of(values) > 1e-6 * max(float(np.ptp(values)), 1e-9)
