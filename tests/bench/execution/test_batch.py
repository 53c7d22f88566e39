"""A batch of different cars: how they differ, that every number of workers gives the same, what is refused."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from bench.batch import row_table, run_batch, varied_cars
from bench.cli import app
from bench.execution.job import DONE
from signals.errors import InputError

SHORT = str(Path(__file__).parents[1] / "whole_runs" / "short_stop.yaml")
SCATTER = {"body.mass": "5 %", "brakes.front.pad_friction": "10 %"}


def column(scenarios: list, path: str) -> np.ndarray:
    return np.array([scenario.overrides[path] for scenario in scenarios])


def test_cars_scatter_as_told_each_parameter_with_numbers_of_its_own() -> None:
    cars = varied_cars(SHORT, 400, SCATTER, seed=3)
    mass = column(cars, "body.mass")
    assert mass.mean() == pytest.approx(1296.0, rel=4 * 0.05 / 20)  # Table 8, four standard errors of 400 cars
    assert mass.std() / 1296.0 == pytest.approx(0.05, rel=0.15)
    assert column(cars, "brakes.front.pad_friction").std() / 0.4 == pytest.approx(0.1, rel=0.15)
    alone = varied_cars(SHORT, 400, {"body.mass": "5 %"}, seed=3)
    assert np.array_equal(column(alone, "body.mass"), mass)
    assert not np.array_equal(column(varied_cars(SHORT, 400, SCATTER, seed=4), "body.mass"), mass)
    assert [car.seed for car in cars[:3]] == [cars[0].seed, cars[0].seed + 1, cars[0].seed + 2]


def test_absolute_scatter_takes_units_and_stays_in_range() -> None:
    cars = varied_cars(SHORT, 300, {"body.mass": "20 kg", "hydraulics.inlet_delay_fl": "5 ms"}, seed=1)
    assert column(cars, "body.mass").std() == pytest.approx(20.0, rel=0.15)
    delays = column(cars, "hydraulics.inlet_delay_fl")
    assert delays.min() >= 0.0  # a half of a normal distribution: mean 5 ms sqrt(2/pi)
    assert delays.mean() == pytest.approx(5e-3 * np.sqrt(2 / np.pi), rel=0.15)


def test_roads_scatter_too() -> None:
    cars = varied_cars(SHORT, 200, {"road.friction": "5 %"})
    friction = np.array([car.road.friction for car in cars])
    assert friction.std() / friction.mean() == pytest.approx(0.05, rel=0.2)
    assert all("road.friction" not in car.overrides for car in cars)


def test_vehicles_are_taken_in_turn() -> None:
    cars = varied_cars(SHORT, 4, vehicles=("ekf_car", "baseline_car"))
    assert [Path(car.vehicle).stem for car in cars] == ["ekf_car", "baseline_car"] * 2


@pytest.mark.parametrize(
    ("scatter", "message"),
    [
        ({"body.mas": "5 %"}, r"did you mean body\.mass\?"),
        ({"body.mass": "5 m"}, "wrong dimension"),
        ({"body.mass": -20.0}, "allowed: not negative"),
    ],
)
def test_bad_scatter_is_refused(scatter: dict[str, float | str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        varied_cars(SHORT, 2, scatter)


def test_one_and_two_workers_give_the_same_rows_in_the_order_of_the_cars() -> None:
    cars = varied_cars(SHORT, 4, SCATTER)
    one, two = (run_batch(cars, workers=workers) for workers in (1, 2))
    assert [row.key for row in two.rows] == ["0", "1", "2", "3"]
    assert [row.metrics for row in one.rows] == [row.metrics for row in two.rows]
    assert all(row.outcome == DONE for row in one.rows)
    assert two.simulated_s > 4 * 0.5
    table = row_table(cars, two.rows)
    assert [entry["body.mass"] for entry in table] == [car.overrides["body.mass"] for car in cars]
    assert len({row.scenario_hash for row in two.rows}) == 4


def test_command_prints_plain_data_and_writes_a_row_per_car(tmp_path: Path) -> None:
    table = tmp_path / "rows.csv"
    arguments = [
        "batch",
        SHORT,
        "--cars",
        "2",
        "--scatter",
        "body.mass=5%",
        "--workers",
        "1",
        "--out",
        str(table),
        "--json",
    ]
    result = CliRunner().invoke(app, arguments)
    data = json.loads(result.stdout)
    assert data["cars"] == 2 == len(data["rows"])
    assert sum(data["verdicts"].values()) == 2
    lines = table.read_text().splitlines()
    assert len(lines) == 3
    assert "body.mass" in lines[0].split(",")
