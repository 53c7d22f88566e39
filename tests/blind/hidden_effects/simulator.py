"""The hidden car's simulator: one manoeuvre at 0.5 ms, compiled.

In free mode the driver's pedal and the car's own ABS make the pressures. In replay mode recorded pressures, valve
commands and master pressure drive the car and recorded speeds pull it towards them; sensitivities are taken so.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hidden_effects import brakes, chassis, controller
from hidden_effects.outputs import INDEX, OUTPUTS
from hidden_effects.tyre import steady_forces

STEP_S = 0.0005
RECORD_EVERY = 2
SLOWEST_SLIP_SPEED_M_S = 0.5
SLOWEST_RELAXATION_SPEED_M_S = 1.0
BOOSTER_LAG_S = 0.02
STEERING_LAG_S = 0.0075
DRIVING_NM = 1.0
BRAKING_N = 5.0
BEYOND_KNEE = 0.15
ACCUMULATOR_M3 = 4e-6
CONTROLLER_RADIUS_M = 0.278
TREAD_HEAT_CAPACITY_J_K = 5400.0
TREAD_COOLING_W_K = 90.0
PULL_SPEED, PULL_WHEEL, PULL_PRESSURE = 0.1, 0.3, 0.3
"""Share of a recorded difference that replay takes over each 10 ms."""

_WHEEL, _PRESSURE = INDEX["wheel_speed_fl"], INDEX["pressure_fl"]
_INLET, _OUTLET = INDEX["valve_inlet_fl"], INDEX["valve_outlet_fl"]
_LOAD, _FX, _FY = INDEX["load_fl"], INDEX["force_x_fl"], INDEX["force_y_fl"]
_TORQUE, _DISC = INDEX["brake_torque_fl"], INDEX["disc_fl"]
_KINETIC, _WORK, _DISTANCE = INDEX["kinetic_energy"], INDEX["work"], INDEX["distance"]
_MASTER, _PUMP = INDEX["master_pressure"], INDEX["pump"]
_COLUMNS = len(OUTPUTS)

FloatArray = NDArray[np.float64]

CYCLE_STEPS = round(controller.CYCLE_S / STEP_S)
CYCLE_SHIFT_S = 0.5 * controller.CYCLE_S
"""The control unit decides half a cycle after the instants at which its frames are sampled."""

MEMORY = np.dtype(
    [
        *((name, "f8", (chassis.STATES,)) for name in ("body", "rate", "last_rate")),
        *((name, "f8", (4,)) for name in ("omega", "turned", "force_x", "force_y", "load", "car_x", "car_y")),
        *((name, "f8", (4,)) for name in ("pressure", "piston", "torque", "opening_in", "opening_out")),
        *((name, "f8", (4,)) for name in ("disc", "tread", "inlet", "outlet", "rim", "rim_before", "rim_rate")),
        *((name, "i8", (4,)) for name in ("phase", "timer")),
        *((name, "f8") for name in ("reference", "master", "delta", "distance", "stop_energy", "work", "pump")),
        *((name, "f8") for name in ("aligning", "about_wheels", "spin_momentum")),
        ("volumes", "f8", (2,)),
    ]
)
"""States of the car, its brakes and its controller; made outside compiled code, which does not keep records alive."""


@dataclass(frozen=True)
class Drive:
    """What the driver does: arrays (n,) at steps of 0.5 ms, and the speed at the start [m/s].

    ``pedal`` [N], ``steering_wheel`` [rad], ``drive_torque`` of the driven rear axle [N m].
    """

    speed: float
    pedal: FloatArray
    steering_wheel: FloatArray
    drive_torque: FloatArray


def simulate(car: np.void, drive: Drive, *, stop_below: float = 2.0, recorded: FloatArray | None = None) -> FloatArray:
    """Columns ``OUTPUTS`` (n, c) at 1 ms until the car is slower than ``stop_below`` [m/s].

    ``recorded`` (n, c), an earlier result, switches to replay mode.
    """
    steps = len(drive.pedal) if recorded is None else min(len(drive.pedal), RECORD_EVERY * len(recorded))
    out = np.zeros((steps // RECORD_EVERY, _COLUMNS))
    given = np.zeros((0, _COLUMNS)) if recorded is None else recorded
    floor = stop_below if recorded is None else 0.0
    cycles = np.zeros((2, steps // CYCLE_STEPS + 2, 4))
    memory = np.zeros(1, MEMORY)
    rows = _run(
        car, memory, cycles, drive.speed, drive.pedal, drive.steering_wheel, drive.drive_torque, floor, given, out
    )
    return out[:rows]


@njit(cache=True)
def _roughness(distance: float, i: int, amplitude: float) -> float:
    """Load variation [N] of wheel ``i`` by the road: waves of 0.7 to 12 m, falling with the wave number."""
    value = 0.0
    for k in range(8):
        length = 12.0 * 0.66**k
        value += math.sin(2.0 * math.pi * distance / length + 2.3 * i + 1.1 * k * k) * math.sqrt(length / 12.0)
    return amplitude * value


@njit(cache=True)
def _friction(car: Any, i: int, distance: float, speed: float, tread: float, load: float) -> float:
    """Factor on the friction of wheel ``i``: place, load, speed, temperature."""
    factor: float = car.wheel_friction[i]
    if distance > car.friction_step_at:
        factor *= car.friction_step
    factor *= 1.0 + car.friction_split if i % 2 == 0 else 1.0 - car.friction_split
    factor *= 1.0 - car.load_sensitivity * (load / car.nominal_load - 1.0)
    factor *= max(1.0 - car.friction_speed_loss * speed, 0.1)
    return max(factor * (1.0 - car.friction_heat_loss * tread * tread), 0.05)


@njit(cache=True)
def _spin(inertia: float, omega: float, torque: float, capacity: float, step: float) -> tuple[float, float]:
    """Spin after a step under ``torque`` and set-valued friction up to ``capacity``; the friction that acted."""
    momentum = inertia * omega + step * torque
    if abs(momentum) <= step * capacity:
        return 0.0, -momentum / step
    friction = -capacity if momentum > 0.0 else capacity
    return (momentum + step * friction) / inertia, friction


@njit(cache=True)
def _start(car: Any, s: Any, speed: float, given: FloatArray) -> None:
    """Rolling freely at a speed, or as recorded."""
    s.body[chassis.VX], s.body[chassis.PITCH] = speed, chassis.pitch_of_lift(car, speed)
    s.reference = speed
    for i in range(4):
        s.omega[i], s.rim_before[i] = speed / car.radius[i], speed
        s.opening_in[i], s.disc[i] = 1.0, brakes.AMBIENT_DEGC
    s.volumes[0] = s.volumes[1] = car.accumulator_start
    chassis.wheel_loads(car, s.body, s.car_x, s.car_y, s.load)
    if len(given) > 0:
        s.body[chassis.VX], s.body[chassis.VY], s.body[chassis.YAW_RATE] = given[0, 0], given[0, 1], given[0, 2]
        for i in range(4):
            s.omega[i] = given[0, _WHEEL + i]


@njit(cache=True)
def _command(s: Any, given: FloatArray, row: int) -> None:
    """Replay: the recorded commands of the control unit."""
    s.pump = given[row, _PUMP]
    for i in range(4):
        s.inlet[i], s.outlet[i] = given[row, _INLET + i], given[row, _OUTLET + i]


@njit(cache=True)
def _pull(s: Any, given: FloatArray, row: int) -> None:
    """Replay: a pull towards the recorded speeds and pressures."""
    for i in range(4):
        s.omega[i] += PULL_WHEEL * (given[row, _WHEEL + i] - s.omega[i])
        s.pressure[i] += PULL_PRESSURE * (given[row, _PRESSURE + i] - s.pressure[i])
    s.body[chassis.VX] += PULL_SPEED * (given[row, 0] - s.body[chassis.VX])
    s.body[chassis.YAW_RATE] += PULL_WHEEL * (given[row, 2] - s.body[chassis.YAW_RATE])


@njit(cache=True)
def _control(car: Any, s: Any, braking: bool) -> None:
    """One cycle of the car's own ABS."""
    for i in range(4):
        s.rim[i] = s.omega[i] * CONTROLLER_RADIUS_M
        s.rim_rate[i] = 0.5 * s.rim_rate[i] + 0.5 * (s.rim[i] - s.rim_before[i]) / controller.CYCLE_S
        s.rim_before[i] = s.rim[i]
    s.reference = controller.reference_speed(s.reference, s.rim)
    pump = controller.decide(car, s.reference, s.rim, s.rim_rate, braking, s.phase, s.timer, s.inlet, s.outlet)
    s.pump = 1.0 if pump else 0.0


