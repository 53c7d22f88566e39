"""What the dashboard knows of a run at one instant, gathered from the rows of the signal vector."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]

KMH, BAR, DEGREES, MICROSECONDS = 3.6, 1e-5, 180.0 / np.pi, 1e6
HISTORY = 240
FAST_M_S = 4.0
STANDING_M_S = 0.3
USUAL_RADIUS_M = 0.3  # until the car has been fast enough to tell
HISTORY_STEP_S = 0.05

_LOWEST_US, _HIGHEST_US, _PER_DECADE = 0.01, 1e7, 24


class Percentiles:
    """Percentiles of durations in µs from a histogram with bins 10 % wide: constant memory for any length of run."""

    def __init__(self) -> None:
        decades = np.log10(_HIGHEST_US / _LOWEST_US)
        self._edges = np.geomspace(_LOWEST_US, _HIGHEST_US, round(decades * _PER_DECADE) + 1)
        self._counts = np.zeros(len(self._edges), np.int64)
        self.largest = 0.0

    def add(self, values_us: FloatArray) -> None:
        """Count some durations."""
        if len(values_us) == 0:
            return
        places = np.clip(np.searchsorted(self._edges, values_us), 0, len(self._edges) - 1)
        self._counts += np.bincount(places, minlength=len(self._edges))
        self.largest = max(self.largest, float(values_us.max()))

    def at(self, percent: float) -> float:
        """Duration that ``percent`` of all do not exceed."""
        total = int(self._counts.sum())
        if total == 0:
            return 0.0
        place = int(np.searchsorted(np.cumsum(self._counts), total * percent / 100.0))
        return min(float(self._edges[min(place, len(self._edges) - 1)]), self.largest)


@dataclass(frozen=True)
class FrictionEstimate:
    """Estimate of the friction limit of an axle."""

    axle: str
    value: float
    deviation: float | None
    confident: bool | None


@dataclass
class Snapshot:
    """One instant of a run in display units; None where the run has no such signal."""

    time_s: float = 0.0
    phase: str = ""
    speed_kmh: float = 0.0
    deceleration_m_s2: float | None = None
    distance_m: float | None = None
    yaw_rate_deg_s: float | None = None
    steering_deg: float | None = None
    wheel_speed_kmh: tuple[float, ...] = ()
    slip_percent: tuple[float, ...] = ()
    pressure_bar: tuple[float, ...] = ()
    pressure_change_bar: tuple[float, ...] = ()
    valve: tuple[str, ...] = ()
    ecu_phase: tuple[str, ...] = ()
    switches: dict[str, bool] = field(default_factory=dict)
    ecu_fault_code: int = 0
    ecu_silent_s: float | None = None
    friction: tuple[FrictionEstimate, ...] = ()
    friction_road: tuple[float, ...] = ()
    bus_load_percent: float | None = None
    frames: int = 0
    faults_active: int = 0
    lateness_p99_us: float = 0.0
    lateness_max_us: float = 0.0
    tick_cpu_us: float = 0.0
    overruns: int = 0
    ticks: int = 0
    speed_history: tuple[float, ...] = ()


ECU_PHASES = ("–", "build-up", "hold", "release", "rebuild")


class RunView:
    """Follows a run row by row.

    Parameters
    ----------
    names : sequence of str
        Columns of the rows.
    phase_names : sequence of str
        Steps of the manoeuvre.
    information : mapping
        What is known of the run: scenario, ecu, link, mode.
    """

    def __init__(
        self, names: Sequence[str], phase_names: Sequence[str] = (), information: Mapping[str, Any] | None = None
    ) -> None:
        self.information = dict(information or {})
        self.phase_names = tuple(phase_names)
        self._column = {name: position for position, name in enumerate(names)}
        self._axles = [
            (axle, estimate)
            for axle in ("front", "rear")
            if (estimate := next((n for n in names if n.endswith(f".friction_limit_{axle}")), None)) is not None
        ]
        self._lateness, self._cpu = Percentiles(), Percentiles()
        self._last_pressure: tuple[float, ...] = ()
        self._radius = [USUAL_RADIUS_M] * len(WHEELS)
        self._history: list[float] = []
        self._next_history_s = 0.0
        self.highest_speed_kmh = 1.0
        self.snapshot = Snapshot()

    def column(self, name: str) -> int:
        """Position of a signal in the rows; KeyError if they lack it."""
        return self._column[name]

    def update(self, rows: FloatArray, frames: int) -> Snapshot:
        """Take new rows, shape (n, columns), and the number of frames so far; returns the newest instant."""
        if len(rows) == 0:
            self.snapshot.frames = frames
            return self.snapshot
        self._lateness.add(self._all(rows, "lateness") * MICROSECONDS)
        self._cpu.add(self._all(rows, "tick_cpu_time") * MICROSECONDS)
        self._remember_speed(rows)
        row = rows[-1]
        pressure = self._wheels(row, "true_brake_pressure", BAR)
        change = tuple(new - old for new, old in zip(pressure, self._last_pressure or pressure, strict=True))
        self._last_pressure = pressure
        recent = rows[-50:]
        self.snapshot = Snapshot(
            time_s=self._value(row, "time") or 0.0,
            phase=self._phase(row),
            speed_kmh=self._value(row, "speed", KMH) or 0.0,
            deceleration_m_s2=self._mean(recent, "true_longitudinal_acceleration", -1.0),
            distance_m=self._value(row, "distance"),
            yaw_rate_deg_s=self._mean(recent, "true_yaw_rate", DEGREES),
            steering_deg=self._value(row, "driver_steering_wheel_angle", DEGREES),
            wheel_speed_kmh=self._rim_speeds(row),
            slip_percent=self._slips(row),
            pressure_bar=pressure,
            pressure_change_bar=change,
            valve=self._valves(row),
            ecu_phase=self._ecu_phases(row),
            switches=self._switches(row),
            ecu_fault_code=int(self._value(row, "ecu_fault_code") or 0),
            ecu_silent_s=self._value(row, "age_valve_pump"),
            friction=self._friction(row),
            friction_road=self._wheels(row, "friction_limit", 1.0),
            bus_load_percent=self._value(row, "bus_load", 100.0),
            frames=frames,
            faults_active=int(self._value(row, "faults_active") or 0),
            lateness_p99_us=self._lateness.at(99.0),
            lateness_max_us=self._lateness.largest,
            tick_cpu_us=self._cpu.at(50.0),
            overruns=int(self._value(row, "overruns") or 0),
            ticks=self.snapshot.ticks + len(rows),
            speed_history=tuple(self._history),
        )
        return self.snapshot

    def _all(self, rows: FloatArray, name: str) -> FloatArray:
        position = self._column.get(name)
        return rows[:, position] if position is not None else np.zeros(0)

    def _value(self, row: FloatArray, name: str, factor: float = 1.0) -> float | None:
        position = self._column.get(name)
        return float(row[position]) * factor if position is not None else None

    def _mean(self, rows: FloatArray, name: str, factor: float) -> float | None:
        position = self._column.get(name)
        return float(rows[:, position].mean()) * factor if position is not None else None

    def _wheels(self, row: FloatArray, name: str, factor: float) -> tuple[float, ...]:
        values = [self._value(row, f"{name}_{wheel}", factor) for wheel in WHEELS]
        return tuple(value for value in values if value is not None) if None not in values else ()

    def _slips(self, row: FloatArray) -> tuple[float, ...]:
        """Brake slip in %; none while the car stands, where a fraction of the speed means nothing."""
        slips = self._wheels(row, "slip_ratio", -100.0)
        moving = abs(self._value(row, "speed") or 0.0) > STANDING_M_S
        return slips if moving else tuple(math.nan for _ in slips)

    def _phase(self, row: FloatArray) -> str:
        index = int(self._value(row, "manoeuvre_phase") or 0)
        return self.phase_names[index] if 0 <= index < len(self.phase_names) else ""

    def _rim_speeds(self, row: FloatArray) -> tuple[float, ...]:
        """Speed of the wheels' circumference R ω; the radius R comes from the slip while the car is fast.

        Slip is (R ω - v)/max(R ω, v), so R ω = v (1 + slip) while braking and v/(1 - slip) while driving.
        """
        speeds = self._wheels(row, "true_wheel_speed", 1.0)
        centres, slips = self._wheels(row, "wheel_centre_speed", 1.0), self._wheels(row, "slip_ratio", 1.0)
        for wheel, (speed, centre, slip) in enumerate(zip(speeds, centres, slips, strict=False)):
            if centre > FAST_M_S and speed > 1.0 and abs(slip) < 0.5:
                self._radius[wheel] = (centre * (1.0 + slip) if slip <= 0.0 else centre / (1.0 - slip)) / speed
        return tuple(speed * radius * KMH for speed, radius in zip(speeds, self._radius, strict=False))

    def _valves(self, row: FloatArray) -> tuple[str, ...]:
        inlet, outlet = self._wheels(row, "valve_inlet", 1.0), self._wheels(row, "valve_outlet", 1.0)
        return tuple(
            "release" if opened > 0.5 else "hold" if closed > 0.5 else "build-up"
            for closed, opened in zip(inlet, outlet, strict=False)
        )

    def _ecu_phases(self, row: FloatArray) -> tuple[str, ...]:
        codes = self._wheels(row, "ecu_phase", 1.0)
        return tuple(ECU_PHASES[int(code)] if 0 <= code < len(ECU_PHASES) else "?" for code in codes)

    def _switches(self, row: FloatArray) -> dict[str, bool]:
        signals = {"ABS": "abs_active", "pump": "pump", "EBD": "ebd_active", "lamp": "abs_lamp"}
        return {label: (self._value(row, name) or 0.0) > 0.5 for label, name in signals.items() if name in self._column}

    def _friction(self, row: FloatArray) -> tuple[FrictionEstimate, ...]:
        found = []
        for axle, estimate in self._axles:
            confidence = self._value(row, f"{estimate}_confidence")
            found.append(
                FrictionEstimate(
                    axle,
                    self._value(row, estimate) or 0.0,
                    self._value(row, f"{estimate}_std"),
                    None if confidence is None else confidence > 0.5,
                )
            )
        return tuple(found)

    def _remember_speed(self, rows: FloatArray) -> None:
        times, speeds = self._all(rows, "time"), self._all(rows, "speed")
        if len(times) == 0 or len(speeds) == 0:
            return
        self.highest_speed_kmh = max(self.highest_speed_kmh, float(speeds.max()) * KMH)
        for row in np.flatnonzero(times >= self._next_history_s):
            if times[row] >= self._next_history_s:
                self._history.append(float(speeds[row]) * KMH)
                self._next_history_s = float(times[row]) + HISTORY_STEP_S
        if len(self._history) > HISTORY:
            del self._history[: len(self._history) - HISTORY]
