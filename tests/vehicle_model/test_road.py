"""The road: friction by place and time, sides, patches, surfaces, slopes."""

import math
from pathlib import Path

import numpy as np
import pytest

from signals.errors import InputError
from vehicle_model.road import RoadTables, friction_at, slopes_at, write_gravity
from vehicle_model.road_file import Jump, Patch, ProfilePoint, RoadFile, Side, load_road, load_surfaces, road_names


def friction(road: RoadTables, x: float, y: float = 0.0, time: float = 0.0) -> float:
    return float(friction_at(road.record[0], road.jumps, road.patches, x, y, time)[0])


def surface(road: RoadTables, x: float, y: float = 0.0, time: float = 0.0) -> str:
    number = friction_at(road.record[0], road.jumps, road.patches, x, y, time)[1]
    return road.road.surface_names()[number]


def test_jumps_by_position_in_any_order_with_transition() -> None:
    jumps = [Jump(position=100.0, friction=0.9), Jump(position=50.0, friction=0.5, transition_length=10.0)]
    road = RoadTables(RoadFile(friction=1.1, jumps=jumps))
    assert friction(road, 49.9) == pytest.approx(1.1)
    assert friction(road, 55.0) == pytest.approx(1.1 * 0.75)
    assert friction(road, 60.0) == pytest.approx(1.1 * 0.5)
    assert friction(road, 100.0) == pytest.approx(1.1 * 0.9)


def test_jump_by_time_within_0_3_s() -> None:
    road = RoadTables(RoadFile(jumps=[Jump(time=2.0, friction=0.6, transition_time=0.3)]))
    assert friction(road, 0.0, time=1.999) == 1.0
    assert friction(road, 0.0, time=2.15) == pytest.approx(0.8)
    assert friction(road, 0.0, time=2.3) == pytest.approx(0.6)


def test_split_and_patches() -> None:
    road = RoadTables(
        RoadFile(
            right=Side(friction=0.2, surface="ice"),
            split_position=0.5,
            patches=[
                Patch(x_from=10.0, x_to=20.0, friction=0.7),
                Patch(x_from=15.0, x_to=16.0, y_from=0.0, y_to=1.0, friction=0.1, surface="snow"),
            ],
        )
    )
    assert friction(road, 0.0, 0.6) == 1.0
    assert friction(road, 0.0, 0.4) == pytest.approx(0.2)
    assert surface(road, 0.0, 0.4) == "ice"
    assert surface(road, 0.0, 0.6) == "own_curve"
    assert friction(road, 10.0, -3.0) == pytest.approx(0.7)
    assert surface(road, 10.0, -3.0) == "own_curve"  # a patch lies on top of the split
    assert (friction(road, 15.5, 0.5), surface(road, 15.5, 0.5)) == (pytest.approx(0.1), "snow")
    road.set("road.patches.1.friction", 0.3)
    road.set("road.friction", 0.5)
    assert friction(road, 15.5, 0.5) == pytest.approx(0.15)


def test_slopes_and_gravity() -> None:
    road = RoadTables(
        RoadFile(grade=0.01, profile=[ProfilePoint(position=0.0), ProfilePoint(position=100.0, grade=0.1, bank=-0.04)])
    )
    assert slopes_at(road.record[0], road.points, -5.0) == pytest.approx((0.01, 0.0))
    assert slopes_at(road.record[0], road.points, 50.0) == pytest.approx((0.06, -0.02))
    assert slopes_at(road.record[0], road.points, 500.0) == pytest.approx((0.11, -0.04))
    gravity = np.zeros(3)
    write_gravity(9.81, 0.1, 0.0, gravity)
    angle = math.atan(0.1)
    np.testing.assert_allclose(gravity, [-9.81 * math.sin(angle), 0.0, -9.81 * math.cos(angle)])
    write_gravity(9.81, 0.0, 0.05, gravity)
    assert gravity[1] < 0.0  # the left side is higher: gravity pulls to the right
    assert np.linalg.norm(gravity) == pytest.approx(9.81)


def test_shipped_surfaces_are_those_of_the_tables() -> None:
    known = load_surfaces()
    assert {"dry_asphalt", "wet_asphalt", "snow", "ice", "polished_ice", "burckhardt_dry_concrete"} <= known.keys()
    assert known["wet_asphalt"].curve.shape == 2.3  # type: ignore[union-attr]
    assert known["burckhardt_dry_concrete"].curve.c3 == 0.5357  # type: ignore[union-attr]
    assert all(entry.source for name, entry in known.items() if name != "own_curve")


def test_shipped_roads_are_valid() -> None:
    assert {"dry", "wet", "snow", "ice", "polished_ice", "mu_split"} <= set(road_names())
    for name in road_names():
        road = load_road(name)
        assert road.name == name
        RoadTables(road)


def test_a_surface_of_the_user(tmp_path: Path) -> None:
    file = tmp_path / "road.yaml"
    file.write_text("format: 1\nname: mine\nsurface: gravel\nsurfaces: {gravel: {factor: 0.6}}\n")
    road = RoadTables(load_road(file))
    assert friction(road, 0.0) == 1.0
    assert road.surfaces[0, 1] == 0.6


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("surface: dry_asfalt\n", "did you mean dry_asphalt"),
        ("friction: 12\n", "0…3"),
        ("jumps: [{position: 3, time: 2}]\n", "position or time"),
        ("jumps: [{position: 3, transition_time: 1 s}]\n", "transition_length with position"),
        ("patches: [{x_from: 3, x_to: 2}]\n", "empty rectangle"),
        ("profile: [{position: 3}, {position: 3}]\n", "strictly rising"),
        ("grade: 3 km\n", "grade"),
        ("surfaces: {a: {}}\n", "factor"),
    ],
)
def test_faults_name_the_field(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "road.yaml"
    file.write_text("format: 1\nname: road\n" + text)
    with pytest.raises(InputError) as caught:
        load_road(file)
    assert message in str(caught.value)
