"""Pictures of roads: the map's numbers, what is drawn for which road, the command."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from bench.cli import app
from bench.report.road_picture import draw_road, friction_map, usual_stretch
from signals.errors import InputError
from vehicle_model.road import RoadTables
from vehicle_model.road_file import Jump, RoadFile, Water, load_road, load_surfaces, road_names

RUNNER = CliRunner()


def test_map_shows_patches_sides_jumps_and_water() -> None:
    along, across = np.array([10.0, 22.0, 27.0, 62.0]), np.array([-1.0, 1.0])
    checkered = friction_map(RoadTables(load_road("checkerboard")), along, across, 0.0, 20.0)
    assert checkered == pytest.approx(np.array([[1.0, 1.0, 0.3, 1.0], [1.0, 0.3, 1.0, 1.0]]))
    split = friction_map(RoadTables(load_road("r13h_split")), along, across, 0.0, 20.0)
    assert split == pytest.approx(np.array([[0.8] * 4, [0.3] * 4]))
    wet = RoadFile(surface="dry_asphalt", water=Water(film=1e-3))
    assert friction_map(RoadTables(wet), along, across, 0.0, 90 / 3.6) == pytest.approx(0.3 / 0.8)  # Table 1
    timed = RoadFile(surface="ice", jumps=[Jump(time=2.0, friction=0.5)])
    # Table 2: ice peaks at 0.1
    assert friction_map(RoadTables(timed), along, across, 0.0, 20.0) == pytest.approx(0.1)
    assert friction_map(RoadTables(timed), along, across, 3.0, 20.0) == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("name", "peak"),
    # Tables 2 and 3 of the friction document, column "µ peak"
    [
        ("dry_asphalt", 1.0),
        ("wet_asphalt", 0.82),
        ("snow", 0.3),
        ("burckhardt_dry_asphalt", 1.17),
        ("burckhardt_snow", 0.19),
    ],
)
def test_peak_of_a_surface_is_that_of_its_table(name: str, peak: float) -> None:
    assert load_surfaces()[name].peak_friction() == pytest.approx(peak, abs=1e-3)


def test_usual_stretch_holds_everything_that_changes() -> None:
    assert usual_stretch(load_road("checkerboard")) == pytest.approx((-10.0, 70.0))
    assert usual_stretch(load_road("dry")) == pytest.approx((-15.0, 115.0))
    low, high = usual_stretch(load_road("r13h_jump_down"))  # its first jump lies 1 km behind the start
    assert low < 0.0
    assert 60.0 < high < 100.0


@pytest.mark.parametrize("name", ["puddle", "iso_8608_c"])
def test_smooth_road_has_two_charts_a_rough_one_four(name: str, tmp_path: Path) -> None:
    from matplotlib.image import imread

    picture = imread(draw_road(load_road(name), tmp_path / "road.png", along=(0.0, 50.0)))
    assert picture.shape[1] == 1210
    assert picture.shape[0] == (1056 if name == "iso_8608_c" else 572)
    assert 0.2 < picture[:, :, :3].mean() < 0.99


def test_other_endings_and_empty_stretches_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"allowed: \.png, \.svg, \.pdf"):
        draw_road(RoadFile(), tmp_path / "road.bmp")
    with pytest.raises(InputError, match="its end behind its start"):
        draw_road(RoadFile(), tmp_path / "road.png", along=(5.0, 5.0))


def test_commands_list_and_plot_roads(tmp_path: Path) -> None:
    listed = json.loads(RUNNER.invoke(app, ["road", "list", "--json"]).stdout)
    assert set(listed) == set(road_names())
    assert all(listed.values())
    table = json.loads(RUNNER.invoke(app, ["road", "list", "puddle", "--json"]).stdout)
    assert {"road.water.film", "road.patches.0.water_film"} <= {row["path"] for row in table}
    out = tmp_path / "wet.svg"
    arguments = ["road", "plot", "wet", "--out", str(out), "--set", "road.grade=5 %", "--json"]
    shown = json.loads(RUNNER.invoke(app, arguments).stdout)
    assert shown["picture"] == str(out)
    assert out.read_text("utf-8").startswith("<?xml")
