"""Runs a manoeuvre: tells the driver what to do in each step and goes on to the next when its condition holds."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from signals.catalogue import block_slice
from signals.conditions import Holds
from signals.errors import InputError, unknown_name
from signals.record_memory import addresses_of
from signals.vector import SignalVector
from vehicle_model import driver_record as record
from vehicle_model.driver import AT_TABLE, TABLE_COLUMNS, driver_step, gear_for_speed
from vehicle_model.interface import TIME_STEP_S
from vehicle_model.manoeuvre_file import (
    Accelerate,
    Brake,
    HoldSpeed,
    ManoeuvreFile,
    MasterPressureBrake,
    Steer,
    SteeringProfile,
    Step,
)
from vehicle_model.tyres.tyre_file import TirTyre
from vehicle_model.vehicle_file import STANDARD_GRAVITY, VehicleFile

BOOSTER = {
    "brakes.booster_gain": 1e6,
    "brakes.booster_knee_pressure": 4e7,
    "brakes.booster_slope_loss": 1.0,
}
"""Parameters that the driver owns, with their largest values; the smallest is 0."""
_FEET = {
    "release": record.RELEASE,
    "accelerate": record.ACCELERATE,
    "hold_speed": record.HOLD_SPEED,
    "coast": record.COAST,
    "brake": record.BRAKE,
}
_FOLLOWED = {"straight": record.STRAIGHT, "circle": record.CIRCLE, "path": record.PATH}
_AUTO = -1
_USUAL = Accelerate()
_SHIFT_SHARE = 0.92  # of the engine's largest speed
_USUAL_CORNERING_SLOPE = 18.0  # 1/rad, a passenger car tyre


class Manoeuvre:
    """The driver and the manoeuvre that he drives.

    Parameters
    ----------
    file : ManoeuvreFile
    vector : SignalVector
        Signals of the run; block "driver" and ``manoeuvre_phase`` are written, the plant's and the engine's read.
    vehicle : VehicleFile
        The car that the driver knows.
    initial_gear : int, optional
        Gear at the start of the run; without it the first step's, or the one that suits the speed.

    Raises
    ------
    InputError
        If the car has more gears than the driver can count, or a step wants a gear that it lacks.
    FieldErrors
        If a condition names a signal or a phase that the run does not have.

    Attributes
    ----------
    address : int
        Of the memory that `driver.driver_step` works on, for compiled callers.
    """

    def __init__(
        self, file: ManoeuvreFile, vector: SignalVector, vehicle: VehicleFile, *, initial_gear: int | None = None
    ) -> None:
        self.phase_names: tuple[str, ...] = file.phase_names
        self.finished = False
        self._steps = file.steps
        self._vector = vector
        self._values = vector.values
        self._vehicle = vehicle
        self._command: NDArray[np.void] = np.zeros(1, record.COMMAND_RECORD)
        self._state: NDArray[np.void] = np.zeros(1, record.STATE_RECORD)
        self._addresses = np.zeros(TABLE_COLUMNS + 1, np.int64)
        self._addresses[:AT_TABLE] = addresses_of(self._command, self._state, self._values)
        self.address = int(self._addresses.ctypes.data)
        self._use_table(np.zeros((2, 1)))
        self._command[0]["initial_gear"] = _AUTO if initial_gear is None else initial_gear
        self._fill_places()
        self._fill_car()
        self._check_gears(initial_gear)
        self.reset()

    def reset(self) -> None:
        """Back to the first step, which begins with the next tick."""
        self.finished = False
        self._state[:] = np.zeros(1, record.STATE_RECORD)
        # compiled anew: a condition with `lasting` remembers
        self._until: list[Holds | None] = [
            None if step.until is None else step.until.compile(self._vector, self.phase_names) for step in self._steps
        ]
        self._number = -1
        self._ends: Holds | None = None
        self._began_s = 0.0

    def tick(self, time_s: float) -> None:
        """Advance by 1 ms: go on to the next step if it is time, then let the driver act.

        Parameters
        ----------
        time_s
            Time of the run at the start of the tick, as in the vector.
        """
        self.decide(time_s)
        driver_step(self.address, time_s)

    def decide(self, time_s: float) -> None:
        """The first half of a tick: go on to the next step if it is time. The driver has not acted yet."""
        if self._number < 0:
            self._begin_step(0, time_s)
        elif self._ends is not None and self._ends(self._began_s):
            if self._number + 1 < len(self._steps):
                self._begin_step(self._number + 1, time_s)
            else:
                self.finished = True
                self._ends = None

    @property
    def phase(self) -> str:
        """Name of the step that is active."""
        return self.phase_names[max(self._number, 0)]

    def names(self) -> tuple[str, ...]:
        """Dotted paths of the parameters that the driver owns."""
        return tuple(BOOSTER)

    def get(self, path: str) -> float:
        """Value of a parameter of ``names()``; InputError if there is none of that path."""
        if path not in BOOSTER:
            raise unknown_name("parameter of the driver", path, tuple(BOOSTER))
        return float(self._command[0][path.removeprefix("brakes.")])

    def set(self, path: str, value: float) -> None:
        """Change a parameter of ``names()``; InputError if there is none of that path or the value is refused."""
        self.get(path)
        if not 0.0 <= value <= BOOSTER[path]:
            raise InputError(f"{path} is out of range", found=f"{value:g}", allowed=f"0 to {BOOSTER[path]:g}")
        self._command[0][path.removeprefix("brakes.")] = value

    def _fill_places(self) -> None:
        row = self._command[0]
        for name in record.INPUT_SIGNALS:
            row[name] = self._vector.index(name)
        row["phase"] = self._vector.index("manoeuvre_phase")
        row["outputs"] = block_slice("driver").start

    def _fill_car(self) -> None:
        vehicle, row = self._vehicle, self._command[0]
        line = vehicle.driveline
        if len(line.gear_ratios) > record.MOST_GEARS:
            raise InputError("driveline.gear_ratios: too many", allowed=f"at most {record.MOST_GEARS}")
        row["wheelbase"] = vehicle.body.wheelbase
        row["understeer"] = _understeer(vehicle)
        row["steering_ratio"] = vehicle.steering.ratio
        row["radius"] = (vehicle.wheels.fl if line.drive == "front" else vehicle.wheels.rl).radius
        row["idle_speed"] = line.engine.idle_speed
        row["gears"] = len(line.gear_ratios)
        row["ratio"][1 : len(line.gear_ratios) + 1] = np.multiply(line.gear_ratios, line.final_drive)
        for path in BOOSTER:
            name = path.removeprefix("brakes.")
            row[name] = getattr(vehicle.brakes, name)

    def _check_gears(self, initial_gear: int | None) -> None:
        last = len(self._vehicle.driveline.gear_ratios)
        if initial_gear is not None and initial_gear > last:
            raise InputError("initial_gear: no such gear", found=str(initial_gear), allowed=f"up to {last}")
        for step in self._steps:
            action = step.accelerate or step.hold_speed
            wanted = [] if action is None or action.gears == "auto" else [action.gears]
            if isinstance(action, Accelerate) and action.highest_gear is not None:
                wanted.append(action.highest_gear)
            if wanted and max(wanted) > last:
                raise InputError(
                    f"manoeuvre step {step.name!r}: no such gear", found=str(max(wanted)), allowed=f"up to {last}"
                )

    def _begin_step(self, number: int, time_s: float) -> None:
        step: Step = self._steps[number]
        row = self._command[0]
        self._number, self._began_s, self._ends = number, time_s, self._until[number]
        row["phase_number"] = number
        action = step.pedal_action
        if action is not None:
            row["feet"] = _FEET[action]
            row["feet_serial"] += 1
            row["accelerator_rate"] = _USUAL.accelerator_rate
            row["shift_duration"], row["clutch_duration"] = _USUAL.shift_duration, _USUAL.clutch_duration
        if step.accelerate is not None:
            self._fill_accelerate(step.accelerate)
        if step.hold_speed is not None:
            self._fill_hold_speed(step.hold_speed)
        if step.brake is not None:
            self._fill_brake(step.brake)
        if step.steer is not None:
            row["hands_serial"] += 1
            self._fill_steer(step.steer)
        elif number == 0:
            row["hands_serial"] += 1
            self._fill_steer(Steer(angle=0.0))

    def _fill_accelerate(self, action: Accelerate) -> None:
        row, line = self._command[0], self._vehicle.driveline
        by_gear = (action.accelerator_by_gear or [action.accelerator])[: record.MOST_GEARS]
        row["accelerator"][0] = by_gear[0]
        row["accelerator"][1 : len(by_gear) + 1] = by_gear
        row["accelerator"][len(by_gear) + 1 :] = by_gear[-1]
        row["accelerator_rate"] = action.accelerator_rate
        row["gear"] = _AUTO if action.gears == "auto" else action.gears
        row["highest_gear"] = action.highest_gear or len(line.gear_ratios)
        wanted = action.shift_up_engine_speed
        row["shift_engine_speed"] = _SHIFT_SHARE * line.engine.maximum_speed if wanted is None else wanted
        row["shift_speed"][:] = 0.0
        speeds = action.shift_up_speeds[: record.MOST_GEARS]
        row["shift_speed"][1 : len(speeds) + 1] = speeds
        row["shift_duration"], row["clutch_duration"] = action.shift_duration, action.clutch_duration
        row["launch_engine_speed"] = action.launch_engine_speed

    def _fill_hold_speed(self, action: HoldSpeed) -> None:
        row = self._command[0]
        row["gear"] = _AUTO if action.gears == "auto" else action.gears
        row["speed_target"] = action.speed
        row["proportional_gain"], row["integral_gain"] = action.proportional_gain, action.integral_gain
        row["feedforward"] = self._holding_accelerator(action)

    def _holding_accelerator(self, action: HoldSpeed) -> float:
        """Accelerator that holds the speed on a level road."""
        row, vehicle = self._command[0], self._vehicle
        gear = gear_for_speed(self._command[0], action.speed) if action.gears == "auto" else action.gears
        if gear == 0:
            return 0.0
        air, engine = vehicle.aerodynamics, vehicle.driveline.engine
        wheels = (vehicle.wheels.fl, vehicle.wheels.fr, vehicle.wheels.rl, vehicle.wheels.rr)
        rolling = sum(wheel.rolling_resistance for wheel in wheels) / 4.0 * vehicle.body.mass * STANDARD_GRAVITY
        drag = 0.5 * air.air_density * air.drag_coefficient * air.frontal_area * action.speed**2
        ratio, radius = float(row["ratio"][gear]), float(row["radius"])
        torque = (rolling + drag) * radius / (ratio * vehicle.driveline.efficiency)
        full = float(np.interp(ratio * action.speed / radius, engine.speed_points, engine.torque_points))
        return min(max((torque + engine.drag_torque) / (full + engine.drag_torque), 0.0), 1.0)

    def _fill_brake(self, action: Brake) -> None:
        row = self._command[0]
        by_pressure = isinstance(action, MasterPressureBrake)
        row["brake_by_pressure"] = by_pressure
        row["brake_target"] = action.master_pressure if isinstance(action, MasterPressureBrake) else action.pedal_force
        row["brake_ramp"] = action.ramp
        row["brake_human"] = action.shape == "human"
        row["brake_declutch"] = action.clutch == "open"

    def _fill_steer(self, steer: Steer) -> None:
        row = self._command[0]
        row["rate"], row["maximum_angle"] = steer.maximum_rate, steer.maximum_angle
        row["preview"], row["path_y"] = steer.preview, steer.lateral_position
        row["countersteer_gain"] = steer.countersteer_gain if steer.countersteer else 0.0
        delay = round(steer.reaction_delay / TIME_STEP_S)
        row["reaction_ticks"] = min(delay, record.LONGEST_REACTION_TICKS - 1)
        if steer.follow is not None:
            row["hands"] = _FOLLOWED[steer.follow]
            row["path_radius"] = steer.radius or 0.0
            if steer.path is not None:
                self._use_table(np.array([steer.path.x, steer.path.y]))
        elif steer.profile is not None:
            self._fill_profile(steer.profile)
        else:
            row["hands"], row["angle"] = record.ANGLE, steer.angle or 0.0

    def _use_table(self, table: NDArray[np.float64]) -> None:
        self._table = np.ascontiguousarray(table, np.float64)
        self._addresses[AT_TABLE], self._addresses[TABLE_COLUMNS] = self._table.ctypes.data, self._table.shape[1]

    def _fill_profile(self, profile: SteeringProfile) -> None:
        row = self._command[0]
        change = profile.step or profile.ramp
        if change is not None:
            row["hands"], row["angle"], row["rate"] = record.ANGLE, change.angle, change.rate
        elif profile.table is not None:
            row["hands"] = record.TABLE
            self._use_table(np.array([profile.table.time, profile.table.angle]))
        elif profile.sine is not None:
            row["hands"] = record.SINE
            row["amplitude"], row["frequency"] = profile.sine.amplitude, profile.sine.frequency
            row["periods"] = profile.sine.periods
        elif profile.sine_with_dwell is not None:
            row["hands"] = record.SINE_WITH_DWELL
            row["amplitude"] = profile.sine_with_dwell.amplitude
            row["frequency"], row["periods"] = profile.sine_with_dwell.frequency, 1.0
            row["dwell"] = profile.sine_with_dwell.dwell


def _understeer(vehicle: VehicleFile) -> float:
    """Road-wheel angle that the car needs beyond the geometric one, per lateral acceleration [rad s^2/m].

    From the slip angles of both axles in their linear range: (F_zf/C_f - F_zr/C_r)/g, friction document 2.7.
    """
    pair = vehicle.tyre_pair
    return (1.0 / _cornering_slope(pair.front) - 1.0 / _cornering_slope(pair.rear)) / STANDARD_GRAVITY


def _cornering_slope(tyre: Any) -> float:
    """Cornering stiffness over load [1/rad] of a tyre; of a usual one where its entry does not tell it."""
    if not isinstance(tyre, TirTyre):
        return float(tyre.slopes()[1])
    return _USUAL_CORNERING_SLOPE
