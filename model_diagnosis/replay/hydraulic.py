"""Pressures as the vehicle's booster and hydraulic unit make them from the pedal, the valves and the pump."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter1d
from scipy.signal import lfilter

from hydraulics.parameters import PARAMETERS
from hydraulics.record import PARAMETER_RECORD, STEP_S, fill_record
from hydraulics.selection_logic import LOGICS
from hydraulics.state import STATE_RECORD
from model_diagnosis.effects.effect import EffectParameter
from model_diagnosis.effects.form import FORM_HYDRAULICS_EFFECTS
from model_diagnosis.effects.hydraulics import HYDRAULICS_EFFECTS
from model_diagnosis.effects.sensor_chain import PRESSURE_LAG
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.replay.hydraulic_run import hydraulic_run, lag_shares
from model_diagnosis.replay.phases import Phases
from model_diagnosis.replay.smoothing import pressure_without_noise
from model_diagnosis.replay.state import SUBSTEPS
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]

GAIN = 0.15
"""Gain of the observer on wheel pressures per 10 ms."""

_KNEE_PA = 8e6
"""Knee of a booster whose vehicle file has none."""

_CORNERING_M_S2 = 4.0
_DEAD_BAND = 3.0
_THRESHOLD = "hydraulics.pressure_change_threshold"
_FLOW_THROUGH = "hydraulics.flow_through"
_EVERY_CHANGE_PA = 1e3
_PUMP_SAMPLES = 50
_VALVES = ("inlet", "outlet")
_DEAD_TIMES = frozenset(f"hydraulics.{valve}_delay_{wheel}" for valve in _VALVES for wheel in WHEELS)
_EARLIEST_S = 0.5 * SAMPLE_TIME_S
"""A command is known to half a sample only: with a dead time near 0 a valve may have moved so much before it."""
_OF_VALVES = (
    "inlet_valve_delay",
    "outlet_valve_delay",
    "outlet_valve_conductance",
    "pump_rate",
    "low_pressure_accumulator_full",
    "form_release",
    "form_valve_overlap",
    "form_pump_back_pressure",
)
"""Effects of what fluid passes only while a valve is moved, or comes from there."""
_LEAKS = tuple(f"hydraulics.brake_leak_{wheel}" for wheel in WHEELS)
_LEAST_LEAK = 1e-21
"""m^3/s/Pa, no measurable pressure. A segment that nothing disturbs goes on by its time, one that is disturbed anew
from its pressure: with the first leak or air the pressures would jump by what half a percent of a failure does."""
_WHOLE = 1e-9
_UNITS_KEPT = 64
_TELLING_PA = 1e5
"""Change of a pressure within a sample that its sensor's noise does not hide: three deviations of a series sensor's."""

HYDRAULIC_COLUMNS: Mapping[str, EffectParameter] = {
    column: parameter
    for effect in (*HYDRAULICS_EFFECTS, *FORM_HYDRAULICS_EFFECTS)
    for column, parameter in zip(effect.columns, effect.parameters, strict=True)
}
"""Columns that act before the wheel brakes."""

_PATHS: Mapping[str, tuple[str, ...]] = {
    column: tuple(one.path for one in PARAMETERS if fnmatchcase(one.path, parameter.vehicle_path))
    for column, parameter in HYDRAULIC_COLUMNS.items()
    if parameter.vehicle_path
}
"""Numbers of the vehicle that each of them changes."""


_OF_STEPS = ("circuit_failure.first", "circuit_failure.second")
"""Columns in whose direction a unit that moves by steps is off by its form, and one that flows is not."""


@cache
def acts_on_pressures(column: str) -> bool:
    """True for a column that changes the pressures of the wheel brakes or their sensors."""
    return column in HYDRAULIC_COLUMNS or column.startswith("pressure_sensor_")


def without_steps(parameters: Sequence[EffectParameter], columns: Sequence[str]) -> tuple[EffectParameter, ...]:
    """The parameters of these columns for a unit that flows."""
    return tuple(
        replace(one, form_std=0.0) if column in _OF_STEPS else one
        for one, column in zip(parameters, columns, strict=True)
    )


def acts_by_valves(column: str) -> bool:
    """True for a column that changes nothing as long as no valve is moved."""
    return column.partition(".")[0] in _OF_VALVES


@dataclass(frozen=True)
class HydraulicLog:
    """Channels of one manoeuvre that go into the hydraulics.

    Attributes
    ----------
    master, pedal : (n,) Pa and N, without noise; None where not measured
    inlet, outlet, pump : (n, 4), (n, 4), (n,); the valves at rest where not measured
    commanded : True where the valve commands were measured
    cornering : (n,) True at more than 4 m/s^2
    behind_commands, behind_master : how much later than these the wheel pressures are taken [samples]
    """

    master: FloatArray | None
    pedal: FloatArray | None
    inlet: FloatArray
    outlet: FloatArray
    pump: FloatArray
    commanded: bool
    cornering: NDArray[np.bool_]
    behind_commands: float = 0.0
    behind_master: float = 0.0

    @property
    def switched(self) -> bool:
        """True where a valve was moved."""
        return bool(self.inlet.any() or self.outlet.any())


def read_hydraulics(manoeuvre: Manoeuvre, phases: Phases) -> HydraulicLog | None:
    """What a manoeuvre tells of its hydraulics; None without master pressure and pedal force."""
    channels, n = manoeuvre.channels, manoeuvre.samples
    if "master_pressure" not in channels and "pedal_force" not in channels:
        return None

    def wheels(name: str) -> FloatArray:
        return np.stack([channels.get(f"{name}_{wheel}", np.zeros(n)) for wheel in WHEELS], axis=1)

    inlet, outlet = (np.ascontiguousarray(wheels(f"valve_{valve}")) for valve in _VALVES)
    active = np.max(np.maximum(inlet, outlet), axis=1) > 0.5
    # without a channel the pump runs as long as valves were moved in the last half second
    assumed = np.convolve(active, np.ones(_PUMP_SAMPLES), "full")[:n] > 0.0
    lateral = channels.get("lateral_acceleration", np.zeros(n))
    return HydraulicLog(
        master=_driving(channels, "master_pressure"),
        pedal=_driving(channels, "pedal_force"),
        inlet=inlet,
        outlet=outlet,
        pump=channels.get("pump", assumed.astype(np.float64)),
        commanded=all(f"valve_{valve}_{wheel}" in channels for valve in _VALVES for wheel in WHEELS),
        cornering=np.abs(lateral) > _CORNERING_M_S2,
        behind_commands=phases.pressure - phases.command,
        behind_master=phases.pressure - phases.master,
    )


def _driving(channels: Mapping[str, FloatArray], name: str) -> FloatArray | None:
    """Channel as an input, without its sensor's noise: a brake that lets fluid back fast follows its lowest values."""
    return pressure_without_noise(channels[name]) if name in channels else None


