"""Wind over the road, compiled: a steady vector and gusts."""

import math

from numba import njit

from vehicle_model.plant_record import Record


@njit(cache=True)
def wind_at(road: Record, time: float) -> tuple[float, float]:
    """Velocity of the air in road axes [m/s]: steady, with (1 - cos)/2 gusts on top, once or again and again."""
    if road.gust_x == 0.0 and road.gust_y == 0.0:
        return road.wind_x, road.wind_y
    since = time - road.gust_start
    if since > 0.0 and road.gust_period > 0.0:
        since -= road.gust_period * math.floor(since / road.gust_period)
    if since <= 0.0 or since >= road.gust_duration:
        return road.wind_x, road.wind_y
    share = 0.5 * (1.0 - math.cos(2.0 * math.pi * since / road.gust_duration))
    return road.wind_x + share * road.gust_x, road.wind_y + share * road.gust_y
