"""What a replay keeps of each manoeuvre: signals to compare, weights, inputs, what the observer corrects on."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.sensor_chain import ACCELERATION_COLUMNS, PRESSURE_COLUMNS, ring_carriers
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay.deviations import RECORD_COLUMNS
from model_diagnosis.replay.gaps import BEGINNING, ends_of_gaps, is_beginning, least_gains
from model_diagnosis.replay.hydraulic import HydraulicLog, read_hydraulics
from model_diagnosis.replay.inputs import SLOWEST_M_S, Inputs, read_inputs, reference_speed, start_of, turning
from model_diagnosis.replay.phases import Phases, phases_of
from model_diagnosis.replay.record import CORRECTED, OUTPUTS
from model_diagnosis.replay.smoothing import pressure_without_noise, torque_without_noise_at_rest
from model_diagnosis.replay.state import SUBSTEPS
from signals.errors import InputError
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]

PRESSURES = tuple(f"brake_pressure_{wheel}" for wheel in WHEELS)
_DRIVE_TORQUES = ("drive_torque_f", "drive_torque_r")

COMPARED = (
    *(f"wheel_speed_{wheel}" for wheel in WHEELS),
    "longitudinal_acceleration",
    "lateral_acceleration",
    "yaw_rate",
    "speed",
    "lateral_speed",
    "side_slip_angle",
    "roll_rate",
    "pitch_rate",
    "roll_angle",
    "pitch_angle",
    *(f"vertical_load_{wheel}" for wheel in WHEELS),
    *(f"longitudinal_force_{wheel}" for wheel in WHEELS),
    *(f"lateral_force_{wheel}" for wheel in WHEELS),
    *(f"suspension_travel_{wheel}" for wheel in WHEELS),
)
"""Signals that the car in motion can be compared on, where they were measured."""

YAW = CORRECTED.index("yaw_rate")

_LONGITUDINAL = ("longitudinal_acceleration", "speed")
_OF_THE_BODY = ("roll_rate", "pitch_rate", "roll_angle", "pitch_angle")
SETTLING_BODY = 80
"""Samples after which a body has forgotten how it swung when the log began: about a period of its pitch."""

_LATERAL = ("lateral_acceleration", "yaw_rate", "lateral_speed", "side_slip_angle", "roll_rate", "roll_angle")


@dataclass(frozen=True)
class Prepared:
    """What stays the same of one manoeuvre for every theta.

    Attributes
    ----------
    number : of the manoeuvre in its replay
    signals : compared signals, the columns of the arrays below
    chosen : outputs of the compiled run, in the order of the first signals; pressures follow them
    measured, weights : (n, c)
    corrected, valid : (n, 6) signals of ``CORRECTED`` and 1 where they hold
    start : (6,) speed, yaw rate and spins of the wheels at the first sample
    driving : channels as they drive the replay: pressures without their sensors' noise
    hydraulics : None where the log tells nothing of them
    pressure_known, pressure_valid : True where all wheel pressures were measured; (n, 4) 1 where they hold
    leads : by how much the brakes' pressures lead their readings (n,), per lag of the sensors [Pa/s]; where it is not
        told by the hydraulic unit a wheel is missing
    between : (n, SUBSTEPS, 4) wheel pressures beside the straight lines between samples [Pa]
    carriers : (n, 4) phases of the tone rings; None without wheel speeds
    least, pressure_least : (n, 6), (n, 4) least gains of the observer, where it begins anew behind a gap of the inputs
    phases : when within a sample each signal was taken
    """

    number: int
    manoeuvre: Manoeuvre
    signals: tuple[str, ...]
    chosen: NDArray[np.int64]
    measured: FloatArray
    weights: FloatArray
    corrected: FloatArray
    valid: FloatArray
    start: FloatArray
    driving: Mapping[str, FloatArray]
    inputs: Inputs
    hydraulics: HydraulicLog | None
    pressure_known: bool
    pressure_valid: FloatArray
    leads: Mapping[str, FloatArray]
    between: FloatArray
    carriers: FloatArray | None
    least: FloatArray
    pressure_least: FloatArray
    phases: Phases

    @property
    def replays_pressures(self) -> bool:
        """True where the wheel pressures are compared with the hydraulic unit's."""
        return PRESSURES[0] in self.signals

    @property
    def replays_master(self) -> bool:
        """True where the master pressure is compared with the booster's."""
        return "master_pressure" in self.signals

    def drives(self, column: str) -> bool:
        """True if a deviation changes what drives the replay: of a sensor, or of the car where inputs are inferred."""
        return column in self.driving_columns

    @cached_property
    def driving_columns(self) -> frozenset[str]:
        """Columns that ``drives`` is true of."""
        inferred = (*ACCELERATION_COLUMNS, *RECORD_COLUMNS) if self.inputs.inferred.any() else ()
        return frozenset((*PRESSURE_COLUMNS, *inferred))

    def corrected_at(self, deviations: Mapping[str, float]) -> FloatArray:
        """Signals that the observer corrects on, freed of what the sensors' effects put on them."""
        offset = deviations.get("gyro_offset.yaw_rate", 0.0)
        scale = deviations.get("gyro_scale.yaw_rate", 0.0)
        rings = [deviations.get(f"tone_ring_error.{wheel}", 0.0) for wheel in WHEELS]
        if offset == 0.0 and scale == 0.0 and not any(rings):
            return self.corrected
        values = self.corrected.copy()
        values[:, 5] = (values[:, 5] - offset) / (1.0 + scale)
        if self.carriers is not None:
            values[:, :4] /= 1.0 + np.array(rings) * self.carriers
        return values


