"""Equations of motion of the hidden car's body, compiled: planar motion, pitch and roll on springs, wheel loads."""

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hidden_effects.car import GRAVITY_M_S2

VX, VY, YAW_RATE, PITCH, PITCH_RATE, ROLL, ROLL_RATE = range(7)
STATES = 7
TYRE_ANGLE_OF_NO_TRAIL_RAD = 0.16

FloatArray = NDArray[np.float64]


@njit(cache=True)
def pitch_rates(car: Any) -> tuple[float, float]:
    """Stiffness [N m/rad] and damping [N m s/rad] of the body in pitch."""
    front, rear = car.cg_to_front, car.wheelbase - car.cg_to_front
    stiffness = 2.0 * (car.spring_rate[0] * front * front + car.spring_rate[1] * rear * rear)
    damping = 2.0 * (car.damper_rate[0] * front * front + car.damper_rate[1] * rear * rear)
    return stiffness, damping


@njit(cache=True)
def roll_rates(car: Any, axle: int) -> tuple[float, float]:
    """Stiffness [N m/rad] and damping [N m s/rad] of an axle in roll."""
    half_square = 0.5 * car.track * car.track
    stiffness = half_square * (car.spring_rate[axle] + 2.0 * car.anti_roll_rate[axle])
    return stiffness, half_square * car.damper_rate[axle]


@njit(cache=True)
def sprung_inertias(car: Any) -> tuple[float, float]:
    """Inertia of the body on its springs in roll and pitch [kg m^2]: the whole car's less the wheels' (Steiner)."""
    below = (car.cg_height - car.radius[0]) ** 2
    rear = car.wheelbase - car.cg_to_front
    across = 4.0 * car.unsprung_mass * (0.25 * car.track * car.track + below)
    along = 2.0 * car.unsprung_mass * (car.cg_to_front * car.cg_to_front + rear * rear + 2.0 * below)
    return car.roll_inertia - across, car.pitch_inertia - along


@njit(cache=True)
def wheel_place(car: Any, i: int) -> tuple[float, float]:
    """Place (x, y) [m] of a contact patch in the car."""
    x = car.cg_to_front if i < 2 else car.cg_to_front - car.wheelbase
    return x, 0.5 * car.track if i % 2 == 0 else -0.5 * car.track


@njit(cache=True)
def link_load(car: Any, force_x: FloatArray, force_y: FloatArray) -> float:
    """Load [N] that the links carry past the springs from the rear axle to the front one.

    F_x tan(eps) of an axle turns the body with that axle's arm: the pitch angle changes, the steady load transfer does
    not. So does what the inclined links of a loaded outer wheel push up more than those of the inner one pull down
    (jacking, 2 h_R / track of the difference of the side forces). A body without heave takes it as a pair of forces.
    """
    front, rear = car.cg_to_front, car.wheelbase - car.cg_to_front
    at_front = -(force_x[0] + force_x[1]) * math.tan(car.support_angle[0])
    at_rear = (force_x[2] + force_x[3]) * math.tan(car.support_angle[1])
    at_front += (force_y[1] - force_y[0]) * 2.0 * car.roll_centre[0] / car.track
    at_rear += (force_y[3] - force_y[2]) * 2.0 * car.roll_centre[1] / car.track
    return (at_front * front - at_rear * rear) / car.wheelbase


@njit(cache=True)
def lift(car: Any, speed: float, axle: int) -> float:
    """Force [N] of the air that lifts the body over an axle."""
    lifted: float = 0.5 * car.air_density * car.frontal_area * car.lift_coefficient[axle] * (speed + car.head_wind) ** 2
    return lifted


@njit(cache=True)
def lift_moment(car: Any, speed: float) -> float:
    """Moment [N m] by which the lifting air pitches the body, nose down positive."""
    return lift(car, speed, 1) * (car.wheelbase - car.cg_to_front) - lift(car, speed, 0) * car.cg_to_front


@njit(cache=True)
def pitch_of_lift(car: Any, speed: float) -> float:
    """Pitch angle [rad] of the car that rolls freely under the lifting air, its weight's moment included."""
    return lift_moment(car, speed) / (pitch_rates(car)[0] - car.mass * GRAVITY_M_S2 * car.cg_height)


