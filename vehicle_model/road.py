"""The road in compiled form: friction and surface under a wheel, direction of gravity, wind.

``RoadTables`` holds the numbers of a road file in arrays that the compiled plant reads; ``set`` changes any of them
while the car drives.
"""

import math
from collections.abc import Iterator

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vehicle_model import parameters
from vehicle_model.plant_record import Record
from vehicle_model.road_file import RoadFile, Surface
from vehicle_model.roughness import POINTS, SPACING_M, two_tracks
from vehicle_model.tyres.coefficients import (
    SURFACE_CURVE,
    SURFACE_FACTOR,
    SURFACE_KIND,
    SURFACE_REPLACES,
    SURFACE_SIZE,
    write_curve,
)
from vehicle_model.wet_friction import wet_factor

ROAD_RECORD = np.dtype(
    [
        ("friction", "f8"),
        ("surface", "i8"),
        ("split", "f8"),
        ("side_friction", "f8", (2,)),  # right, left
        ("side_surface", "i8", (2,)),
        ("grade", "f8"),
        ("bank", "f8"),
        ("wind_x", "f8"),
        ("wind_y", "f8"),
        ("gust_x", "f8"),
        ("gust_y", "f8"),
        ("gust_start", "f8"),
        ("gust_duration", "f8"),
        ("gust_period", "f8"),
        ("gravity", "f8"),
        ("jumps", "i8"),
        ("patches", "i8"),
        ("points", "i8"),
        ("surfaces", "i8"),
        ("rough", "i8"),
        ("wet", "i8"),
        ("water_film", "f8"),
        ("tread_wear", "f8"),
        ("speed_share", "f8"),
    ],
    align=True,
)
# rows of the tables
JUMP_BY_TIME, JUMP_AT, JUMP_FRICTION, JUMP_TRANSITION, JUMP_SURFACE, JUMP_SIZE = 0, 1, 2, 3, 4, 5
PATCH_FRICTION, PATCH_SURFACE, PATCH_WATER, PATCH_SIZE = 4, 5, 6, 7
POINT_SIZE = 3
_NONE = -1


class RoadTables:
    """Arrays of a road.

    Parameters
    ----------
    road : RoadFile
        A copy of it is kept; later changes go through ``set``.

    Attributes
    ----------
    record : shape (1,), dtype ``ROAD_RECORD``
    jumps, patches, points, surfaces : two-dimensional arrays
        Jumps (those by position before those by time, each in rising order), patches in file order, points of the
        profile, surfaces.
    heights : shape (2, POINTS), m
        Of the left and the right track, see ``vehicle_model.roughness``; zero on a smooth road.
    """

    def __init__(self, road: RoadFile) -> None:
        self.road = road.model_copy(deep=True)
        self._surfaces = self.road.used_surfaces()
        self._numbers = {name: number for number, name in enumerate(self._surfaces)}
        self.record = np.zeros(1, ROAD_RECORD)
        self.jumps = np.zeros((len(road.jumps), JUMP_SIZE))
        self.patches = np.zeros((len(road.patches), PATCH_SIZE))
        self.points = np.zeros((len(road.profile), POINT_SIZE))
        self.surfaces = np.zeros((len(self._surfaces), SURFACE_SIZE))
        self.heights = np.zeros((2, POINTS))
        self._unit_heights = self.heights  # of a road whose level is 1 m^3
        self._unit_heights_of: tuple[float, ...] = ()
        self._fill()

    def names(self) -> Iterator[str]:
        """Paths of all parameters (``road.friction``, ``road.patches.0.friction``)."""
        return iter(self.road.numbers())

    def get(self, path: str) -> float:
        """Value of one parameter."""
        return parameters.get_parameter(self.road, path, "road.")

    def set(self, path: str, value: float | str) -> None:
        """Change one parameter (a number in SI units, or a text with its unit)."""
        if path == "road.friction":  # the usual one, each tick of a ramp: no need to fill everything
            parameters.set_parameter(self.road, path, value, "road.")
            self.record["friction"] = self.road.friction
            return
        parameters.set_parameter(self.road, path, value, "road.")
        self._fill()

    def _surface(self, name: str | None) -> int:
        return _NONE if name is None else self._numbers[name]

    def _fill(self) -> None:
        road = self.road
        self.record["friction"] = road.friction
        self.record["surface"] = self._surface(road.surface)
        self.record["split"] = road.split_position
        self.record["side_friction"] = (road.right.friction, road.left.friction)
        self.record["side_surface"] = (self._surface(road.right.surface), self._surface(road.left.surface))
        self.record["grade"], self.record["bank"] = road.grade, road.bank
        self.record["wind_x"], self.record["wind_y"] = road.wind_speed_x, road.wind_speed_y
        gust = road.gust
        self.record["gust_x"], self.record["gust_y"] = gust.speed_x, gust.speed_y
        self.record["gust_start"], self.record["gust_duration"] = gust.start, gust.duration
        self.record["gust_period"] = gust.period
        self.record["gravity"] = road.gravity
        self.record["jumps"], self.record["patches"] = len(self.jumps), len(self.patches)
        self.record["points"], self.record["surfaces"] = len(self.points), len(self.surfaces)
        water = road.water
        self.record["water_film"], self.record["tread_wear"] = water.film, water.tread_wear
        self.record["speed_share"] = water.speed_dependence
        films = [patch.water_film for patch in road.patches if patch.water_film is not None]
        self.record["wet"] = any(value != 0.0 for value in (water.film, water.speed_dependence, *films))
        self._fill_heights()
        rows = [
            (
                0.0 if jump.time is None else 1.0,
                jump.position if jump.time is None else jump.time,
                jump.friction,
                jump.transition_length if jump.time is None else jump.transition_time,
                self._surface(jump.surface),
            )
            for jump in road.jumps
        ]
        if rows:
            self.jumps[:] = sorted(rows, key=lambda row: (row[0], row[1]))
        for number, patch in enumerate(road.patches):
            corners = (patch.x_from, patch.x_to, patch.y_from, patch.y_to)
            film = road.water.film if patch.water_film is None else patch.water_film
            self.patches[number] = (*corners, patch.friction, self._surface(patch.surface), film)
        for number, point in enumerate(road.profile):
            self.points[number] = (point.position, point.grade, point.bank)
        for surface, row in zip(self._surfaces.values(), self.surfaces, strict=True):
            _write_surface(surface, row)

    def _fill_heights(self) -> None:
        rough = self.road.roughness
        self.record["rough"] = rough.level != 0.0
        if rough.level == 0.0:
            return
        wanted = (rough.waviness, rough.track, rough.realisation)
        if wanted != self._unit_heights_of:
            self._unit_heights, self._unit_heights_of = two_tracks(1.0, *wanted), wanted
        self.heights[:] = math.sqrt(rough.level) * self._unit_heights


