"""The vehicle's hydraulic unit replayed with measured master pressure and valve commands, compiled."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hydraulics.pressure import line_pressure, pressure_step
from hydraulics.record import HOLD, INCREASE, LONGEST_DELAY_STEPS, STEP_S
from hydraulics.valves import circuit_of, stiffness
from model_diagnosis.replay.record import Record
from model_diagnosis.replay.state import SUBSTEPS

TICKS = 10
"""Steps of 1 ms within a sample."""
_TICKS_OF_STEP = TICKS // SUBSTEPS

_QUIET_SAMPLES = LONGEST_DELAY_STEPS // TICKS + 2
"""Time without commands after which the unit remembers none."""

_VALVE_S = 2e-3
"""Time constant of a closing inlet valve: solenoid valves move in 2 to 5 ms."""
_KEPT_OPEN = math.exp(-STEP_S / _VALVE_S)

_RELEASED_PA = 5e4
_NOTHING_PA = 0.01
"""What is left of a returning pressure when it counts as back, a millionth of a sensor's noise: it would never be."""


@njit(cache=True, nogil=True, error_model="numpy")
def _set_pressure(s: Record, wheel: int, pressure: float) -> None:
    """Let the running segment of a wheel go on from another pressure."""
    s.pressure[wheel] = pressure
    if s.previous_state[wheel] == HOLD:
        s.target[wheel] = pressure
    s.difference[wheel] = s.target[wheel] - pressure
    s.segment_time[wheel] = 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _move_target(p: Record, s: Record, wheel: int, drawn: float, master: float) -> None:
    """Correct where a building-up segment ends, too, as far as the unit's threshold leaves that open.

    Changes of the supply below the threshold begin no segment, so a wheel rests up to so much off its line. Where
    exactly hangs on the instants of its last segments, which samples do not tell.
    """
    line = line_pressure(p, wheel, master)
    if s.previous_state[wheel] == INCREASE and abs(s.target[wheel] - line) <= p.threshold:
        s.target[wheel] = min(max(s.target[wheel] + drawn, line - p.threshold), line + p.threshold)


@njit(cache=True, nogil=True, error_model="numpy")
def _fill_gap(p: Record, s: Record, wheel: int, before: float, gap: float) -> float:
    """Fluid that only moves the pads up to the disc makes no pressure; returns what is left of the gap [m^3]."""
    gained = s.pressure[wheel] - before
    if gained <= 0.0 or gap <= 0.0:
        return gap
    per_volume = stiffness(p, wheel, before)
    used = min(gained / per_volume, gap)
    _set_pressure(s, wheel, s.pressure[wheel] - used * per_volume)
    return gap - used


@njit(cache=True, nogil=True, error_model="numpy")
def _throttle_return(p: Record, s: Record, wheel: int, before: float, supply: float, kept: float) -> None:
    """Keep the share ``kept`` of what a wheel's pressure has beyond the line that it returns to."""
    line = line_pressure(p, wheel, supply)
    slowest = line + kept * (before - line)
    if slowest > line + _NOTHING_PA and s.pressure[wheel] < slowest:
        _set_pressure(s, wheel, slowest)


@njit(cache=True, nogil=True, error_model="numpy")
def _overlap(p: Record, s: Record, wheel: int, supply: float, overlap: float, left: float) -> float:
    """Keep out of the accumulator what leaves a brake while as much comes in through its closing inlet valve.

    Neither shows in the brake's pressure. ``left`` is what would pass so if the outlet valve opened now [m^3]; returns
    it for the next step.
    """
    before = float(s.pressure[wheel])
    mode = s.previous_state[wheel]
    if mode == INCREASE:
        flow = (line_pressure(p, wheel, supply) - before) / (p.time_constant[INCREASE] * stiffness(p, wheel, before))
        return overlap * max(flow, 0.0)
    if mode == HOLD:
        return left * _KEPT_OPEN
    circuit = circuit_of(p, wheel)
    s.accumulator[circuit] = max(s.accumulator[circuit] - left, 0.0)
    return 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def lag_shares(lag: float, step: float) -> tuple[float, float, float]:
    """What a first-order lag [s] keeps of its output over a step [s], and takes of its input's begin and end.

    Exact for an input on a straight line; without a lag the input's end is the output.
    """
    if lag <= 0.0:
        return 0.0, 0.0, 1.0
    steps = step / lag
    kept = math.exp(-steps)
    mean = (1.0 - kept) / steps
    return kept, mean - kept, 1.0 - mean