@njit(cache=True)
def commanded(cycles: FloatArray, i: int, time: float) -> float:
    """Mean command (cycles, 4) of a valve over the step that begins at ``time``: it may switch within it."""
    end = (time + STEP_S + CYCLE_SHIFT_S) / controller.CYCLE_S
    last = max(int(end + 1e-9), 0)
    since = (end - last) * controller.CYCLE_S / STEP_S
    share = min(max(since, 0.0), 1.0)
    before: float = cycles[max(last - 1, 0), i]
    now: float = cycles[last, i]
    return before + share * (now - before)


@njit(cache=True)
def _pressures(car: Any, s: Any, cycles: FloatArray, time: float) -> None:
    """Wheel pressures and accumulators after a step; ``cycles`` (2, cycles, 4) are inlet and outlet commands."""
    share = STEP_S / brakes.VALVE_LAG_S
    for i in range(4):
        s.opening_in[i] += share * (1.0 - commanded(cycles[0], i, time - car.inlet_delay[i]) - s.opening_in[i])
        s.opening_out[i] += share * (commanded(cycles[1], i, time - car.outlet_delay[i]) - s.opening_out[i])
        circuit = 0 if i in (0, 3) else 1
        before = s.pressure[i]
        low = 0.2 * brakes.FULL_ACCUMULATOR_PA * s.volumes[circuit] / ACCUMULATOR_M3
        supply = s.master * (1.0 - car.circuit_loss[circuit])
        s.pressure[i] = brakes.wheel_pressure(car, i, before, supply, low, s.opening_in[i], s.opening_out[i], STEP_S)
        if s.opening_out[i] > 0.1:
            s.pressure[i] = brakes.released(car, i, s.volumes, circuit, before, s.pressure[i])
    brakes.pump_back(car, s.volumes, s.pump > 0.5, STEP_S)
    if np.max(s.pressure) < brakes.RELEASED_PA:
        s.stop_energy = 0.0