def _write_surface(surface: Surface, row: NDArray[np.float64]) -> None:
    row[SURFACE_FACTOR] = 1.0 if surface.factor is None else surface.factor
    if surface.curve is not None:
        row[SURFACE_REPLACES] = 1.0
        row[SURFACE_KIND] = write_curve(surface.curve, row[SURFACE_CURVE:])


@njit(cache=True)
def friction_at(
    road: Record,
    jumps: NDArray[np.float64],
    patches: NDArray[np.float64],
    x: float,
    y: float,
    time: float,
) -> tuple[float, int]:
    """Friction factor and number of the surface at a place and time.

    A patch replaces jumps and split; otherwise the jumps by position and by time and the side multiply.
    """
    for k in range(road.patches - 1, -1, -1):
        if patches[k, 0] <= x < patches[k, 1] and patches[k, 2] <= y < patches[k, 3]:
            surface = int(patches[k, PATCH_SURFACE])
            return road.friction * patches[k, PATCH_FRICTION], surface if surface >= 0 else road.surface
    surface = road.surface
    factor = road.friction
    by_place = by_time = 1.0
    for k in range(road.jumps):
        timed = jumps[k, JUMP_BY_TIME] != 0.0
        since = (time if timed else x) - jumps[k, JUMP_AT]
        if since < 0.0:
            continue
        level = jumps[k, JUMP_FRICTION]
        transition = jumps[k, JUMP_TRANSITION]
        before = by_time if timed else by_place
        if since < transition:
            level = before + (level - before) * since / transition
        if timed:
            by_time = level
        else:
            by_place = level
        if jumps[k, JUMP_SURFACE] >= 0.0:
            surface = int(jumps[k, JUMP_SURFACE])
    side = 1 if y >= road.split else 0
    if road.side_surface[side] >= 0:
        surface = road.side_surface[side]
    return factor * (by_place * by_time) * road.side_friction[side], surface


@njit(cache=True)
def water_factor_at(road: Record, patches: NDArray[np.float64], x: float, y: float, speed: float) -> float:
    """Factor on friction for the water at a place and the wheel's speed [m/s]; exactly 1 on a dry road."""
    if road.wet == 0:
        return 1.0
    depth = road.water_film
    for k in range(road.patches - 1, -1, -1):
        if patches[k, 0] <= x < patches[k, 1] and patches[k, 2] <= y < patches[k, 3]:
            depth = patches[k, PATCH_WATER]
            break
    return wet_factor(road, depth, speed)


@njit(cache=True)
def height_at(heights: NDArray[np.float64], side: int, x: float) -> tuple[float, float]:
    """Height [m] and slope of a track (0 left, 1 right) at a place: a cubic through four points, its slope smooth."""
    place = x / SPACING_M
    whole = math.floor(place)
    t = place - whole
    k = int(whole)
    a, b = heights[side, (k - 1) & (POINTS - 1)], heights[side, k & (POINTS - 1)]
    c, d = heights[side, (k + 1) & (POINTS - 1)], heights[side, (k + 2) & (POINTS - 1)]
    # Catmull-Rom: the slope at a point is that of the line through its neighbours
    p, q, r = 0.5 * (c - a), a - 2.5 * b + 2.0 * c - 0.5 * d, 1.5 * (b - c) + 0.5 * (d - a)
    return b + t * (p + t * (q + t * r)), (p + t * (2.0 * q + 3.0 * t * r)) / SPACING_M


@njit(cache=True)
def slopes_at(road: Record, points: NDArray[np.float64], x: float) -> tuple[float, float]:
    """Grade and bank (rise over run) at a place: the constant ones plus the profile."""
    grade, bank = road.grade, road.bank
    count = road.points
    if count == 0:
        return grade, bank
    if x <= points[0, 0]:
        return grade + points[0, 1], bank + points[0, 2]
    for k in range(1, count):
        if x < points[k, 0]:
            share = (x - points[k - 1, 0]) / (points[k, 0] - points[k - 1, 0])
            return (
                grade + points[k - 1, 1] + share * (points[k, 1] - points[k - 1, 1]),
                bank + points[k - 1, 2] + share * (points[k, 2] - points[k - 1, 2]),
            )
    return grade + points[count - 1, 1], bank + points[count - 1, 2]


@njit(cache=True)
def write_gravity(magnitude: float, grade: float, bank: float, gravity: NDArray[np.float64]) -> None:
    """Gravity in the road's axes: uphill grade pulls backwards, a bank to the left pulls to the right."""
    scale = -magnitude / math.sqrt(1.0 + grade * grade + bank * bank)
    gravity[0], gravity[1], gravity[2] = scale * grade, scale * bank, scale