@njit(cache=True, nogil=True, error_model="numpy")
def _leave_line(between: NDArray[np.float64], begin: NDArray[np.float64], s: Record) -> None:
    """Take the straight line from ``begin`` to where the pressures are now off those between (SUBSTEPS, 4)."""
    for j in range(SUBSTEPS):
        share = (j + 0.5) / SUBSTEPS
        for i in range(4):
            between[j, i] -= begin[i] + share * (s.pressure[i] - begin[i])


@njit(cache=True, nogil=True, error_model="numpy")
def _on_line(values: NDArray[np.float64], place: float) -> float:
    """Value on the straight line between samples, at a place counted in samples; the ends go on level."""
    inside = min(max(place, 0.0), values.shape[0] - 1.0)
    row = min(int(inside), values.shape[0] - 2)
    return float(values[row] + (inside - row) * (values[row + 1] - values[row]))


@njit(cache=True, nogil=True, error_model="numpy")
def _row(place: float, rows: int) -> int:
    """Sample at a place counted in samples; the first and the last one go on."""
    return min(max(int(np.floor(place)), 0), rows - 1)


@njit(cache=True, nogil=True, error_model="numpy")
def _is_commanded(inlet: NDArray[np.float64], outlet: NDArray[np.float64], pump: NDArray[np.float64], row: int) -> bool:
    """True where a valve or the pump is switched on in a sample."""
    for i in range(4):
        if inlet[row, i] != 0.0 or outlet[row, i] != 0.0:
            return True
    return bool(pump[row] != 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _rests(p: Record, s: Record, master: NDArray[np.float64], first: int, last: int) -> bool:
    """True where a step would leave all as it is: brakes released, and no master pressure in these samples."""
    if p.literal_event > 0.5 or p.rearm_near_target > 0.5:
        return False
    for row in range(first, last + 1):
        if master[row] != 0.0:
            return False
    for i in range(4):
        if s.previous_state[i] != INCREASE or s.pressure[i] != 0.0 or abs(s.supply_start[i]) >= p.threshold:
            return False
        # wherever the segment leads, at the next instant the line without pressure is its limit again
        if s.difference[i] != s.target[i] or (s.difference[i] != 0.0 and s.segment_time[i] != 0.0):
            return False
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def hydraulic_run(
    parameters: NDArray[np.void],
    memory: NDArray[np.void],
    master: NDArray[np.float64],
    inlet: NDArray[np.float64],
    outlet: NDArray[np.float64],
    pump: NDArray[np.float64],
    cornering: NDArray[np.bool_],
    behind_commands: float,
    behind_master: float,
    measured: NDArray[np.float64],
    valid: NDArray[np.float64],
    gap_volume: float,
    return_kept: float,
    overlap: float,
    sensor_lag: float,
    gain: float,
    least: NDArray[np.float64],
    dead_band: float,
    between: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Wheel pressures, and what their sensors report of them behind a lag, before each sample's correction.

    Parameters
    ----------
    parameters : shape (1,), dtype ``hydraulics.record.PARAMETER_RECORD``
    memory : shape (1,), dtype ``hydraulics.state.STATE_RECORD``, zeros. It comes from outside: in compiled code a
        record does not keep its array alive, and one made here is freed while it is written
    master : (n,) Pa
    inlet, outlet, pump : (n, 4), (n, 4), (n,) commands, 1 energised
    cornering : (n,) True where the pads are pushed back
    behind_commands, behind_master : how much later than these the wheel pressures are taken [samples]
    measured, valid : (n, 4) lagged pressures [Pa] on which the observer corrects, and 1 where they hold
    gap_volume : m^3, behind the pads after cornering
    return_kept : share of the pressure beyond the supply that is left 1 ms later; 0 where it returns at once
    overlap : time for which the flow through a closing inlet valve leaves past the accumulator [s]
    sensor_lag : of the sensors that measure the wheels' pressures [s]
    gain : of the observer, per sample
    least : (n, 4) least gains, where the observer begins anew behind a gap of the inputs
    dead_band : difference [Pa] up to which the observer leaves the pressure alone. Noise above the supply flows back at
        once and noise below it is filled up slowly: corrected on, it would lower the mean
    between : (n, SUBSTEPS, 4) pressures [Pa] in the middle of the car's steps before each sample, beside the straight
        line from the correction before to the sample; without rows they are not kept
    out : (2, n, 4) Pa, of the sensors and of the brakes
    """
    p = parameters[0]
    s = memory[0]
    unused, gap, begin, lagged, passing = np.zeros(18), np.zeros(4), np.zeros(4), np.zeros(4), np.zeros(4)
    kept, of_begin, of_end = lag_shares(sensor_lag, STEP_S)
    for i in range(4):
        s.previous_state[i] = -1
        s.pressure[i] = measured[0, i] if valid[0, i] > 0.0 else master[0]
        lagged[i] = s.pressure[i]
    rows = master.shape[0]
    seen, commanded = 0, -_QUIET_SAMPLES  # samples whose commands have been looked at, and the last one with any
    for k in range(rows):
        while seen <= _row(k + 0.5 + behind_commands, rows):
            if _is_commanded(inlet, outlet, pump, seen):
                commanded = seen
            seen += 1
        is_quiet = _row(k - 0.5 + behind_commands, rows) - commanded >= _QUIET_SAMPLES
        first, last = _row(k - 1.0 + behind_master, rows), _row(k + 1.0 + behind_master, rows)  # that supply the steps
        # brakes at rest, as in most of a drive, are not stepped
        if k > 0 and not (is_quiet and _rests(p, s, master, first, last)):
            for i in range(4):
                begin[i] = s.pressure[i]
            for tick in range(TICKS):
                nearest = _row(k - 0.5 + tick / TICKS + behind_commands, rows)
                supply = _on_line(master, k - 1 + (tick + 1) / TICKS + behind_master)
                before_0, before_1, before_2, before_3 = s.pressure[0], s.pressure[1], s.pressure[2], s.pressure[3]
                pressure_step(p, s, inlet[nearest], outlet[nearest], unused, supply, pump[nearest])
                if return_kept > 0.0:
                    energised = outlet[nearest]
                    if energised[0] < 0.5:
                        _throttle_return(p, s, 0, before_0, supply, return_kept)
                    if energised[1] < 0.5:
                        _throttle_return(p, s, 1, before_1, supply, return_kept)
                    if energised[2] < 0.5:
                        _throttle_return(p, s, 2, before_2, supply, return_kept)
                    if energised[3] < 0.5:
                        _throttle_return(p, s, 3, before_3, supply, return_kept)
                if overlap > 0.0:
                    passing[0] = _overlap(p, s, 0, supply, overlap, passing[0])
                    passing[1] = _overlap(p, s, 1, supply, overlap, passing[1])
                    passing[2] = _overlap(p, s, 2, supply, overlap, passing[2])
                    passing[3] = _overlap(p, s, 3, supply, overlap, passing[3])
                if gap_volume > 0.0:
                    gap[0] = _fill_gap(p, s, 0, before_0, gap[0])
                    gap[1] = _fill_gap(p, s, 1, before_1, gap[1])
                    gap[2] = _fill_gap(p, s, 2, before_2, gap[2])
                    gap[3] = _fill_gap(p, s, 3, before_3, gap[3])
                lagged[0] = kept * lagged[0] + of_begin * before_0 + of_end * s.pressure[0]
                lagged[1] = kept * lagged[1] + of_begin * before_1 + of_end * s.pressure[1]
                lagged[2] = kept * lagged[2] + of_begin * before_2 + of_end * s.pressure[2]
                lagged[3] = kept * lagged[3] + of_begin * before_3 + of_end * s.pressure[3]
                if len(between) and tick % _TICKS_OF_STEP == _TICKS_OF_STEP // 2 - 1:
                    for i in range(4):
                        between[k, tick // _TICKS_OF_STEP, i] = s.pressure[i]
            if len(between):
                _leave_line(between[k], begin, s)
        elif k > 0:
            for _ in range(TICKS):  # of no pressure in the brakes, to the last bit as above
                for i in range(4):
                    lagged[i] *= kept
        for i in range(4):
            out[0, k, i], out[1, k, i] = lagged[i], s.pressure[i]
            if valid[k, i] > 0.0:
                apart = measured[k, i] - lagged[i]
                band = dead_band if least[k, i] <= gain else 0.0
                if abs(apart) > band:
                    drawn = max(gain, least[k, i]) * (apart - math.copysign(band, apart))
                    _move_target(p, s, i, drawn, master[k])
                    before = s.pressure[i]
                    _set_pressure(s, i, max(before + drawn, 0.0))
                    lagged[i] += s.pressure[i] - before
            if cornering[k] and s.pressure[i] < _RELEASED_PA:
                gap[i] = gap_volume
