"""One tick of the bench. ``docs/event_sequence.md`` tells the same order in words.

drain received frames → driver and stimuli → hydraulics → plant → sensors → frames that are due → tap → estimators →
record. Every part writes its own block of the signal vector; this module only says who is next.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from bench.codec.codec import Receiver, Transmitter
from bench.links.frame import FRAME_DTYPE
from bench.loop.bus_load import BusLoad
from bench.loop.quiet_tick import QuietTick
from bench.loop.stimuli import Stimuli
from hydraulics import HydraulicUnit
from signals.vector import SignalVector
from vehicle_model.interface import Plant
from vehicle_model.manoeuvre import Manoeuvre
from vehicle_model.powertrain import Powertrain
from vehicle_model.sensors import Sensors

if TYPE_CHECKING:
    from bench.injection.in_run import InjectorInRun
    from bench.sensor_cluster.in_run import SensorCluster

TICK_S = 1e-3
MAX_FRAMES_PER_TICK = 4096


class EcuSide(Protocol):
    """What stands on the other side of the bus, as the tick sees it."""

    origin_ns: int

    def prepare(self) -> None:
        """Called last before the clock starts."""

    def receive(self, tick: int, frames: NDArray[np.void]) -> int:
        """Frames that the bench sees in this tick; returns their number."""

    def send(self, tick: int, frames: NDArray[np.void], count: int) -> None:
        """Frames that the bench sends in this tick."""


class Recorder(Protocol):
    """Where rows and frames of a run go."""

    def write_row(self, values: NDArray[np.float64], tick: int) -> None:
        """The signal vector at the end of a tick."""

    def write_frames(self, frames: NDArray[np.void], count: int) -> None:
        """Frames sent or received in a tick."""


class EstimatorSlot(Protocol):
    """An estimator bound to its place in the signal vector."""

    @property
    def tick(self) -> Callable[[], Any]:
        """Reads the tap, writes the outputs."""


class Tick:
    """The parts of a run in the order in which a tick calls them."""

    def __init__(
        self,
        vector: SignalVector,
        sensed: NDArray[np.float64],
        *,
        ecu_side: EcuSide,
        from_ecu: Receiver,
        manoeuvre: Manoeuvre,
        stimuli: Stimuli,
        powertrain: Powertrain,
        hydraulic_unit: HydraulicUnit,
        plant: Plant,
        sensors: Sensors,
        transmitter: Transmitter,
        tap: Receiver,
        estimators: Sequence[EstimatorSlot],
        recorder: Recorder,
        injector: "InjectorInRun | None" = None,
        sensor_cluster: "SensorCluster | None" = None,
    ) -> None:
        self.vector = vector
        self._values = vector.values
        self._sensed = sensed
        self._ecu_side = ecu_side
        self._from_ecu = from_ecu
        self._manoeuvre = manoeuvre
        self._stimuli = stimuli
        self._powertrain = powertrain
        self._hydraulic_unit = hydraulic_unit
        self._plant = plant
        self._sensors = sensors
        self._transmitter = transmitter
        self._tap = tap
        self._estimators = tuple(estimators)
        self._estimator_ticks = tuple(estimator.tick for estimator in estimators)
        self._recorder = recorder
        self._injector = injector
        self._sensor_cluster = sensor_cluster
        self._received = np.zeros(MAX_FRAMES_PER_TICK, FRAME_DTYPE)
        self._due = np.zeros(64, FRAME_DTYPE)
        self._bus_load = BusLoad()
        self._bind_views()
        self._quiet: QuietTick | None = None
        if injector is None and sensor_cluster is None:
            self._quiet = QuietTick(
                vector,
                sensed,
                manoeuvre=manoeuvre,
                powertrain=powertrain,
                hydraulic_unit=hydraulic_unit,
                plant=plant,
                sensors=sensors,
                transmitter=transmitter,
                tap=tap,
                bus_load=self._bus_load,
                received=self._received,
                due=self._due,
            )

    def _bind_views(self) -> None:
        vector, index = self.vector, self.vector.index
        values = self._values

        def four(first: str) -> NDArray[np.float64]:
            return values[index(first) : index(first) + 4]

        self._time = index("time")
        self._driver_master_pressure = index("driver_master_pressure")
        self._accelerator = index("driver_accelerator")
        self._clutch = index("driver_clutch")
        self._gear = index("driver_gear")
        self._steering_wheel_angle = index("driver_steering_wheel_angle")
        self._pump = index("pump")
        self._load = index("bus_load")
        self._faults_active = index("faults_active")
        self._valve_inlet = four("valve_inlet_fl")
        self._valve_outlet = four("valve_outlet_fl")
        self._true_wheel_speed = four("true_wheel_speed_fl")
        self._brake_torque_capacity = four("brake_torque_capacity_fl")
        self._drive_torque_demand = four("drive_torque_demand_fl")
        self._hydraulics_block = vector.block("hydraulics")
        self._powertrain_block = vector.block("powertrain")

    @property
    def finished(self) -> bool:
        """True once the last step of the manoeuvre has ended."""
        return self._manoeuvre.finished

    def run(self, tick: int) -> None:
        """Advance the bench by 1 ms."""
        values, injector = self._values, self._injector
        time_s = tick * TICK_S
        values[self._time] = time_s
        if injector is not None:
            injector.begin_tick(tick)
        received = self._ecu_side.receive(tick, self._received)
        if injector is not None:
            received = injector.to_bench(self._received, received, tick)
        self._from_ecu.accept(self._received, received, tick)

        quiet = self._quiet
        if quiet is not None and self._stimuli.idle:
            self._manoeuvre.decide(time_s)
            passed, due = self._due, quiet.tick(tick, time_s, received)
            if due:
                self._ecu_side.send(tick, passed, due)
        else:
            self._move_car(tick, time_s)
            passed, due = self._exchange(tick, received)
        for estimator_tick in self._estimator_ticks:
            estimator_tick()
        self._record(tick, received, passed, due)

    def _move_car(self, tick: int, time_s: float) -> None:
        """Driver, stimuli, hydraulics, plant, sensors, part by part: stimuli change signals in between."""
        values, stimuli = self._values, self._stimuli
        self._manoeuvre.tick(time_s)
        stimuli.tick(time_s)
        stimuli.override_commands()
        self._powertrain.tick(
            values[self._accelerator],
            values[self._clutch],
            values[self._gear],
            self._true_wheel_speed,
            self._powertrain_block,
        )
        self._hydraulic_unit.tick(
            values[self._driver_master_pressure],
            self._valve_inlet,
            self._valve_outlet,
            values[self._pump],
            self._hydraulics_block,
            self._true_wheel_speed,
        )
        stimuli.override_actuation()
        self._plant.tick(
            self._brake_torque_capacity, self._drive_torque_demand, values[self._steering_wheel_angle], time_s
        )
        self._sensors.tick(values, time_s, self._sensed)
        stimuli.override_sensed()
        if self._sensor_cluster is not None:
            self._sensor_cluster.tick(tick)

    def _exchange(self, tick: int, received: int) -> tuple[NDArray[np.void], int]:
        """Send what is due, through the injector if there is one; frames as the ECU's side sees them, number due."""
        due, injector, cluster = self._transmitter.due(tick, self._due), self._injector, self._sensor_cluster
        passed, passed_count = (self._due, due) if injector is None else injector.to_ecu(self._due, due, tick)
        if passed_count:
            self._ecu_side.send(tick, passed, passed_count)
        self._tap.accept(passed, passed_count, tick)
        if cluster is not None and cluster.hears_the_bus:
            self._tap.accept(self._received, received, tick)
        self._values[self._load] = self._bus_load.update(self._received, received, self._due, due)
        return passed, due

    def _record(self, tick: int, received: int, passed: NDArray[np.void], due: int) -> None:
        values, injector, recorder = self._values, self._injector, self._recorder
        values[self._faults_active] = self._stimuli.active_count
        if injector is not None:
            values[self._faults_active] += injector.acting
            injector.end_tick()
        recorder.write_row(values, tick)
        if received:
            recorder.write_frames(self._received, received)
        if due:
            if passed is not self._due:
                self._due["timestamp_ns"][:due] += self._ecu_side.origin_ns
            recorder.write_frames(self._due, due)
        if injector is not None:
            injector.record(recorder.write_frames, self._ecu_side.origin_ns)
