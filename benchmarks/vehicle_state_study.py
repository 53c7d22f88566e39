"""The vehicle-state document's ABS study on both percentage bases, and the parameter sweeps of its 5.2.

``python -m benchmarks.vehicle_state_study [--json] [--without-sweeps]``; the sweeps change one number that the
observers know and leave the car as it is.
"""

import argparse
import json
from typing import Any

import numpy as np

import bench
import estimators
from bench.scenario.vehicle_choice import nominal_vehicle
from estimators.channels import CHANNELS
from vehicle_model.reference.planar_stops import abs_study, mean_percentages

_MASS, _HEIGHT = "body.mass", "body.centre_of_gravity_height"
_RADII = tuple(f"wheels.{wheel}.radius" for wheel in ("fl", "fr", "rl", "rr"))

SWEEPS: tuple[tuple[str, dict[str, float], dict[str, Any]], ...] = (
    ("as it is", {}, {}),
    ("mass -10 %", {_MASS: 0.9}, {}),
    ("mass +10 %", {_MASS: 1.1}, {}),
    ("height of the centre of gravity -10 %", {_HEIGHT: 0.9}, {}),
    ("height of the centre of gravity +10 %", {_HEIGHT: 1.1}, {}),
    ("radii -0.5 %", dict.fromkeys(_RADII, 0.995), {}),
    ("radii +0.5 %", dict.fromkeys(_RADII, 1.005), {}),
    ("shape C 1.3", {}, {"fit.shape": 1.3}),
    ("shape C 1.7", {}, {"fit.shape": 1.7}),
    ("k_max 12", {}, {"longitudinal.largest_slope": 12.0}),
    ("k_max 60", {}, {"longitudinal.largest_slope": 60.0}),
    ("step 5 ms", {}, {"lateral.step_time": 0.005}),
    ("step 20 ms", {}, {"lateral.step_time": 0.02}),
)
_LATERAL = ("lateral_acceleration", "yaw_rate", "slip_angle_fl", "slip_angle_rl")
_LONGITUDINAL = ("speed", "longitudinal_acceleration")
_TRUTH = {name: f"true_{name}" for name in ("lateral_acceleration", "yaw_rate", "longitudinal_acceleration")}


def _errors(run: bench.Run, names: tuple[str, ...], factors: dict[str, float], settings: dict[str, Any]) -> list[float]:
    """Relative errors of 4.1 over the mean magnitude [%], from 1 s on."""
    numbers = nominal_vehicle(run.scenario).numbers()
    changed = {path: value * factors.get(path, 1.0) for path, value in numbers.items()}
    estimator = estimators.create("magic_formula_fit" if "speed" in names else "vehicle_state_ukf", changed, settings)
    ages = {CHANNELS[name].age for name in estimator.inputs}
    found = estimator.replay(
        {name: run.data.array(name) for name in estimator.inputs}, {name: run.data.array(name) for name in ages}
    )
    places = {signal.name.partition(".")[2]: k for k, signal in enumerate(estimator.outputs)}
    part = run.data.array("time") > 1.0
    result = []
    for name in names:
        truth, estimate = run.data.array(_TRUTH.get(name, name))[part], found[part, places[name]]
        result.append(100.0 * float(np.sqrt(np.mean((truth - estimate) ** 2)) / np.mean(np.abs(truth))))
    return result


def sweeps() -> list[dict[str, Any]]:
    """Errors of the slalom on dry asphalt and of the launch on ice for every change."""
    slalom = bench.run("state/slalom_dry_asphalt", pacing="lockstep", record=False)
    launch = bench.run("state/launch_ice", pacing="lockstep", record=False)
    rows = []
    for name, factors, settings in SWEEPS:
        lateral = _errors(slalom, _LATERAL, factors, settings)
        longitudinal = _errors(launch, _LONGITUDINAL, factors, settings)
        figures = dict(zip((*_LATERAL, *_LONGITUDINAL), (*lateral, *longitudinal), strict=True))
        rows.append({"change": name, **{key: round(value, 2) for key, value in figures.items()}})
    return rows


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="JSON on standard output")
    parser.add_argument("--without-sweeps", action="store_true", help="only the ABS study")
    given = parser.parse_args()
    stops = [
        {
            "stop": stop.row.number,
            "surface": stop.row.surface,
            "distance_m": round(stop.distance_m, 1),
            "time_s": round(stop.time_s, 3),
            "distance_error_percent": round(100.0 * stop.distance_error, 1),
            "time_error_percent": round(100.0 * stop.time_error, 1),
            "saved_m": round(stop.row.abs_distance_m - stop.row.improved_distance_m, 1),
            "saved_s": round(stop.row.abs_time_s - stop.row.improved_time_s, 3),
        }
        for stop in abs_study()
    ]
    means = {surface: mean_percentages(surface) for surface in ("snow", "ice")}
    table = [] if given.without_sweeps else sweeps()
    if given.json:
        print(json.dumps({"stops": stops, "mean_percent": means, "sweeps": table}))
        return
    _print_table("ABS study: nine stops at the tabulated friction", stops)
    for surface, bases in means.items():
        own, source = bases["abs"], bases["improved"]
        print(f"{surface}: shorter by {own[0]:.1f} %, {own[1]:.1f} % of the ABS stop's distance and time;", end=" ")
        print(f"the source's base, the improved stop: {source[0]:.1f} %, {source[1]:.1f} %")
    if table:
        _print_table("\nSweeps: errors in % of the mean magnitude", table)


def _print_table(title: str, rows: list[dict[str, Any]]) -> None:
    print(title)
    widths = {key: max(len(key), *(len(str(row[key])) for row in rows)) for key in rows[0]}
    print("  ".join(f"{key:>{width}}" for key, width in widths.items()))
    for row in rows:
        print("  ".join(f"{row[key]!s:>{width}}" for key, width in widths.items()))


if __name__ == "__main__":
    main()
