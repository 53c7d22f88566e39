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
BOOSTER_LAG_S = 0.05
STEERING_LAG_S = 0.0075
DRIVING_NM = 1.0
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
    rows = _run(car, drive.speed, drive.pedal, drive.steering_wheel, drive.drive_torque, floor, given, out)
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
def _friction(car: Any, i: int, distance: float, speed: float, slide: float, tread: float, load: float) -> float:
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
def _run(
    car: Any,
    speed: float,
    pedal: FloatArray,
    steering_wheel: FloatArray,
    drive_torque: FloatArray,
    stop_below: float,
    given: FloatArray,
    out: FloatArray,
) -> int:
    replay = len(given) > 0
    body, rate, last_rate = np.zeros(chassis.STATES), np.zeros(chassis.STATES), np.zeros(chassis.STATES)
    body[chassis.VX] = speed
    omega, turned = np.zeros(4), np.zeros(4)
    force_x, force_y, load = np.zeros(4), np.zeros(4), np.zeros(4)
    car_x, car_y = np.zeros(4), np.zeros(4)
    pressure, piston, torque = np.zeros(4), np.zeros(4), np.zeros(4)
    opening_in, opening_out = np.ones(4), np.zeros(4)
    disc, tread = np.full(4, brakes.AMBIENT_DEGC), np.zeros(4)
    volumes, released = np.full(2, car.accumulator_start), np.zeros(4)
    phase, timer = np.zeros(4, np.int64), np.zeros(4, np.int64)
    inlet, outlet = np.zeros(4), np.zeros(4)
    cycles = len(pedal) // 20 + 2
    inlet_history, outlet_history = np.zeros((cycles, 4)), np.zeros((cycles, 4))
    rim, rim_before, rim_rate = np.zeros(4), np.full(4, speed), np.zeros(4)
    reference, master, delta, distance = speed, 0.0, 0.0, 0.0
    stop_energy, work = 0.0, 0.0
    pump = False
    cycle_steps = 20
    chassis.wheel_loads(car, body, car_x, car_y, load)
    for i in range(4):
        omega[i] = speed / car.radius[i]
    if replay:
        for i in range(4):
            omega[i] = given[0, _WHEEL + i]
        body[chassis.VX], body[chassis.YAW_RATE] = given[0, 0], given[0, 2]
        body[chassis.VY] = given[0, 1]
    rows = 0
    steps = 2 * (len(pedal) // 2) if not replay else 2 * min(len(given), len(pedal) // 2)
    for n in range(steps):
        time = n * STEP_S
        vx, vy, yaw = body[chassis.VX], body[chassis.VY], body[chassis.YAW_RATE]
        if vx < stop_below:
            break
        row = n // RECORD_EVERY
        if n % cycle_steps == 0:
            cycle = n // cycle_steps
            if replay:
                pump = given[row, _PUMP] > 0.5
                for i in range(4):
                    inlet[i], outlet[i] = given[row, _INLET + i], given[row, _OUTLET + i]
                    if n > 0:
                        omega[i] += PULL_WHEEL * (given[row - 1, _WHEEL + i] - omega[i])
                        pressure[i] += PULL_PRESSURE * (given[row - 1, _PRESSURE + i] - pressure[i])
                if n > 0:
                    body[chassis.VX] += PULL_SPEED * (given[row - 1, 0] - vx)
                    body[chassis.YAW_RATE] += PULL_WHEEL * (given[row - 1, 2] - yaw)
                    vx, yaw = body[chassis.VX], body[chassis.YAW_RATE]
            else:
                for i in range(4):
                    rim[i] = omega[i] * 0.278
                    rim_rate[i] = 0.5 * rim_rate[i] + 0.5 * (rim[i] - rim_before[i]) / controller.CYCLE_S
                    rim_before[i] = rim[i]
                reference = controller.reference_speed(reference, rim)
                pump = controller.decide(car, reference, rim, rim_rate, pedal[n] > 5.0, phase, timer, inlet, outlet)
            inlet_history[cycle] = inlet
            outlet_history[cycle] = outlet
        # hydraulics
        asked = min(car.booster_gain * pedal[n], car.booster_knee + 0.15 * (car.booster_gain * pedal[n]))
        if replay:
            master = given[row, _MASTER]
        else:
            master += STEP_S / BOOSTER_LAG_S * (asked - master)
        for i in range(4):
            late_in = max(int((time - car.inlet_delay[i]) / controller.CYCLE_S + 1e-9), 0)
            late_out = max(int((time - car.outlet_delay[i]) / controller.CYCLE_S + 1e-9), 0)
            share = STEP_S / brakes.VALVE_LAG_S
            opening_in[i] += share * (1.0 - inlet_history[late_in, i] - opening_in[i])
            opening_out[i] += share * (outlet_history[late_out, i] - opening_out[i])
            circuit = 0 if i in (0, 3) else 1
            full = volumes[circuit] >= car.accumulator_volume
            low = pressure[i] if full else 0.2 * brakes.FULL_ACCUMULATOR_PA * volumes[circuit] / 4e-6
            supply = master * (1.0 - car.circuit_loss[circuit])
            before = pressure[i]
            pressure[i] = brakes.wheel_pressure(car, i, before, supply, low, opening_in[i], opening_out[i], STEP_S)
            falling = max(before - pressure[i], 0.0) if opening_out[i] > 0.1 else 0.0
            released[i] = falling / car.caliper_stiffness[i // 2]
        brakes.accumulate(car, volumes, released, pump, STEP_S)
        # wheels
        wanted = chassis.steering_angle(
            car, steering_wheel[n], force_y[0], force_y[1], vy / max(vx, 1.0) + 1.25 * yaw / max(vx, 1.0) - delta
        )
        delta += STEP_S / STEERING_LAG_S * (wanted - delta)
        cos_delta, sin_delta = math.cos(delta), math.sin(delta)
        taken = 0.0
        lock = car.differential_torque * math.tanh((omega[2] - omega[3]) / 0.5)
        chassis.wheel_loads(car, body, car_x, car_y, load)
        for i in range(4):
            acting = given[row, _PRESSURE + i] if replay else pressure[i]
            before = piston[i]
            piston[i] = brakes.piston_pressure(car, before, acting)
            piston_rate = (piston[i] - before) / STEP_S
            possible = brakes.brake_torque(
                car, i, piston[i], piston_rate, omega[i], turned[i], disc[i], stop_energy, vx, yaw
            )
            follows = 1.0 - math.exp(-STEP_S / car.caliper_lag) if car.caliper_lag > 0.0 else 1.0
            torque[i] += follows * (possible - torque[i])
            place_x, place_y = chassis.wheel_place(car, i)
            at_x, at_y = vx - yaw * place_y, vy + yaw * place_x
            if i < 2:
                at_x, at_y = at_x * cos_delta + at_y * sin_delta, at_y * cos_delta - at_x * sin_delta
            wheel_load = max(load[i] + _roughness(distance, i, car.roughness), 0.0)
            radius = car.radius[i] + car.radius_growth * vx * vx
            faster = max(max(abs(at_x), abs(radius * omega[i])), SLOWEST_SLIP_SPEED_M_S)
            slip_x, slip_y = (radius * omega[i] - at_x) / faster, -at_y / faster
            slide = math.sqrt((radius * omega[i] - at_x) ** 2 + at_y * at_y)
            factor = _friction(car, i, distance, vx, slide, tread[i], wheel_load)
            stiffness_y = car.stiffness_y_front if i < 2 else car.stiffness_y_rear
            steady_x, steady_y = steady_forces(
                car.curve,
                slip_x,
                slip_y,
                car.peak_x[i] * factor,
                car.peak_y[i] * factor,
                car.shape_x,
                car.shape_y,
                car.stiffness_x[i],
                stiffness_y,
                wheel_load,
            )
            steady_y += car.conicity
            travel = max(faster, SLOWEST_RELAXATION_SPEED_M_S) * STEP_S
            force_x[i] += (1.0 - math.exp(-travel / car.relaxation_x)) * (steady_x - force_x[i])
            force_y[i] += (1.0 - math.exp(-travel / car.relaxation_y)) * (steady_y - force_y[i])
            driven = 0.0
            if i >= 2:
                coasting = car.engine_braking if drive_torque[n] < DRIVING_NM else 0.0
                driven = 0.5 * (drive_torque[n] - coasting) - car.driveline_drag * omega[i]
                driven += -lock if i == 2 else lock
            rolling = car.rolling_resistance[i] * wheel_load * radius
            net = driven - radius * force_x[i]
            spin_before = omega[i]
            omega[i], friction = _spin(car.wheel_inertia[i], spin_before, net, torque[i] + rolling, STEP_S)
            mean = 0.5 * (spin_before + omega[i])
            turned[i] += mean * STEP_S
            share_brake = torque[i] / max(torque[i] + rolling, 1e-9)
            brake_power = abs(friction) * share_brake * abs(mean)
            disc[i] = brakes.disc_temperature(car, disc[i], brake_power, mean, STEP_S)
            taken += brake_power * STEP_S
            heat = math.sqrt(force_x[i] ** 2 + force_y[i] ** 2) * slide * 0.5
            tread[i] += STEP_S * (heat - TREAD_COOLING_W_K * tread[i]) / TREAD_HEAT_CAPACITY_J_K
            work += STEP_S * mean * (net + friction)
            car_x[i], car_y[i] = force_x[i], force_y[i]
            if i < 2:
                car_x[i] = force_x[i] * cos_delta - force_y[i] * sin_delta
                car_y[i] = force_x[i] * sin_delta + force_y[i] * cos_delta
        stop_energy += taken
        # body: two-step Adams-Bashforth
        along, across = chassis.derivatives(car, body, car_x, car_y, 0.0, rate)
        accelerations_x, accelerations_y = rate[chassis.VX] - vy * yaw, rate[chassis.VY] + vx * yaw
        if n % RECORD_EVERY == 0:
            line = out[row]
            line[0], line[1], line[2] = vx, vy, yaw
            line[3], line[4] = along, across
            line[5], line[6] = body[chassis.PITCH], body[chassis.PITCH_RATE]
            line[7], line[8] = body[chassis.ROLL], body[chassis.ROLL_RATE]
            line[_DISTANCE], line[_MASTER], line[_PUMP] = distance, master, 1.0 if pump else 0.0
            kinetic = 0.5 * car.mass * (vx * vx + vy * vy) + 0.5 * car.yaw_inertia * yaw * yaw
            for i in range(4):
                line[_WHEEL + i], line[_PRESSURE + i] = omega[i], pressure[i]
                line[_INLET + i], line[_OUTLET + i] = inlet[i], outlet[i]
                line[_LOAD + i], line[_FX + i], line[_FY + i] = load[i], force_x[i], force_y[i]
                line[_TORQUE + i], line[_DISC + i] = torque[i], disc[i]
                kinetic += 0.5 * car.wheel_inertia[i] * omega[i] * omega[i]
            line[_KINETIC], line[_WORK] = kinetic, work
            rows += 1
        weight = 1.5 if n > 0 else 1.0
        for k in range(chassis.STATES):
            body[k] += STEP_S * (weight * rate[k] - (weight - 1.0) * last_rate[k])
            last_rate[k] = rate[k]
        mean_x, mean_y = 0.5 * (vx + body[chassis.VX]), 0.5 * (vy + body[chassis.VY])
        moment = car.yaw_inertia * rate[chassis.YAW_RATE]
        work += STEP_S * car.mass * (mean_x * accelerations_x + mean_y * accelerations_y)
        work += STEP_S * 0.5 * (yaw + body[chassis.YAW_RATE]) * moment
        distance += STEP_S * mean_x
    return rows
