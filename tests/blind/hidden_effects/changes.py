"""How effects change the car's numbers and its measuring chain."""

import numpy as np

from hidden_effects.car import Numbers
from hidden_effects.hidden_effect import Change
from hidden_effects.tyre import arctangent


def factor(field: str, rows: slice | None = None) -> Change:
    """Multiplies a number of the car, all wheels or those of a slice."""

    def change(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
        factor = np.ones_like(car[field])
        if rows is None:
            factor = factor * (1.0 + deviation)
        else:
            factor[rows] = 1.0 + deviation
        car[field] = car[field] * factor

    return change


def factor_at(field: str) -> Change:
    def change(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
        factor = np.ones_like(car[field])
        factor[place] = 1.0 + deviation
        car[field] = car[field] * factor

    return change


def add(field: str, scale: float = 1.0) -> Change:
    def change(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
        car[field] = car[field] + scale * deviation

    return change


def add_at(field: str) -> Change:
    def change(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
        values = car[field].copy()
        values[place] += deviation
        car[field] = values

    return change


def sensor(field: str, *, factor: bool = False) -> Change:
    def change(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
        chain[field] = chain[field] * (1.0 + deviation) if factor else chain[field] + deviation

    return change


def sensor_at(field: str) -> Change:
    def change(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
        values = chain[field].copy()
        values[place] += deviation
        chain[field] = values

    return change


def both_stiffnesses(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    for field in ("stiffness_y_front", "stiffness_y_rear")[place : place + 1]:
        car[field] = car[field] * (1.0 + deviation)


def friction(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    """Peak friction in both directions; the slope at zero slip follows, as with the road's friction factor."""
    car["peak_x"], car["peak_y"] = car["peak_x"] * (1.0 + deviation), car["peak_y"] * (1.0 + deviation)


def relaxation(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    for field in ("relaxation_x", "relaxation_y"):
        car[field] = car[field] + deviation


def peak_shape(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    """Friction of the locked wheel over the peak falls by the deviation; peak and slope at zero stay."""
    shape, stiffness = float(car["shape_x"]), float(np.mean(car["stiffness_x"]))
    wanted = arctangent(1.0, shape, stiffness) - deviation
    low, high = 1.01, 1.95
    for _ in range(60):
        middle = 0.5 * (low + high)
        if arctangent(1.0, middle, stiffness * shape / middle) > wanted:
            low = middle
        else:
            high = middle
    car["stiffness_x"] = car["stiffness_x"] * shape / low
    car["shape_x"] = np.array(low)


def load_growth(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    car["radius_growth"] = car["radius_growth"] + deviation


def leak(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    """Deviation in cm^3/s at 100 bar."""
    leak = car["brake_leak"].copy()
    leak[place] += deviation * 1e-13
    car["brake_leak"] = leak


def air(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    air = car["air_volume"].copy()
    air[2 * place : 2 * place + 2] += deviation
    car["air_volume"] = air


def reflected(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    inertia = car["wheel_inertia"].copy()
    inertia[2:] += deviation
    car["wheel_inertia"] = inertia


def lateral_wind(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    car["side_wind"] = car["side_wind"] + deviation
