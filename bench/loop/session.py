"""A run put together from its scenario: the parts, the tick that calls them, and the loop over the ticks."""

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from bench.codec.codec import Codec, Receiver, Transmitter
from bench.codec.tables import LAST_TICK
from bench.injection.signals import injector_signals
from bench.loop.connection import Connection
from bench.loop.estimation import EstimatorSlot, NamedEstimator, create_estimators
from bench.loop.pacing import TickTimes
from bench.loop.parameters import accessors
from bench.loop.scenario_stimuli import build_stimuli
from bench.loop.stimuli import Stimuli
from bench.loop.tick import Recorder, Tick
from bench.scenario.cluster_choice import CLUSTER_PARAMETERS
from bench.scenario.estimator_names import kind_of
from bench.scenario.schema import ScenarioFile
from bench.scenario.vehicle_choice import nominal_vehicle, vehicle_as_driven
from hydraulics import HydraulicUnit
from signals.catalogue import block_slice
from signals.vector import SignalVector
from vehicle_model.interface import Plant
from vehicle_model.manoeuvre import Manoeuvre
from vehicle_model.powertrain import Powertrain
from vehicle_model.road_file import RoadFile, load_road, road_parameter_table
from vehicle_model.sensors import Sensors
from vehicle_model.vehicle_file import VehicleFile, parameter_table

if TYPE_CHECKING:
    from bench.injection.in_run import InjectorInRun
    from bench.sensor_cluster.in_run import SensorCluster

TICKS_PER_SECOND = 1000
WATCH_TICKS = 100


class Pacer(Protocol):
    """When ticks start; see :mod:`bench.loop.pacing`."""

    mode: str
    times: TickTimes

    def prepare(self) -> None:
        """Measure what has to be known before the clock starts."""

    def start(self) -> None:
        """Anchor the time base."""

    def wait(self, tick: int) -> None:
        """Return when ``tick`` may start."""

    def done(self, tick: int) -> None:
        """``tick`` has ended."""


@dataclass
class Parts:
    """Everything that a scenario describes, built but not yet connected to a bus or a recording."""

    scenario: ScenarioFile
    vehicle: VehicleFile
    vector: SignalVector
    sensed: NDArray[np.float64]
    plant: Plant
    manoeuvre: Manoeuvre
    powertrain: Powertrain
    hydraulic_unit: HydraulicUnit
    sensors: Sensors
    stimuli: Stimuli
    codec: Codec
    transmitter: Transmitter
    tap: Receiver
    from_ecu: Receiver
    estimators: list[NamedEstimator] = field(default_factory=list)
    injector: "InjectorInRun | None" = None
    sensor_cluster: "SensorCluster | None" = None

    @property
    def ticks(self) -> int:
        """Largest number of ticks that the scenario allows."""
        return round(self.scenario.time_limit * TICKS_PER_SECOND)


