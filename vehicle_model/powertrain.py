"""Engine, clutch, gearbox and driven axles: from the accelerator to the drive torque at each wheel.

The half shafts are a torsional spring with a damper between gearbox and wheels; the clutch limits what it transmits, as
a dry friction element in series. Slipping and sticking need no switching then, and wheels and engine, which live in
different parts of the bench, couple through a torque that changes slowly compared with a tick.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from signals.errors import InputError
from signals.record_memory import addresses_at, addresses_of, numbers_address, numbers_at, record_at
from vehicle_model import parameters
from vehicle_model.interface import TIME_STEP_S
from vehicle_model.vehicle_file import VehicleFile

MOST_CURVE_POINTS = 64
MOST_GEARS = 12
# places in block "powertrain"
ENGINE_SPEED, ENGINE_TORQUE, DRIVE_TORQUE = 0, 1, 2
OUTPUTS = 6

AT_PARAMETERS, AT_STATE, AT_WHEEL_SPEED, AT_OUT = range(4)
"""Places in the list of addresses: two records, then arrays of float64."""

PARAMETER_RECORD = np.dtype(
    [
        ("points", "i8"),
        ("curve_speed", "f8", (MOST_CURVE_POINTS,)),
        ("curve_torque", "f8", (MOST_CURVE_POINTS,)),
        ("drag_torque", "f8"),
        ("idle_speed", "f8"),
        ("idle_gain", "f8"),
        ("maximum_speed", "f8"),
        ("limiter_band", "f8"),
        ("inertia", "f8"),
        ("decay", "f8"),  # of the torque build-up in a tick
        ("gears", "i8"),
        ("ratio", "f8", (MOST_GEARS + 1,)),  # total, gear 0 is neutral
        ("efficiency", "f8"),
        ("clutch_torque", "f8"),
        ("stiffness", "f8"),
        ("damping", "f8"),
        ("wheel_share", "f8", (4,)),
    ]
)
STATE_RECORD = np.dtype([("running", "i8"), ("engine_speed", "f8"), ("fuel_torque", "f8"), ("twist", "f8")])


@njit(cache=True)
def full_load_torque(p: Any, engine_speed: float) -> float:
    """Torque of the curve [N m], held outside its points."""
    last = p.points - 1
    if engine_speed <= p.curve_speed[0]:
        return p.curve_torque[0]
    for k in range(1, p.points):
        if engine_speed < p.curve_speed[k]:
            share = (engine_speed - p.curve_speed[k - 1]) / (p.curve_speed[k] - p.curve_speed[k - 1])
            return p.curve_torque[k - 1] + share * (p.curve_torque[k] - p.curve_torque[k - 1])
    return p.curve_torque[last]


@njit(cache=True)
def _engine_torque(p: Any, s: Any, accelerator: float) -> float:
    """Net torque of the engine [N m]; the torque build-up lags, limiter and idle control act at once."""
    speed = s.engine_speed
    wanted = accelerator * full_load_torque(p, speed)
    s.fuel_torque += (wanted - s.fuel_torque) * p.decay
    drag = (1.0 - accelerator) * p.drag_torque * min(speed / p.idle_speed, 1.0)
    over = (p.maximum_speed - speed) / p.limiter_band
    fuel = s.fuel_torque * min(max(over, 0.0), 1.0)
    idle = max(p.drag_torque + p.idle_gain * (p.idle_speed - speed) - fuel, 0.0)
    return fuel + min(idle, 0.5 * p.curve_torque[0] + p.drag_torque) - drag


@njit(cache=True)
def powertrain_step(memory: int, accelerator: float, clutch: float, gear: float) -> None:
    """Advance by 1 ms; see `Powertrain.tick`. ``memory`` is the address of the list of addresses ``AT_…``."""
    places: Any = addresses_at(memory)
    p = record_at(places[AT_PARAMETERS], PARAMETER_RECORD)
    s = record_at(places[AT_STATE], STATE_RECORD)
    wheel_speed, out = numbers_at(places[AT_WHEEL_SPEED]), numbers_at(places[AT_OUT])
    number = min(max(int(gear), 0), p.gears)
    ratio = p.ratio[number]
    output_speed = 0.0
    for i in range(4):
        output_speed += p.wheel_share[i] * wheel_speed[i]
    if s.running == 0:
        s.running = 1
        engaged = number > 0 and clutch > 0.5
        s.engine_speed = max(p.idle_speed, ratio * output_speed) if engaged else p.idle_speed
    torque = _engine_torque(p, s, min(max(accelerator, 0.0), 1.0))

    shaft = shaft_slope = 0.0
    capacity = min(max(clutch, 0.0), 1.0) * p.clutch_torque * ratio
    if capacity > 0.0:
        twist_rate = s.engine_speed / ratio - output_speed
        damped = p.damping * twist_rate
        shaft = p.stiffness * (s.twist + TIME_STEP_S * twist_rate) + damped
        driving = capacity * p.efficiency
        dragging = -capacity / p.efficiency
        shaft_slope = p.damping + p.stiffness * TIME_STEP_S
        if shaft > driving or shaft < dragging:
            shaft = driving if shaft > driving else dragging
            shaft_slope = 0.0
            damped = min(max(damped, dragging), driving)
        s.twist = (shaft - damped) / p.stiffness
    else:
        s.twist = 0.0
    at_engine = 0.0
    if number > 0:
        at_engine = shaft / (ratio * p.efficiency) if shaft > 0.0 else shaft * p.efficiency / ratio
        shaft_slope /= ratio * ratio
    # linearly implicit in the shaft's slope, so that a light engine on a stiff shaft stays stable
    s.engine_speed += TIME_STEP_S * (torque - at_engine) / (p.inertia + TIME_STEP_S * shaft_slope)
    if s.engine_speed < 0.0:
        s.engine_speed = 0.0
    out[ENGINE_SPEED] = s.engine_speed
    out[ENGINE_TORQUE] = torque
    for i in range(4):
        out[DRIVE_TORQUE + i] = p.wheel_share[i] * shaft


class Powertrain:
    """Powertrain of a car with open differentials.

    Parameters
    ----------
    vehicle : VehicleFile
        Its section ``driveline`` is copied; later changes go through ``set``.

    Raises
    ------
    InputError
        If the torque curve has more points or the gearbox more gears than the model holds.

    Attributes
    ----------
    address : int
        Of the memory that `powertrain_step` works on, for compiled callers.
    """

    def __init__(self, vehicle: VehicleFile) -> None:
        self._driveline = vehicle.driveline.model_copy(deep=True)
        if len(self._driveline.engine.speed_points) > MOST_CURVE_POINTS:
            raise InputError("driveline.engine.speed_points: too many", allowed=f"at most {MOST_CURVE_POINTS}")
        if len(self._driveline.gear_ratios) > MOST_GEARS:
            raise InputError("driveline.gear_ratios: too many", allowed=f"at most {MOST_GEARS}")
        self._parameters: NDArray[np.void] = np.zeros(1, PARAMETER_RECORD)
        self._state: NDArray[np.void] = np.zeros(1, STATE_RECORD)
        self._wheel_speed, self._out = np.zeros(4), np.zeros(OUTPUTS)
        self._addresses = addresses_of(self._parameters, self._state, self._wheel_speed, self._out)
        self.address = int(self._addresses.ctypes.data)
        self._fill()

    def reset(self) -> None:
        """Engine idling, or turning with the wheels if the first tick finds the clutch closed."""
        self._state[:] = np.zeros(1, STATE_RECORD)

    def tick(
        self,
        accelerator: float,
        clutch: float,
        gear: float,
        wheel_speed: NDArray[np.float64],
        out: NDArray[np.float64],
    ) -> None:
        """Advance by 1 ms.

        Parameters
        ----------
        accelerator, clutch
            Pedal 0 to 1; engagement of the clutch, 0 open to 1 closed.
        gear
            0 is neutral.
        wheel_speed : shape (4,), rad/s
            Speeds of the wheels after the last tick.
        out : shape (6,)
            Block "powertrain" of the signal catalogue.
        """
        if wheel_speed is not self._wheel_speed or out is not self._out:
            self.bind(wheel_speed, out)
        powertrain_step(self.address, accelerator, clutch, gear)

    def bind(self, wheel_speed: NDArray[np.float64], out: NDArray[np.float64]) -> None:
        """Use these arrays from now on: the same come tick by tick, so their addresses are kept."""
        self._addresses[AT_WHEEL_SPEED] = numbers_address(wheel_speed, 4)
        self._addresses[AT_OUT] = numbers_address(out, OUTPUTS)
        self._wheel_speed, self._out = wheel_speed, out

    def names(self) -> tuple[str, ...]:
        """Dotted paths of all parameters (``driveline.engine.inertia``)."""
        return tuple(parameters.numbers(self._driveline, "driveline."))

    def get(self, path: str) -> float:
        """Value of one parameter, SI; InputError if there is none of that path."""
        return parameters.get_parameter(self._driveline, path, "driveline.")

    def set(self, path: str, value: float) -> None:
        """Change one parameter from the next tick on; InputError if there is none or the value is out of range."""
        parameters.set_parameter(self._driveline, path, value, "driveline.")
        self._fill()

    def _fill(self) -> None:
        line, row = self._driveline, self._parameters[0]
        engine = line.engine
        count = len(engine.speed_points)
        row["points"] = count
        row["curve_speed"][:count] = engine.speed_points
        row["curve_torque"][:count] = engine.torque_points
        for name in ("drag_torque", "idle_speed", "idle_gain", "maximum_speed", "limiter_band", "inertia"):
            row[name] = getattr(engine, name)
        row["decay"] = -np.expm1(-TIME_STEP_S / engine.time_constant)
        row["gears"] = len(line.gear_ratios)
        row["ratio"][1 : len(line.gear_ratios) + 1] = np.multiply(line.gear_ratios, line.final_drive)
        row["efficiency"], row["clutch_torque"] = line.efficiency, line.clutch_torque
        row["stiffness"], row["damping"] = line.shaft_stiffness, line.shaft_damping
        row["wheel_share"] = line.wheel_share()