@njit(cache=True)
def _brake(car: Any, s: Any, i: int, acting: float) -> None:
    """Torque that brake ``i`` can transmit under the pressure that acts on its piston."""
    before = s.piston[i]
    s.piston[i] = brakes.piston_pressure(car, before, acting)
    possible = brakes.brake_torque(
        car,
        i,
        s.piston[i],
        (s.piston[i] - before) / STEP_S,
        s.omega[i],
        s.turned[i],
        s.disc[i],
        s.stop_energy,
        s.body[chassis.VX],
        s.body[chassis.YAW_RATE],
    )
    follows = 1.0 - math.exp(-STEP_S / car.caliper_lag) if car.caliper_lag > 0.0 else 1.0
    s.torque[i] += follows * (possible - s.torque[i])


@njit(cache=True)
def _tyre(car: Any, s: Any, i: int, along: float, across: float, radius: float, load: float) -> None:
    """Tyre forces after a step; ``along``, ``across`` is the velocity of the contact in the wheel's axes."""
    rim = radius * s.omega[i]
    faster = max(max(abs(along), abs(rim)), SLOWEST_SLIP_SPEED_M_S)
    slide = math.sqrt((rim - along) ** 2 + across * across)
    factor = _friction(car, i, s.distance, s.body[chassis.VX], s.tread[i], load)
    steady_x, steady_y = steady_forces(
        car.curve,
        (rim - along) / faster,
        -across / faster,
        car.peak_x[i] * factor,
        car.peak_y[i] * factor,
        car.shape_x,
        car.shape_y,
        car.stiffness_x[i],
        car.stiffness_y_front if i < 2 else car.stiffness_y_rear,
        load,
    )
    travel = max(faster, SLOWEST_RELAXATION_SPEED_M_S) * STEP_S
    s.force_x[i] += (1.0 - math.exp(-travel / car.relaxation_x)) * (steady_x - s.force_x[i])
    s.force_y[i] += (1.0 - math.exp(-travel / car.relaxation_y)) * (steady_y + car.conicity - s.force_y[i])
    heat = math.sqrt(s.force_x[i] ** 2 + s.force_y[i] ** 2) * slide * 0.5
    s.tread[i] += STEP_S * (heat - TREAD_COOLING_W_K * s.tread[i]) / TREAD_HEAT_CAPACITY_J_K