@njit(cache=True)
def wheel_loads(car: Any, state: FloatArray, force_x: FloatArray, force_y: FloatArray, load: FloatArray) -> None:
    """Vertical loads [N] from springs, dampers and links; ``force_x``, ``force_y`` (4,) in the car's axes.

    The air lifts the body: its moment pitches it, and what it carries in all a body without heave feels as less weight.
    """
    front_share = (car.wheelbase - car.cg_to_front) / car.wheelbase
    weight = car.mass * GRAVITY_M_S2 - lift(car, state[VX], 0) - lift(car, state[VX], 1)
    stiffness, damping = pitch_rates(car)
    links = link_load(car, force_x, force_y)
    along = (stiffness * state[PITCH] + damping * state[PITCH_RATE]) / car.wheelbase + links
    for axle in range(2):
        k, c = roll_rates(car, axle)
        side = force_y[2 * axle] + force_y[2 * axle + 1]
        across = (k * state[ROLL] + c * state[ROLL_RATE] + side * car.roll_centre[axle]) / car.track
        static = 0.5 * weight * (front_share if axle == 0 else 1.0 - front_share)
        mean = static + (0.5 * along if axle == 0 else -0.5 * along)
        load[2 * axle] = max(mean - across, 0.0)
        load[2 * axle + 1] = max(mean + across, 0.0)


@njit(cache=True)
def derivatives(
    car: Any,
    state: FloatArray,
    force_x: FloatArray,
    force_y: FloatArray,
    moment: float,
    about_wheels: float,
    spin_momentum: float,
    rate: FloatArray,
) -> tuple[float, float]:
    """Time derivatives of the body's states into ``rate`` (7,).

    Parameters
    ----------
    force_x, force_y : (4,) N
        Tyre forces in the car's axes.
    moment : N m
        Yaw moment beside that of the tyre forces at the wheels' centres: the tyres' aligning moments.
    about_wheels : N m
        Moment about the wheels' axes that is left for the body: what the road's rolling resistance does to the wheels,
        less what changes their spin. What brakes and drive do to wheels and body cancels.
    spin_momentum : kg m^2/s
        Of all wheels about their axes, which the yawing car turns.

    Returns
    -------
    Specific forces along and across [m/s^2] in the pitched and rolled body, as its accelerometers feel them.
    """
    sum_x = sum_y = yaw = 0.0
    for i in range(4):
        x, y = wheel_place(car, i)
        sum_x += force_x[i]
        sum_y += force_y[i]
        yaw += x * force_y[i] - y * force_x[i]
    air_x, air_y = state[VX] + car.head_wind, state[VY] + car.side_wind
    half_density = 0.5 * car.air_density
    air_speed = math.sqrt(air_x * air_x + air_y * air_y)
    drag = half_density * car.drag_area * air_x * air_speed
    body_x = sum_x - drag
    body_y = sum_y - half_density * car.side_area * air_y * air_speed
    along, across = body_x / car.mass, body_y / car.mass
    rate[VX] = along - GRAVITY_M_S2 * car.grade + state[VY] * state[YAW_RATE]
    rate[VY] = across - GRAVITY_M_S2 * car.bank - state[VX] * state[YAW_RATE]
    rate[YAW_RATE] = (yaw + moment) / car.yaw_inertia
    roll_inertia, pitch_inertia = sprung_inertias(car)
    stiffness, damping = pitch_rates(car)
    weight_moment = car.mass * GRAVITY_M_S2 * car.cg_height
    links = link_load(car, force_x, force_y)
    # drag pushes at its own height, wherever the load puts the centre of gravity
    pitch = (
        about_wheels
        - car.cg_height * sum_x
        - (car.drag_height - car.cg_height) * drag
        - stiffness * state[PITCH]
        - damping * state[PITCH_RATE]
        + lift_moment(car, state[VX])
    )
    rate[PITCH] = state[PITCH_RATE]
    rate[PITCH_RATE] = (pitch + weight_moment * state[PITCH] - car.wheelbase * links) / pitch_inertia
    roll = car.cg_height * sum_y + weight_moment * state[ROLL] + state[YAW_RATE] * spin_momentum
    for axle in range(2):
        k, c = roll_rates(car, axle)
        roll -= k * state[ROLL] + c * state[ROLL_RATE]
        roll -= (force_y[2 * axle] + force_y[2 * axle + 1]) * car.roll_centre[axle]
    rate[ROLL] = state[ROLL_RATE]
    rate[ROLL_RATE] = roll / roll_inertia
    sin_pitch, sin_roll = math.sin(state[PITCH]), math.sin(state[ROLL])
    return along - GRAVITY_M_S2 * sin_pitch, across + GRAVITY_M_S2 * sin_roll


@njit(cache=True)
def trail(car: Any, slip: float) -> float:
    """Distance [m] behind the wheel's centre at which the side force acts, falling as a cosine with the slip angle."""
    length: float = car.pneumatic_trail
    return length * max(math.cos(0.5 * math.pi * min(abs(slip) / TYRE_ANGLE_OF_NO_TRAIL_RAD, 1.0)), 0.0)


@njit(cache=True)
def steering_angle(car: Any, wheel_angle: float, force_y_left: float, force_y_right: float, slip: float) -> float:
    """Mean road-wheel angle [rad]: ratio, offset, and the compliance under the front tyres' aligning moment."""
    twist = 0.5 * (force_y_left + force_y_right) * trail(car, slip) / car.steering_stiffness
    return wheel_angle / car.steering_ratio + car.steering_offset - twist
