"""Friction over speed and water film: Table 1 of the friction document."""

import numpy as np
import pytest

from vehicle_model import Plant, load_vehicle
from vehicle_model.road import RoadTables, water_factor_at
from vehicle_model.road_file import Patch, RoadFile, Water

# friction document, Table 1 (l. 278-288): speed km/h, tread, dry, 0.2 mm, 1 mm, 2 mm
TABLE_1 = [
    (50, 0.0, 0.85, 0.65, 0.55, 0.5),
    (50, 1.0, 1.0, 0.5, 0.4, 0.25),
    (90, 0.0, 0.8, 0.6, 0.3, 0.05),
    (90, 1.0, 0.95, 0.2, 0.1, 0.05),
    (130, 0.0, 0.75, 0.55, 0.2, 0.0),
    (130, 1.0, 0.9, 0.2, 0.1, 0.0),
]


def factor(water: Water, speed_km_h: float, **road: object) -> float:
    tables = RoadTables(RoadFile(water=water, **road))
    return float(water_factor_at(tables.record[0], tables.patches, 5.0, 0.0, speed_km_h / 3.6))


@pytest.mark.parametrize(("speed", "wear", "dry", "thin", "medium", "deep"), TABLE_1)
def test_every_cell_of_table_1(speed: float, wear: float, dry: float, thin: float, medium: float, deep: float) -> None:
    for depth, value in ((0.2e-3, thin), (1e-3, medium), (2e-3, deep)):
        assert factor(Water(film=depth, tread_wear=wear), speed) == pytest.approx(value / dry, abs=1e-12)
    at_50 = 1.0 if wear else 0.85
    assert factor(Water(speed_dependence=1.0, tread_wear=wear), speed) == pytest.approx(dry / at_50, abs=1e-12)
    # both together are the table's value over the dry one at 50 km/h
    both = factor(Water(film=1e-3, speed_dependence=1.0, tread_wear=wear), speed)
    assert both == pytest.approx(medium / at_50, abs=1e-12)


def test_between_the_cells_linear_and_beyond_them_constant() -> None:
    new = Water(film=1e-3)
    assert factor(new, 70) == pytest.approx((0.55 + 0.3) / (0.85 + 0.8), abs=1e-12)
    assert factor(new, 20) == factor(new, 50)
    assert factor(new, 180) == factor(new, 130)
    assert factor(Water(film=0.6e-3), 50) == pytest.approx(0.6 / 0.85, abs=1e-12)
    assert factor(Water(film=8e-3), 90) == factor(Water(film=2e-3), 90)
    half_worn = factor(Water(film=1e-3, tread_wear=0.5), 90)
    assert half_worn == pytest.approx((0.3 + 0.1) / (0.8 + 0.95), abs=1e-12)


def test_dry_road_is_exactly_one_and_a_puddle_lies_where_its_patch_is() -> None:
    assert factor(Water(), 130) == 1.0
    puddle = [Patch(x_from=0.0, x_to=10.0, water_film=2e-3)]
    assert factor(Water(), 90, patches=puddle) == pytest.approx(0.05 / 0.8, abs=1e-12)
    outside = [Patch(x_from=20.0, x_to=30.0, water_film=2e-3)]
    assert factor(Water(), 90, patches=outside) == 1.0
    dry_place = [Patch(x_from=0.0, x_to=10.0, water_film=0.0)]
    assert factor(Water(film=1e-3), 90, patches=dry_place) == 1.0


def test_single_track_meets_the_same_water() -> None:
    from vehicle_model.reference.single_track import SingleTrack

    twin = SingleTrack(load_vehicle("ekf_car"), RoadFile(surface="dry_asphalt", water=Water(film=1e-3)))
    twin.reset(speed_m_s=90 / 3.6)
    twin.step(1)
    assert twin.state()["friction_limit_fl"] == pytest.approx(0.3 / 0.8, rel=1e-3)


def test_car_brakes_with_the_friction_of_the_film_and_its_speed() -> None:
    car = Plant(load_vehicle("ekf_car"), RoadFile(surface="dry_asphalt", water=Water(film=1e-3)))
    for speed, ratio in ((130.0, 0.2 / 0.75), (50.0, 0.55 / 0.85)):
        car.reset(speed_m_s=speed / 3.6)
        car.step(1)
        assert car.state()["friction_limit_fl"] == pytest.approx(ratio, rel=1e-3)  # the curve's peak is 1
    car.reset(speed_m_s=130 / 3.6)
    stops = []
    for film in (0.0, 1e-3):
        car.set("road.water.film", film)
        car.reset(speed_m_s=130 / 3.6)
        car.step(1500, brake_torque=3000.0)
        stops.append(car.state()["speed"])
    assert np.diff(stops)[0] > 5.0