class HydraulicReplay:
    """Booster and hydraulic unit of a vehicle.

    Attributes
    ----------
    flows : True if pressures follow every change of their supply, as in real valves; False if only changes beyond the
        vehicle file's threshold begin a new segment, as in the friction document's unit (2.6)
    """

    def __init__(self, vehicle: VehicleFile) -> None:
        numbers = vehicle.numbers("brakes") | vehicle.numbers("hydraulics")
        given = {parameter.path: numbers.get(parameter.path, parameter.default) for parameter in PARAMETERS}
        self._values = {path: float(value) for path, value in given.items() if value is not None}
        self._units = lru_cache(maxsize=_UNITS_KEPT)(self._make_units)
        self.flows = False
        self._booster_gain = vehicle.brakes.booster_gain
        self._knee = numbers.get("brakes.booster_knee_pressure", _KNEE_PA)
        self._slope_loss = numbers.get("brakes.booster_slope_loss", 0.0)

    def master(self, deviations: Mapping[str, float], log: HydraulicLog) -> FloatArray:
        """Master pressure (n,) [Pa] by the pedal's force through the booster."""
        assert log.pedal is not None
        gain = self._booster_gain * (1.0 + deviations.get("booster_saturation.gain", 0.0))
        pressure = gain * log.pedal
        lag = deviations.get("form_booster.lag", 0.0)
        if lag > 0.0:
            pressure = _lagged(pressure, lag)
        loss = min(self._slope_loss + deviations.get("booster_saturation.slope_loss", 0.0), 1.0)
        if loss == 0.0:
            return pressure
        knee = self._knee + deviations.get("booster_saturation.knee", 0.0)
        return pressure - loss * np.maximum(pressure - knee, 0.0)

    def wheels(
        self,
        deviations: Mapping[str, float],
        log: HydraulicLog,
        measured: FloatArray,
        valid: FloatArray,
        gain: float = GAIN,
        noise: float = 0.0,
        least: FloatArray | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """What the sensors read behind their lag and the pressures of the wheels' brakes, both (n, 4) [Pa].

        Each sample is that before its correction.

        Parameters
        ----------
        deviations : by column; those of other parts are passed over
        measured, valid : (n, 4) readings that the observer corrects on, lagged ones with a lag; 1 where they hold
        gain : of the observer per sample; 0 for a free run
        noise : standard deviation of the measured pressures' noise [Pa]; up to three of it correct nothing
        least : (n, 4) least gains; zeros if left out
        """
        least = np.zeros_like(valid) if least is None else least
        (readings, brakes), _ = self._run(deviations, log, measured, valid, gain, least, _DEAD_BAND * noise)
        return readings, brakes

    def _run(
        self,
        deviations: Mapping[str, float],
        log: HydraulicLog,
        measured: FloatArray,
        valid: FloatArray,
        gain: float,
        least: FloatArray,
        dead_band: float,
        shape: tuple[int, int, int] = (0, SUBSTEPS, 4),
    ) -> tuple[FloatArray, FloatArray]:
        """Pressures (2, n, 4) of sensors and brakes and, if asked for by ``shape``, of the brakes between samples."""
        master = log.master if log.master is not None else self.master(deviations, log)
        volume = deviations.get("brake_knock_back.volume", 0.0)
        throttled = deviations.get("form_return.lag", 0.0)
        # an implicit step: its slope at a lag of 0 is not 0, as that of an exponential would be
        return_kept = throttled / (throttled + STEP_S)
        overlap = deviations.get("form_valve_overlap.time", 0.0)
        lag = deviations.get(PRESSURE_LAG, 0.0)
        changes = tuple((column, value) for column, value in deviations.items() if column in _PATHS)
        total, total_between = np.zeros((2, len(master), 4)), np.zeros(shape)
        out = np.empty_like(total)
        # dead times of valves that nobody switches say nothing: one run instead of five
        for share, record in self._units(changes, log.switched, self.flows):
            between = np.zeros(shape)  # rows in which this unit rests are not written
            hydraulic_run(
                record, np.zeros(1, STATE_RECORD), master, log.inlet, log.outlet, log.pump,
                log.cornering, log.behind_commands, log.behind_master, measured, valid, volume, return_kept, overlap,
                lag, gain, least, dead_band, between, out,
            )  # fmt: skip
            total += share * out
            total_between += share * between
        return total, total_between

    def between_samples(
        self,
        deviations: Mapping[str, float],
        log: HydraulicLog,
        measured: FloatArray,
        valid: FloatArray,
        least: FloatArray,
    ) -> FloatArray:
        """Pressures (n, SUBSTEPS, 4) [Pa] beside the straight lines between samples, in the middle of the car's steps.

        Valves switch within a sample. The unit tells the course; where its change over a sample is not the measured
        one, it has switched at another instant or not at all, and tells so much the less.

        Parameters
        ----------
        deviations : of the unit's numbers, by column
        measured, valid : (n, 4) wheel pressures [Pa], 1 where they hold
        least : (n, 4) least gains
        """
        shape = len(measured), SUBSTEPS, 4
        (_, out), between = self._run(deviations, log, measured, valid, 1.0, least, 0.0, shape)
        off = np.zeros_like(out)
        off[1:] = valid[1:] * np.abs(measured[1:] - out[1:])
        moved = np.abs(np.diff(out, axis=0, prepend=out[:1]))
        size = np.maximum(moved, np.abs(between).max(axis=1))
        # a rise and fall within one sample shows at neither end: who is wrong in the next samples is wrong in it too
        trust = np.where(size > _TELLING_PA, np.clip(1.0 - off / np.maximum(size, _TELLING_PA), 0.0, 1.0), 1.0)
        trust = minimum_filter1d(trust, 3, axis=0, mode="nearest")
        return np.asarray(between * trust[:, None, :])

    def _make_units(
        self, changes: tuple[tuple[str, float], ...], switched: bool, flows: bool
    ) -> list[tuple[FloatArray, NDArray[np.void]]]:
        """Units with these deviations and the share (4,) of each in the pressures; manoeuvres take the same ones."""
        values = self._changed(changes, flows)
        units = []
        for share, delays in _whole_delays(values) if switched else [(np.ones(4), {})]:
            record = np.zeros(1, PARAMETER_RECORD)
            fill_record(values | delays, record)
            record[0]["logic"][:] = LOGICS["abs"]().table.reshape(-1)
            units.append((share, record))
        return units

    def _changed(self, changes: Sequence[tuple[str, float]], flows: bool) -> dict[str, float]:
        values = dict(self._values)
        for column, deviation in changes:
            for path in _PATHS[column]:
                if path not in values:
                    continue
                relative = HYDRAULIC_COLUMNS[column].relative
                values[path] = values[path] * (1.0 + deviation) if relative else values[path] + deviation
        for path in {path for column, _ in changes for path in _PATHS[column] if path in values}:
            # of two deviations that act on one number only the sum is limited
            values[path] = max(values[path], -_EARLIEST_S if path in _DEAD_TIMES else 0.0)
        if flows:
            values[_FLOW_THROUGH] = 1.0
            values[_THRESHOLD] = min(values[_THRESHOLD], _EVERY_CHANGE_PA)
            values |= {path: max(values[path], _LEAST_LEAK) for path in _LEAKS}
        return values


def _lagged(values: FloatArray, time_constant: float) -> FloatArray:
    """Values (n,) behind a first-order lag [s] that rests at the first one, straight lines between them.

    A lag far below a sample delays by its time constant; values held over a sample would not feel it.
    """
    kept, of_begin, of_end = lag_shares(time_constant, SAMPLE_TIME_S)
    lagged, _ = lfilter([of_end, of_begin], [1.0, -kept], values, zi=np.array([(1.0 - of_end) * values[0]]))
    return np.asarray(lagged, dtype=np.float64)


def _whole_delays(values: Mapping[str, float]) -> list[tuple[FloatArray, dict[str, float]]]:
    """The unit's dead times are whole milliseconds: shares (4,) of the runs whose pressures are blended.

    Three neighbours are blended by a quadratic spline, whose slope has no jumps that a fit could rest in; what inlet
    and outlet valves add is summed. Below 0 the pressures go on in a straight line from dead times of 0 and 1 ms.
    """
    whole, shares = {}, {}
    for valve in _VALVES:
        steps = np.array([values[f"hydraulics.{valve}_delay_{wheel}"] for wheel in WHEELS]) / STEP_S
        whole[valve] = np.maximum(np.round(steps), 0.0)
        part = steps - whole[valve]
        if np.max(np.abs(part)) < _WHOLE:
            continue
        earlier, later = 0.5 * (0.5 - part) ** 2, 0.5 * (0.5 + part) ** 2
        first = whole[valve] < 1.0
        shares[valve] = {
            -1: np.where(first, 0.0, earlier),
            0: 1.0 - earlier - later + np.where(first, 2.0 * earlier, 0.0),
            1: later - np.where(first, earlier, 0.0),
        }
    runs: dict[tuple[int, int], FloatArray] = {}
    for column, valve in enumerate(_VALVES):
        for shift, share in shares.get(valve, {0: np.ones(4)}).items():
            run = (shift, 0) if column == 0 else (0, shift)
            runs[run] = runs.get(run, np.zeros(4)) + share
    runs[0, 0] = runs[0, 0] - 1.0
    return [
        (
            share,
            {
                f"hydraulics.{valve}_delay_{wheel}": max(float(whole[valve][i]) + shift, 0.0) * STEP_S
                for valve, shift in zip(_VALVES, shifts, strict=True)
                for i, wheel in enumerate(WHEELS)
            },
        )
        for shifts, share in runs.items()
        if share.any()
    ]


def reported_pressure(deviations: Mapping[str, float], lagged: FloatArray) -> FloatArray:
    """What the wheels' pressure sensors report (n, 4) of pressures behind their lag: scale, offset."""
    scale = deviations.get("pressure_sensor_scale.wheels", 0.0)
    offset = deviations.get("pressure_sensor_offset.wheels", 0.0)
    return lagged if scale == 0.0 and offset == 0.0 else lagged * (1.0 + scale) + offset
