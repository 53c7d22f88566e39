"""Replay of one wheel on a rig: measured slips, load and speed drive the vehicle file's tyre, the forces are compared.

replay = RigReplay(load_vehicle("student_car.yaml"), manoeuvres)
theta = np.zeros(len(replay.columns))
replay.residuals(theta)[0]        # (n, c) forces measured minus predicted of the first manoeuvre [N]
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.rig import AXLES, rig_effects
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.replay.base import STEP_SHARE, ReplayBase
from model_diagnosis.replay.columns import Columns
from model_diagnosis.replay.nominal import nominal_car
from model_diagnosis.replay.parameters import values_of
from model_diagnosis.replay.rig_log import RigLog, read_rig
from model_diagnosis.replay.rig_run import ANGLE, LOAD, RATIO, SPEED, rig_run
from model_diagnosis.replay.state import STATE_RECORD
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]

_SENSING = (
    "form_rig_forces.rolling",
    "form_rig_forces.offset_along",
    "form_rig_forces.offset_across",
    "form_rig_forces.lag",
    "form_rig_slips.angle",
    "form_rig_slips.ratio",
)
"""Columns of the rig's own sensors, in the order of the compiled run."""

_LOAD_STEP_N = 10.0
"""Loads at which tyres are sampled are whole multiples of it: search and held-out data then ask for the same tables."""


class RigReplay(ReplayBase):
    """The tyre of one wheel on a rig, driven by its measured slips, load and speed.

    What drives it is measured at each sample and the tyre forgets what was before within a few relaxation lengths, so
    that there is no observer: the free run is the prediction.

    Parameters
    ----------
    vehicle : VehicleFile
        Whose tyre the rig's should be.
    manoeuvres : sequence of Manoeuvre
        Each of one wheel, its channels as ``read_rig`` asks for them.
    threads : int, optional
        For sweeps; the machine's processors if left out.

    Raises
    ------
    InputError
        If a manoeuvre is not of a wheel on a rig, or lacks load or speed.
    """

    def __init__(self, vehicle: VehicleFile, manoeuvres: Sequence[Manoeuvre], *, threads: int | None = None) -> None:
        straight = [one.on_one_raster() for one in manoeuvres]
        logs = [read_rig(one) for one in straight]
        axles = {AXLES[log.wheel // 2] for log in logs}
        columns = Columns.of(rig_effects(axles), values_of(vehicle), vehicle.scatter)
        # a rig loads a tyre as no car of its size does, and the short form is nearest where it was sampled
        load = float(np.median(np.concatenate([log.driving[:, LOAD] for log in logs])))
        load = max(round(load / _LOAD_STEP_N), 1) * _LOAD_STEP_N
        super().__init__(vehicle, straight, columns, nominal_car(vehicle, load), threads)
        self.prepared: Sequence[RigLog] = logs

    @property
    def forces_measured(self) -> bool:
        """True: the slips that drive a rig's wheel are measured, and its forces are what is compared."""
        return True

    @property
    def torque_measured(self) -> bool:
        """False: a rig sets the wheel's slip and needs no torque."""
        return False

    def predict(self, theta: FloatArray, m: int) -> FloatArray:
        """Forces (n, c) [N], as the rig's sensors report them."""
        return self._forces(self.deviations_at(theta, m), self.prepared[m])

    def free_run(self, theta: FloatArray, m: int, horizon_s: float | None = None) -> FloatArray:
        """The prediction: there is no state that was measured and could be drawn to it, or begun anew."""
        return self.predict(theta, m)

    def states(self, theta: FloatArray, m: int) -> dict[str, FloatArray]:
        """What drives the wheel, name -> (n,)."""
        log = self.prepared[m]
        wheel = WHEELS[log.wheel]
        names = {f"slip_ratio_{wheel}": RATIO, f"slip_angle_{wheel}": ANGLE, f"vertical_load_{wheel}": LOAD}
        return {name: log.driving[:, column] for name, column in {"speed": SPEED, **names}.items()}

    def corrections(self, m: int) -> FloatArray:
        """(c, 0): nothing is corrected."""
        return np.zeros((len(self.prepared[m].signals), 0))

    def sensitivities(self, theta: FloatArray, columns: Sequence[int] | None = None) -> list[FloatArray]:
        """Derivatives of the prediction by the deviations, (n, c, len(columns)) of each manoeuvre.

        Finite differences of one side, towards the inside of the bounds.
        """
        chosen = list(range(len(self.columns))) if columns is None else [int(column) for column in columns]
        at = np.asarray(theta, dtype=np.float64)

        def of(m: int) -> FloatArray:
            base = self.predict(at, m)
            slopes = np.empty((*base.shape, len(chosen)))
            for place, column in enumerate(chosen):
                step = self._step_of(at, column)
                moved = at.copy()
                moved[column] += step
                slopes[:, :, place] = (self.predict(moved, m) - base) / step
            return slopes

        return list(self.mapped(of, range(len(self.prepared))))

    def _step_of(self, theta: FloatArray, column: int) -> float:
        parameter = self.parameters[column]
        step = STEP_SHARE * parameter.effect_std
        return step if theta[column] + step <= parameter.high else -step

    def _forces(self, deviations: Mapping[str, float], log: RigLog) -> FloatArray:
        sensing = np.array([deviations.get(column, 0.0) for column in _SENSING])
        out = np.empty((len(log.driving), 2))
        cars, tables = self._record_at(deviations), self.tables_at(deviations)
        rig_run(cars, np.zeros(1, STATE_RECORD), tables, log.wheel, log.driving, sensing, SAMPLE_TIME_S, out)
        return out[:, log.chosen]