@njit(cache=True)
def _driven(car: Any, s: Any, i: int, drive_torque: float) -> float:
    """Torque of the driveline on wheel ``i``."""
    if i < 2:
        return 0.0
    lock = car.differential_torque * math.tanh((s.omega[2] - s.omega[3]) / 0.5)
    coasting: float = car.engine_braking if drive_torque < DRIVING_NM else 0.0
    torque = drive_torque - coasting - car.driveline_drag * s.omega[i]  # of both wheels
    return 0.5 * torque + (-lock if i == 2 else lock)


@njit(cache=True)
def _wheel(car: Any, s: Any, i: int, acting: float, drive_torque: float, cosine: float, sine: float) -> None:
    """Brake, tyre and spin of wheel ``i`` after a step; its forces in the car's axes."""
    _brake(car, s, i, acting)
    vx, vy, yaw = s.body[chassis.VX], s.body[chassis.VY], s.body[chassis.YAW_RATE]
    place_x, place_y = chassis.wheel_place(car, i)
    # the body turns about its centre of gravity, the contacts lie below it
    along = vx - yaw * place_y - car.cg_height * s.body[chassis.PITCH_RATE]
    across = vy + yaw * place_x + car.cg_height * s.body[chassis.ROLL_RATE]
    if i < 2:
        along, across = along * cosine + across * sine, across * cosine - along * sine
    load = max(s.load[i] + _roughness(s.distance, i, car.roughness), 0.0)
    radius = car.radius[i] + car.radius_growth * vx * vx
    _tyre(car, s, i, along, across, radius, load)
    rolling = car.rolling_resistance[i] * load * radius
    net = _driven(car, s, i, drive_torque) - radius * s.force_x[i]
    before = s.omega[i]
    s.omega[i], friction = _spin(car.wheel_inertia[i], before, net, s.torque[i] + rolling, STEP_S)
    mean = 0.5 * (before + s.omega[i])
    s.turned[i] += mean * STEP_S
    by_brake = s.torque[i] / max(s.torque[i] + rolling, 1e-9)
    power = abs(friction) * by_brake * abs(mean)
    s.about_wheels += friction * (1.0 - by_brake) - car.wheel_inertia[i] * (s.omega[i] - before) / STEP_S
    s.spin_momentum += car.wheel_inertia[i] * s.omega[i]
    s.disc[i] = brakes.disc_temperature(car, s.disc[i], power, mean, STEP_S)
    s.stop_energy += power * STEP_S
    s.work += STEP_S * mean * (net + friction)
    s.aligning -= chassis.trail(car, across / max(abs(along), 1.0)) * s.force_y[i]
    s.car_x[i], s.car_y[i] = s.force_x[i], s.force_y[i]
    if i < 2:
        s.car_x[i] = s.force_x[i] * cosine - s.force_y[i] * sine
        s.car_y[i] = s.force_x[i] * sine + s.force_y[i] * cosine


@njit(cache=True)
def _write(car: Any, s: Any, along: float, across: float, line: FloatArray) -> None:
    """One row of ``OUTPUTS``."""
    vx, vy, yaw = s.body[chassis.VX], s.body[chassis.VY], s.body[chassis.YAW_RATE]
    line[0], line[1], line[2] = vx, vy, yaw
    line[3], line[4] = along, across
    line[5], line[6] = s.body[chassis.PITCH], s.body[chassis.PITCH_RATE]
    line[7], line[8] = s.body[chassis.ROLL], s.body[chassis.ROLL_RATE]
    line[_DISTANCE], line[_MASTER], line[_PUMP] = s.distance, s.master, s.pump
    kinetic = 0.5 * car.mass * (vx * vx + vy * vy) + 0.5 * car.yaw_inertia * yaw * yaw
    for i in range(4):
        line[_WHEEL + i], line[_PRESSURE + i] = s.omega[i], s.pressure[i]
        line[_INLET + i], line[_OUTLET + i] = s.inlet[i], s.outlet[i]
        line[_LOAD + i], line[_FX + i], line[_FY + i] = s.load[i], s.force_x[i], s.force_y[i]
        line[_TORQUE + i], line[_DISC + i] = s.torque[i], s.disc[i]
        kinetic += 0.5 * car.wheel_inertia[i] * s.omega[i] * s.omega[i]
    line[_KINETIC], line[_WORK] = kinetic, s.work


