"""Masses and inertias of the car's five bodies, from the parameters of a vehicle file by dotted path."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from signals.errors import InputError
from signals.wheels import WHEELS
from vehicle_model.inertias import TRANSVERSE_OVER_SPIN


@dataclass(frozen=True)
class RigidBodies:
    """The car taken apart.

    Attributes
    ----------
    wheel_positions : shape (4, 3)
        Wheel centres at rest from the car's centre of gravity at rest [m].
    unsprung_mass, spin_inertia, transverse_inertia : shape (4,)
        Of each wheel with its carrier.
    sprung_mass : float
    sprung_centre : shape (3,)
        Centre of gravity of the sprung body from the car's centre of gravity at rest [m].
    sprung_inertia : shape (3, 3)
        About the sprung body's own centre of gravity [kg m^2].
    """

    wheel_positions: NDArray[np.float64]
    unsprung_mass: NDArray[np.float64]
    spin_inertia: NDArray[np.float64]
    transverse_inertia: NDArray[np.float64]
    sprung_mass: float
    sprung_centre: NDArray[np.float64]
    sprung_inertia: NDArray[np.float64]


def _steiner(mass: float, place: NDArray[np.float64]) -> NDArray[np.float64]:
    return mass * (np.dot(place, place) * np.eye(3) - np.outer(place, place))


def rigid_bodies(values: Mapping[str, float], at_rest: Mapping[str, float]) -> RigidBodies:
    """Take the car apart so that the parts together have the mass, place and inertias of the file.

    Parameters
    ----------
    values
        Present parameters.
    at_rest
        Parameters with which the car was built: they fix the origin of the body frame and the ride height, so that a
        load that comes on-line moves the centre of gravity and not the wheels.

    Raises
    ------
    InputError
        If no mass or no inertia remains for the sprung body.
    """
    origin_behind, origin_height = (
        at_rest["body.centre_of_gravity_to_front_axle"],
        at_rest["body.centre_of_gravity_height"],
    )
    wheels = np.empty((4, 3))
    for index, wheel in enumerate(WHEELS):
        front = index < 2
        side = 1.0 if index % 2 == 0 else -1.0
        track = values["axles.front.track" if front else "axles.rear.track"]
        wheels[index, 0] = origin_behind if front else origin_behind - values["body.wheelbase"]
        wheels[index, 1] = side * track / 2.0
        wheels[index, 2] = at_rest[f"wheels.{wheel}.radius"] - origin_height
    mass = values["body.mass"]
    unsprung = np.array([values[f"wheels.{wheel}.unsprung_mass"] for wheel in WHEELS])
    spin = np.array([values[f"wheels.{wheel}.inertia"] for wheel in WHEELS])
    transverse = TRANSVERSE_OVER_SPIN * spin
    sprung_mass = mass - unsprung.sum()
    if sprung_mass <= 0.0:
        raise InputError(f"body.mass: found {mass:g} kg, allowed: more than the unsprung {unsprung.sum():g} kg")

    centre = np.array(
        [
            origin_behind - values["body.centre_of_gravity_to_front_axle"],
            0.0,
            values["body.centre_of_gravity_height"] - origin_height,
        ]
    )
    sprung_centre = (mass * centre - unsprung @ wheels) / sprung_mass
    inertia = np.diag([values["body.roll_inertia"], values["body.pitch_inertia"], values["body.yaw_inertia"]])
    for index in range(4):
        inertia -= _steiner(unsprung[index], wheels[index] - centre)
        inertia -= np.diag([transverse[index], spin[index], transverse[index]])
    inertia -= _steiner(sprung_mass, sprung_centre - centre)
    principal = np.linalg.eigvalsh(inertia)
    # estimates such as eq. 116 may leave one inertia larger than the sum of the other two; the equations bear that
    if principal[0] <= 0.0:
        raise InputError(
            "body: the wheels alone have more inertia than the whole car",
            found=f"{principal[0]:.0f} kg m^2 for the sprung body",
            allowed="more than 0",
            mend="raise roll_inertia, pitch_inertia or yaw_inertia",
        )
    return RigidBodies(wheels, unsprung, spin, transverse, float(sprung_mass), sprung_centre, inertia)