def prepare(manoeuvre: Manoeuvre, vehicle: VehicleFile, car: np.void, number: int = 0) -> Prepared:
    """Prepare a manoeuvre; ``car`` (``REPLAY_RECORD``) is the vehicle's without deviations.

    Raises
    ------
    InputError
        If it has neither all wheel speeds nor a speed.
    """
    channels = manoeuvre.channels
    wheels = [f"wheel_speed_{wheel}" for wheel in WHEELS]
    ringed = all(name in channels for name in wheels)
    if "speed" not in channels and not ringed:
        raise InputError(
            f"{manoeuvre.source}: no speed",
            found=", ".join(sorted(channels)) or "no channels",
            allowed="all four wheel speeds, or speed",
            mend="map them in the channel map",
        )
    driving = dict(channels)
    driving |= {n: pressure_without_noise(channels[n]) for n in (*PRESSURES, "master_pressure") if n in channels}
    driving |= {n: torque_without_noise_at_rest(channels[n]) for n in _DRIVE_TORQUES if n in channels}
    inputs = read_inputs(manoeuvre, driving, vehicle, car)
    moving = tuple(name for name in COMPARED if name in channels and manoeuvre.weight(name).any())
    phases = phases_of(manoeuvre, moving)
    hydraulics = read_hydraulics(manoeuvre, phases)
    known = all(name in channels for name in PRESSURES)
    signals = moving + _pressure_signals(hydraulics, known)
    corrected = np.zeros((manoeuvre.samples, len(CORRECTED)))
    valid = np.zeros_like(corrected)
    for k, name in enumerate(CORRECTED):
        if name in channels:
            corrected[:, k], valid[:, k] = channels[name], manoeuvre.weight(name) > 0.0
    turn = turning(manoeuvre, vehicle)
    if "yaw_rate" not in channels and not inputs.steered and turn is not None:
        corrected[:, YAW], valid[:, YAW] = turn, 1.0
    pressure_valid = np.stack([known * (manoeuvre.weight(name) > 0.0) for name in PRESSURES], axis=1).astype(np.float64)
    anew = ends_of_gaps(manoeuvre)
    return Prepared(
        number=number,
        manoeuvre=manoeuvre,
        signals=signals,
        chosen=np.array([OUTPUTS.index(name) for name in moving], dtype=np.int64),
        measured=np.stack([channels[name] for name in signals], axis=1) if signals else np.zeros((len(corrected), 0)),
        weights=_weights(manoeuvre, signals, inputs, vehicle),
        corrected=corrected,
        valid=valid,
        start=start_of(manoeuvre, vehicle),
        driving=driving,
        inputs=inputs,
        hydraulics=hydraulics,
        pressure_known=known,
        pressure_valid=pressure_valid,
        leads={},
        between=np.zeros((manoeuvre.samples, SUBSTEPS, len(WHEELS))),
        carriers=ring_carriers(manoeuvre.time, corrected[:, :4]) if ringed else None,
        least=least_gains(valid, anew),
        pressure_least=least_gains(pressure_valid, anew),
        phases=phases,
    )


def _pressure_signals(hydraulics: HydraulicLog | None, known: bool) -> tuple[str, ...]:
    """Pressures that can be compared: those of the wheels with valve commands, the master's with the pedal's force."""
    if hydraulics is None:
        return ()
    wheels = PRESSURES if known and hydraulics.commanded else ()
    master = hydraulics.master is not None and hydraulics.pedal is not None
    return wheels + (("master_pressure",) if master else ())


def _weights(manoeuvre: Manoeuvre, signals: tuple[str, ...], inputs: Inputs, vehicle: VehicleFile) -> FloatArray:
    moving = reference_speed(manoeuvre, vehicle) >= SLOWEST_M_S
    counts = moving & ~is_beginning(manoeuvre.samples, ends_of_gaps(manoeuvre))
    weights = np.zeros((manoeuvre.samples, len(signals)))
    for k, name in enumerate(signals):
        weights[:, k] = manoeuvre.weight(name) * counts
        weights[: SETTLING_BODY if name in _OF_THE_BODY else BEGINNING, k] = 0.0
        if manoeuvre.phases.get(name, 0.0) > 0.0:
            weights[-1:, k] = 0.0  # taken behind the last instant of the inputs
        if name in _LONGITUDINAL:
            weights[inputs.inferred | inputs.forced, k] = 0.0
        if name.startswith("wheel_speed_"):
            weights[inputs.forced, k] = 0.0
        if name in _LATERAL and not inputs.steered:
            weights[:, k] = 0.0
    return weights