def build_parts(scenario: ScenarioFile) -> Parts:
    """Build the parts of a resolved scenario.

    Raises
    ------
    InputError
        If the scenario contradicts itself in a way that only building shows.
    """
    vehicle = vehicle_as_driven(scenario)
    road = road_of(scenario)
    estimators = estimators_of(scenario)
    estimated = [signal for named in estimators for signal in named.signals()]
    vector = SignalVector([*estimated, *injector_signals(scenario.faults)])
    bus = block_slice("bus")
    sensed = np.zeros(bus.stop - bus.start)
    codec = Codec.load(scenario.ecu.dbc, scenario.ecu.mapping)
    plant = build_plant(scenario, vehicle, road)
    plant.bind(vector.block("plant"))
    plant.reset(speed_m_s=scenario.initial_speed)
    manoeuvre = Manoeuvre(scenario.manoeuvre, vector, vehicle, initial_gear=scenario.initial_gear)
    hydraulic_unit = HydraulicUnit(
        vehicle.numbers("hydraulics") | vehicle.numbers("brakes"),
        scenario.hydraulic_unit.selection_logic,
        scenario.hydraulic_unit.brake,
    )
    powertrain = Powertrain(vehicle)
    sensors = Sensors(vehicle, scenario.seed)
    transmitter = codec.transmitter("bench", sensed)
    cluster = _sensor_cluster(scenario, sensed, transmitter)
    stimuli = Stimuli(vector, sensed, [], {})
    if scenario.stimuli:  # a table of every parameter costs as much as half of the other parts together
        table = [*parameter_table(vehicle), *road_parameter_table(road)]
        stimuli = build_stimuli(
            scenario.stimuli,
            vector,
            sensed,
            accessors([plant, hydraulic_unit, powertrain, manoeuvre, sensors, *([cluster] if cluster else [])]),
            {info.path: info.unit for info in [*table, *CLUSTER_PARAMETERS]},
            manoeuvre.phase_names,
            scenario.seed,
        )
    return Parts(
        scenario=scenario,
        vehicle=vehicle,
        vector=vector,
        sensed=sensed,
        plant=plant,
        manoeuvre=manoeuvre,
        powertrain=powertrain,
        hydraulic_unit=hydraulic_unit,
        sensors=sensors,
        stimuli=stimuli,
        codec=codec,
        transmitter=transmitter,
        tap=codec.receiver(
            "ecu",
            vector.block("bus"),
            vector.block("bus_age"),
            protection=scenario.ecu.protection,
            notes_lateness=scenario.sensor_cluster.kind != "external",
        ),
        from_ecu=codec.receiver(
            "bench", vector.block("bus"), vector.block("bus_age"), protection=scenario.ecu.protection
        ),
        estimators=estimators,
        injector=_injector(scenario, codec, vector, manoeuvre.phase_names),
        sensor_cluster=cluster,
    )


def _sensor_cluster(
    scenario: ScenarioFile, sensed: NDArray[np.float64], transmitter: Transmitter
) -> "SensorCluster | None":
    if scenario.sensor_cluster.kind == "none":
        return None
    from bench.sensor_cluster.in_run import sensor_cluster

    return sensor_cluster(scenario.sensor_cluster, sensed, transmitter, scenario.seed)


def estimators_of(scenario: ScenarioFile) -> list[NamedEstimator]:
    """The estimators that a scenario names."""
    if not scenario.estimators:
        return []
    requests = {name: (kind_of(name), settings) for name, settings in scenario.estimators.items()}
    return create_estimators(requests, nominal_vehicle(scenario).numbers())


def _injector(
    scenario: ScenarioFile, codec: Codec, vector: SignalVector, phases: Sequence[str]
) -> "InjectorInRun | None":
    """The fault injector on the bus of a scenario that has faults there."""
    if not scenario.faults:
        return None
    from bench.injection.in_run import InjectorInRun

    return InjectorInRun(scenario.faults, codec, vector, phases, scenario.seed)


def road_of(scenario: ScenarioFile) -> RoadFile:
    """The road of a scenario, read if the scenario only names it."""
    return load_road(scenario.road) if isinstance(scenario.road, str) else scenario.road


def build_plant(scenario: ScenarioFile, vehicle: VehicleFile, road: RoadFile) -> Plant:
    """The plant that the scenario names."""
    if scenario.plant == "single_track":
        from vehicle_model.reference.single_track import SingleTrack

        return SingleTrack(vehicle, road, substeps=max(5, scenario.plant_options.wheel_substeps))
    if scenario.plant == "planar":
        from vehicle_model.reference.planar import Planar

        return Planar(vehicle, road)
    if scenario.plant == "two_track":
        from vehicle_model.reference.two_track import TwoTrack

        return TwoTrack(vehicle, road)
    if scenario.plant == "steered_track":
        from vehicle_model.reference.steered_track import SteeredTrack

        return SteeredTrack(vehicle, road)
    from vehicle_model.plant import Plant as MujocoPlant

    return MujocoPlant(vehicle, road, wheel_substeps=scenario.plant_options.wheel_substeps)


