"""Scenario files: everything a run needs to know, from the car to the verdict.

docs/scenario_reference.md is generated from these models.
"""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from bench.codec.mapping_file import Protection
from bench.scenario.cluster_choice import SensorClusterChoice
from bench.scenario.stimulus_file import StimulusEntry
from bench.scenario.variants import Variants
from bench.verdict.criteria_file import Criterion, ValidIfList
from can_fault_injector.faults.fault_file import Fault, name_faults
from signals.conditions import Condition
from signals.errors import FieldError
from signals.quantities import FileModel, parameter
from vehicle_model.manoeuvre_file import ManoeuvreFile
from vehicle_model.road_file import RoadFile
from vehicle_model.sensors_file import AccelerationSource

EcuKind = Literal["emulated", "inprocess", "external", "none"]


class Ecu(FileModel):
    """The ABS control unit and the way to it."""

    kind: EcuKind = Field(
        default="emulated",
        description="emulated: `bench ecu` as a process of its own; inprocess: the same controller without a process; "
        "external: somebody else runs it (a real ECU); none: nobody answers, the valves stay as they are",
    )
    link: str | None = Field(
        default=None,
        description="virtual, udp[:GROUP:PORT], socketcan:vcan0[,vcan1], slcan:/dev/ttyUSB0@500000 or IFACE:CHANNEL; "
        "without it the best that the machine has",
    )
    dbc: str | None = Field(
        default=None, description="CAN database, path relative to this file; without it brake_bus.dbc"
    )
    mapping: str | None = Field(
        default=None, description="mapping file for an ECU's own database, path relative to this file"
    )
    calibration: str = Field(
        default="sensitive", description="of the emulated ECU: sensitive, coarse or the path of a file"
    )
    protection: Protection = Field(
        default="full",
        description="what ECU and bench check of protected frames; full: CRC, alive counter and timeouts; crc: the CRC "
        "alone; none: nothing",
    )
    expect: Literal["alive", "silent", "lost"] = Field(
        default="alive",
        description="alive: an ECU that does not answer or falls silent is an error; silent: it never answers; "
        "lost: it may fall silent during the run",
    )
    kill: Condition | None = Field(default=None, description="the emulated ECU's process is killed when this holds")
    first_answer: float = parameter(
        "s", 5.0, low=0.1, high=600.0, description="wall-clock time within which the ECU has to answer"
    )
    longest_silence: float = parameter(
        "s",
        1.0,
        low=0.1,
        high=600.0,
        description="an ECU that is expected alive has fallen silent after this time without a good frame; one that "
        "restarts during a run needs more",
    )

    @model_validator(mode="after")
    def _killed(self) -> "Ecu":
        if self.kill is not None and self.kind not in ("emulated", "inprocess"):
            raise FieldError("only the emulated ECU can be killed", at=("kill",), allowed="kind: emulated beside it")
        if self.kill is not None and self.expect == "alive":
            raise FieldError(
                "a killed ECU does not stay alive", at=("kill",), allowed="expect: lost or silent beside it"
            )
        return self


class HydraulicUnitChoice(FileModel):
    """Which hydraulic unit stands between the driver and the wheel brakes; its numbers are the vehicle file's."""

    brake: Literal["hcu", "first_order"] = Field(
        default="hcu",
        description="hcu: hydraulic control unit of 2.6; first_order: the brake of eq. 79 with its delay, no ABS",
    )
    selection_logic: Literal["abs", "esp"] = Field(
        default="abs", description="how valve states become increase, hold, decrease"
    )


class PlantOptions(FileModel):
    """Numerics of the plant."""

    wheel_substeps: int = Field(default=5, ge=1, le=100, description="steps of the wheels' rotation in a tick of 1 ms")


class Recording(FileModel):
    """What a run leaves behind beside verdict, report and resolved scenario."""

    mf4: bool = Field(default=True, description="signals.mf4, made when the run has ended")
    blf: bool = Field(default=True, description="frames.blf with every frame, direction and channel")
    asc: bool = Field(default=False, description="frames.asc beside it")
    signals: list[str] = Field(
        default=["*"], min_length=1, description="names or patterns (brake_pressure_*) of the signals in signals.mf4"
    )


def _settings(value: Any) -> Any:
    if value is None:
        return {}
    if isinstance(value, list):
        return {name: {} for name in value if isinstance(name, str)}
    if isinstance(value, dict):
        return {name: {} if settings is None else settings for name, settings in value.items()}
    return value


def _or_name(schema: dict[str, Any]) -> None:
    """Lets the editors' schema accept a name or a path in place of the object."""
    inner = dict(schema)
    schema.clear()
    schema["anyOf"] = [inner, {"type": "string"}]


