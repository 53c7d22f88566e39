"""Guidance of the wheels: the line along which each travels, from roll centres and support angles of the axles."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from signals.wheels import WHEELS


@dataclass(frozen=True)
class Guidance:
    """How the wheels are guided.

    Attributes
    ----------
    slides : shape (4, 3)
        Movement of each wheel per travel, body axes; its z component is 1.
    carrier_pitch : shape (4,)
        Pitching of each wheel carrier per travel, about the y axis [rad/m].
    """

    slides: NDArray[np.float64]
    carrier_pitch: NDArray[np.float64]


def guidance(values: Mapping[str, float]) -> Guidance:
    """Guidance of the wheels.

    The contact moves at right angles to its line to the roll centre: outwards by 2 h/track per travel. Seen from the
    side it moves along the line that the support angle of braking tells, and the wheel's centre along that of driving:
    a brake is held by the carrier, a half shaft by the body. Carriers that pitch with the travel make the difference.

    Parameters
    ----------
    values
        Sections ``axles``, ``wheels`` and ``suspension`` by dotted path.

    Source: Reimpell, Stoll, Betzler, The Automotive Chassis, 2nd ed., 3.4 (roll centre) and 3.11 (anti-dive).
    """
    slides, pitch = np.zeros((4, 3)), np.zeros(4)
    for i, wheel in enumerate(WHEELS):
        axle = "front" if i < 2 else "rear"
        forward = 1.0 if i < 2 else -1.0
        leftward = 1.0 if i % 2 == 0 else -1.0
        braking = forward * math.tan(values[f"suspension.{axle}.brake_support_angle"])
        driving = forward * math.tan(values[f"suspension.{axle}.drive_support_angle"])
        height, track = values[f"suspension.{axle}.roll_centre_height"], values[f"axles.{axle}.track"]
        slides[i] = driving, leftward * 2.0 * height / track, 1.0
        pitch[i] = (driving - braking) / values[f"wheels.{wheel}.radius"]
    return Guidance(slides, pitch)