@njit(cache=True)
def _move(car: Any, s: Any, first: bool) -> None:
    """The body after a step by the two-step Adams-Bashforth rule, and the work that was done on it."""
    vx, vy, yaw = s.body[chassis.VX], s.body[chassis.VY], s.body[chassis.YAW_RATE]
    along, across = s.rate[chassis.VX] - vy * yaw, s.rate[chassis.VY] + vx * yaw
    weight = 1.0 if first else 1.5
    for k in range(chassis.STATES):
        s.body[k] += STEP_S * (weight * s.rate[k] - (weight - 1.0) * s.last_rate[k])
        s.last_rate[k] = s.rate[k]
    mean_x, mean_y = 0.5 * (vx + s.body[chassis.VX]), 0.5 * (vy + s.body[chassis.VY])
    s.work += STEP_S * car.mass * (mean_x * along + mean_y * across)
    s.work += STEP_S * 0.5 * (yaw + s.body[chassis.YAW_RATE]) * car.yaw_inertia * s.rate[chassis.YAW_RATE]
    s.distance += STEP_S * mean_x


@njit(cache=True)
def _steer(car: Any, s: Any, wheel_angle: float) -> None:
    """Mean angle of the front wheels, which yield to their aligning moment with a lag."""
    speed = max(s.body[chassis.VX], 1.0)
    slip = (s.body[chassis.VY] + car.cg_to_front * s.body[chassis.YAW_RATE]) / speed - s.delta
    wanted = chassis.steering_angle(car, wheel_angle, s.force_y[0], s.force_y[1], slip)
    s.delta += STEP_S / STEERING_LAG_S * (wanted - s.delta)


@njit(cache=True)
def _run(
    car: Any,
    memory: Any,
    cycles: FloatArray,
    speed: float,
    pedal: FloatArray,
    steering_wheel: FloatArray,
    drive_torque: FloatArray,
    stop_below: float,
    given: FloatArray,
    out: FloatArray,
) -> int:
    """Every step in its order: controller, pressures, steering, loads, wheels, body; rows written into ``out``."""
    s = memory[0]
    replay = len(given) > 0
    _start(car, s, speed, given)
    for n in range(RECORD_EVERY * len(out)):
        row = n // RECORD_EVERY
        if s.body[chassis.VX] < stop_below:
            return row
        if replay and n % CYCLE_STEPS == 0 and n > 0:
            _pull(s, given, row - 1)
        if n % CYCLE_STEPS == CYCLE_STEPS // 2:
            if replay:
                _command(s, given, row)
            else:
                _control(car, s, pedal[n] > BRAKING_N)
            cycle = n // CYCLE_STEPS + 1
            cycles[0, cycle], cycles[1, cycle] = s.inlet, s.outlet
        asked = car.booster_gain * pedal[n]
        asked = min(asked, car.booster_knee + BEYOND_KNEE * asked)
        s.master = given[row, _MASTER] if replay else s.master + STEP_S / BOOSTER_LAG_S * (asked - s.master)
        _pressures(car, s, cycles, n * STEP_S)
        _steer(car, s, steering_wheel[n])
        chassis.wheel_loads(car, s.body, s.car_x, s.car_y, s.load)
        s.aligning = s.about_wheels = s.spin_momentum = 0.0
        for i in range(4):
            acting = given[row, _PRESSURE + i] if replay else s.pressure[i]
            _wheel(car, s, i, acting, drive_torque[n], math.cos(s.delta), math.sin(s.delta))
        along, across = chassis.derivatives(
            car, s.body, s.car_x, s.car_y, s.aligning, s.about_wheels, s.spin_momentum, s.rate
        )
        if n % RECORD_EVERY == 0:
            _write(car, s, along, across, out[row])
        _move(car, s, n == 0)
    return len(out)