Estimators = Annotated[dict[str, dict[str, Any]], BeforeValidator(_settings, json_schema_input_type=Any)]


class ScenarioFile(FileModel):
    """A run: car, road, manoeuvre, ECU, what is changed on the way, what is recorded and what is demanded."""

    format: Literal[1] = Field(default=1, description="version of this format")
    id: str = Field(default="", description="name in reports; by default the path below scenarios/ without .yaml")
    title: str = Field(default="", description="one line for `bench list`")
    description: str = Field(default="", description="what the run shows and where its numbers come from")
    standard: str = Field(default="", description="standard, clause or source that the scenario stands for")
    include: list[str] = Field(
        default=[],
        description="files that this one is laid over, paths relative to it; later ones win, this file wins over all",
    )
    vehicle: str = Field(default="ekf_car", description="name of a shipped car or path of a vehicle file")
    plant: Literal["mujoco", "single_track", "planar", "two_track", "steered_track"] = Field(
        default="mujoco",
        description="mujoco: the 16-DOF car; single_track: the longitudinal twin of the friction document; planar: the "
        "planar car of the vehicle-state document, in steps of 0.1 ms; two_track: the car with a roll axis of the "
        "vertical-load document; steered_track: the four-state car of the force document",
    )
    plant_options: PlantOptions = Field(default_factory=PlantOptions, description="numerics of the plant")
    tyres: str | None = Field(
        default=None, description="tyre file in place of the vehicle's: name of a shipped one or a path"
    )
    overrides: dict[str, float | str] = Field(
        default={},
        description="parameters of car and road by dotted path, e.g. brakes.front.pad_friction, road.friction",
    )
    sensors: dict[str, Any] = Field(
        default={}, description="sensor errors, laid over the section of the same name in the vehicle file"
    )
    sensor_cluster: SensorClusterChoice = Field(
        default_factory=SensorClusterChoice, description="what stands between the inertial sensors and their frames"
    )
    acceleration_source: AccelerationSource | None = Field(
        default=None,
        description="where longitudinal_acceleration comes from, in place of the vehicle's: cluster_can, the sensor "
        "cluster with its errors; noisy; noise_free; ideal, no sensor",
    )
    road: Annotated[RoadFile, Field(json_schema_extra=_or_name)] = Field(
        default_factory=RoadFile, description="name of a shipped road, path of a road file, or the road itself"
    )
    initial_speed: float = parameter("m/s", 0.0, low=0.0, high=120.0, description="at the start of the run")
    initial_gear: int | None = Field(
        default=None, ge=0, le=12, description="gear at the start; without it what suits the speed"
    )
    manoeuvre: ManoeuvreFile = Field(description="what the driver does, step by step")
    hydraulic_unit: HydraulicUnitChoice = Field(default_factory=HydraulicUnitChoice, description="hydraulic unit")
    ecu: Ecu = Field(default_factory=Ecu, description="the control unit under test and the link to it")
    stimuli: list[StimulusEntry] = Field(
        default=[], description="changes of parameters and signals while the run goes on"
    )
    faults: Annotated[list[Fault], Field(json_schema_extra=_or_name)] = Field(
        default=[], description="faults on the bus between bench and ECU, or the path of a fault file"
    )
    estimators: Estimators = Field(
        default={},
        description="estimators to run and their settings; a second one of a kind is called NAME_ANYTHING, "
        "e.g. friction_ekf_printed_sign",
    )
    recording: Recording = Field(default_factory=Recording, description="files of the run")
    criteria: list[Criterion] = Field(default=[], description="what the run has to show")
    valid_if: ValidIfList = Field(default=[], description="conditions without which every criterion is inconclusive")
    pacing: Literal["realtime", "lockstep"] = Field(
        default="realtime", description="realtime: by the wall clock; lockstep: virtual time, reproducible bit for bit"
    )
    time_limit: float = parameter(
        "s", 60.0, low=0.001, high=36000.0, description="the run ends here if the manoeuvre has not ended before"
    )
    seed: int = Field(default=1, ge=0, le=2**32 - 1, description="of every random number of the run")
    variants: Variants | None = Field(default=None, description="further runs of this scenario with other values")

    @model_validator(mode="after")
    def _unique(self) -> "ScenarioFile":
        seen: set[str] = set()
        for number, stimulus in enumerate(self.stimuli):
            if stimulus.name and stimulus.name in seen:
                raise FieldError("two stimuli of one name", at=("stimuli", number, "name"))
            seen.add(stimulus.name)
        name_faults(self.faults)
        return self
