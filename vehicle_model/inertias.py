"""Estimates of inertias and frontal area for cars whose data are unknown; without numpy, as vehicle files use them."""

from typing import Literal

TRANSVERSE_OVER_SPIN = 0.6
"""Inertia of wheel and carrier about a diameter over that about the spin axis; a thin disc has 0.5 (assumed)."""


def roll_inertia(mass: float, width: float, height: float) -> float:
    """(0.75/12) m (w^2 + h^2) [kg m^2] from mass [kg], overall width and height [m] (Enisz 2015, eq. 116, l. 1361)."""
    return 0.75 / 12.0 * mass * (width**2 + height**2)


def pitch_inertia(mass: float, length: float, height: float) -> float:
    """(0.75/12) m (l^2 + h^2) [kg m^2] from mass [kg], overall length and height [m] (Enisz 2015, eq. 116, l. 1361)."""
    return 0.75 / 12.0 * mass * (length**2 + height**2)


def yaw_inertia(
    mass: float,
    wheelbase: float,
    length: float,
    rule: Literal["wheelbase_times_length", "wheelbase_squared"] = "wheelbase_times_length",
) -> float:
    """0.1269 m L l [kg m^2]; the printed form, with the wheelbase squared, is the other rule.

    Parameters
    ----------
    mass : kg
    wheelbase, length : m
        L and the overall length l.

    Source: Enisz 2015, eq. 116, l. 1361; friction document 2.5.
    """
    return 0.1269 * mass * wheelbase * (length if rule == "wheelbase_times_length" else wheelbase)


def frontal_area(mass: float) -> float:
    """1.6 + 0.00056 (m - 765) [m^2] from the mass [kg] (Enisz 2015, eq. 122; friction document 3.7)."""
    return 1.6 + 0.00056 * (mass - 765.0)
