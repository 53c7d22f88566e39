"""Charts of the brakes and of the ECU: wheel pressures with the valves under them, phases, switches, driver."""

from collections.abc import Mapping

import numpy as np

from bench.report.charts import Chart, ChartBook, Lane, LaneChart, LaneSegment, LineChart, Series, State, Strip
from bench.report.run_data import FloatArray, RunData
from bench.report.thinning import segments
from signals.wheels import WHEELS

BAR = 1e-5

VALVES = ((0, State("build-up", "build")), (1, State("hold", "hold")), (2, State("release", "release")))
ECU_PHASES = (
    (1, State("build-up", "build")),
    (2, State("hold", "hold")),
    (3, State("release", "release")),
    (4, State("stepped rebuild", "rebuild")),
)
WHEEL_WORDS = {"fl": "front left", "fr": "front right", "rl": "rear left", "rr": "rear right"}


def valve_state(inlet: FloatArray, outlet: FloatArray) -> FloatArray:
    """0 build-up (inlet open), 1 hold (both closed), 2 release (outlet open)."""
    return np.where(outlet > 0.5, 2.0, np.where(inlet > 0.5, 1.0, 0.0))


def coloured(time: FloatArray, states: FloatArray, names: Mapping[int, State]) -> list[LaneSegment]:
    """Segments with the colour of each named state; states without a name are left blank."""
    return [(start, end, names[state].colour) for start, end, state in segments(time, states) if state in names]


def pressure_charts(run: RunData, book: ChartBook) -> list[Chart | None]:
    """For each wheel its pressure, the master pressure and a strip of what the valves do."""
    if not run.has_wheels("true_brake_pressure"):
        return []
    highest = max(float(np.nanmax(run.array(f"true_brake_pressure_{wheel}"))) for wheel in WHEELS) * BAR
    if run.has("true_master_pressure"):
        highest = max(highest, float(np.nanmax(run.array("true_master_pressure"))) * BAR)
    top = max(10.0, 1.05 * highest)
    return [_pressure_chart(run, book, wheel, top) for wheel in WHEELS]


def _pressure_chart(run: RunData, book: ChartBook, wheel: str, top: float) -> Chart:
    series, strips = [], []
    if run.has("true_master_pressure"):
        name = book.add_signal("master_pressure", run.time, run.array("true_master_pressure") * BAR)
        series.append(Series("master cylinder", name, "other", "thin"))
    pressure = book.add_signal(f"pressure_{wheel}", run.time, run.array(f"true_brake_pressure_{wheel}") * BAR)
    series.append(Series("wheel brake", pressure, wheel))
    if run.has(f"valve_inlet_{wheel}", f"valve_outlet_{wheel}"):
        states = valve_state(run.array(f"valve_inlet_{wheel}"), run.array(f"valve_outlet_{wheel}"))
        strips.append(Strip("valve", coloured(run.time, states, dict(VALVES))))
    return LineChart(
        f"pressure-{wheel}", f"Brake pressure, {WHEEL_WORDS[wheel]}", "bar", series, height=150, strips=strips,
        states=[state for _, state in VALVES] if strips else [], range=(0.0, top),
    )  # fmt: skip


def phases_chart(run: RunData) -> Chart | None:
    """Lanes: step of the manoeuvre, phase of the ECU at each wheel, its switches, active faults."""
    lanes = []
    steps = run.steps()
    if steps:
        lanes.append(Lane("step", [(step.start_s, step.end_s, "step", step.name) for step in steps]))
    states: list[State] = []
    if run.has_wheels("ecu_phase"):
        states += [state for _, state in ECU_PHASES]
        for wheel in WHEELS:
            phases = coloured(run.time, run.array(f"ecu_phase_{wheel}"), dict(ECU_PHASES))
            lanes.append(Lane(f"ECU {wheel.upper()}", phases, short=wheel.upper(), empty="no control"))
    lanes += [lane for lane in _switch_lanes(run) if lane is not None]
    if not lanes:
        return None
    return LaneChart(
        "phases", "What the ECU does", lanes, [*states, State("on", "on"), State("fault or lamp", "warning")],
        explanation="Phase of the control at each wheel as the ECU reports it; no colour: no control.",
    )  # fmt: skip


def _switch_lanes(run: RunData) -> list[Lane | None]:
    return [
        _switch(run, "abs_active", "ABS active", "ABS"),
        _switch(run, "pump", "return pump", "pump"),
        _switch(run, "ebd_active", "EBD active", "EBD"),
        _switch(run, "brake_switch", "brake switch", "brake"),
        _switch(run, "abs_lamp", "warning lamp", "lamp", "warning"),
        _codes(run, "ecu_fault_code", "ECU fault", "fault {}"),
        _codes(run, "faults_active", "stimuli, faults", "{} active"),
    ]


def _switch(run: RunData, signal: str, label: str, short: str, colour: str = "on") -> Lane | None:
    if not run.has(signal):
        return None
    named = {1: State("on", colour)}
    return Lane(
        label, coloured(run.time, (run.array(signal) > 0.5).astype(np.float64), named), short=short, empty="off"
    )


def _codes(run: RunData, signal: str, label: str, text: str) -> Lane | None:
    if not run.has(signal):
        return None
    active = [
        (start, end, "warning", text.format(code)) for start, end, code in segments(run.time, run.array(signal)) if code
    ]
    return Lane(label, active, short=label.split()[-1], empty="none")


def driver_chart(run: RunData, book: ChartBook) -> Chart | None:
    """Pedal force of the driver."""
    if not run.has("driver_pedal_force"):
        return None
    name = book.add_signal("pedal_force", run.time, run.array("driver_pedal_force"))
    return LineChart("pedal", "Brake pedal", "N", [Series("driver", name, "reference")], smallest_span=20.0)


def accumulator_chart(run: RunData, book: ChartBook) -> Chart | None:
    """Pressure of the low-pressure accumulator."""
    if not run.has("accumulator_pressure"):
        return None
    name = book.add_signal("accumulator", run.time, run.array("accumulator_pressure") * BAR)
    return LineChart(
        "accumulator",
        "Low-pressure accumulator",
        "bar",
        [Series("worst circuit", name, "reference")],
        smallest_span=2.0,
    )