class Session:
    """The loop over the ticks of a run.

    Parameters
    ----------
    parts : Parts
    connection : Connection
        The bus side.
    """

    def __init__(self, parts: Parts, connection: Connection) -> None:
        self.parts = parts
        self._connection = connection
        kill = parts.scenario.ecu.kill
        self._kill_ecu = kill.compile(parts.vector, parts.manoeuvre.phase_names) if kill is not None else None
        self.ticks_done = 0

    def put_together(self, recorder: Recorder) -> Tick:
        """The parts as one tick."""
        parts = self.parts
        return Tick(
            parts.vector,
            parts.sensed,
            ecu_side=self._connection.side,
            from_ecu=parts.from_ecu,
            manoeuvre=parts.manoeuvre,
            stimuli=parts.stimuli,
            powertrain=parts.powertrain,
            hydraulic_unit=parts.hydraulic_unit,
            plant=parts.plant,
            sensors=parts.sensors,
            transmitter=parts.transmitter,
            tap=parts.tap,
            estimators=[EstimatorSlot(named, parts.vector) for named in parts.estimators],
            recorder=recorder,
            injector=parts.injector,
            sensor_cluster=parts.sensor_cluster,
        )

    def run(self, recorder: Recorder, pacer: Pacer, rehearse: Callable[[], None] | None = None) -> None:
        """Tick until the manoeuvre has ended or the scenario's time is over.

        Parameters
        ----------
        rehearse : callable, optional
            Called last before the clock starts.

        Raises
        ------
        RunError
            If the ECU that the scenario wants alive is lost, or the recording fails.
        """
        cluster = self.parts.sensor_cluster
        with _without_garbage_collection():
            if cluster is None:
                self._run(recorder, pacer, rehearse)
                return
            try:
                cluster.start()
                self._run(recorder, pacer, rehearse)
            finally:
                cluster.stop()

    def _run(self, recorder: Recorder, pacer: Pacer, rehearse: Callable[[], None] | None) -> None:
        tick = self.put_together(recorder)
        values = self.parts.vector.values
        lateness, cpu_time, overruns = map(self.parts.vector.index, ("lateness", "tick_cpu_time", "overruns"))
        times = pacer.times
        timed = times.lateness_ns.size > 0
        pacer.prepare()
        if rehearse is not None:
            rehearse()
        self._connection.side.prepare()
        pacer.start()
        for n in range(self.parts.ticks):
            pacer.wait(n)
            if timed:
                values[lateness] = times.lateness_ns[n] * 1e-9
                values[cpu_time] = times.cpu_ns[n - 1] * 1e-9 if n else 0.0
                values[overruns] = times.overruns
            tick.run(n)
            pacer.done(n)
            self.ticks_done = n + 1
            if tick.finished:
                break
            if self._kill_ecu is not None and self._kill_ecu(0.0):
                self._connection.kill_ecu()
                self._kill_ecu = None
            if n % WATCH_TICKS == 0:
                self._watch()
        self._watch()

    def _watch(self) -> None:
        last_heard = max(self.parts.from_ecu.messages[:, LAST_TICK].max(), 0)
        self._connection.watch(self.ticks_done - int(last_heard))


@contextmanager
def _without_garbage_collection() -> Iterator[None]:
    """A tick leaves no cycles behind; a collection only walks through what the compiler has built, tens of ms long."""
    collected = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collected:
            gc.enable()


def timing_extras(parts: Parts) -> dict[str, Any]:
    """What the bus side adds to the verdict's timing block."""
    extras: dict[str, Any] = {
        "frames_from_ecu": parts.from_ecu.statistics(),
        "frames_unknown": parts.from_ecu.unknown_frames,
        "frames_rejected": parts.from_ecu.rejected_frames,
    }
    if parts.injector is not None:
        extras["injector"] = parts.injector.summary()
    if parts.sensor_cluster is not None:
        extras["sensor_cluster"] = parts.sensor_cluster.summary()
    return extras
