"""``bench vehicle fit``: a vehicle file calibrated on logs of a healthy car."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from bench.diagnosis.diagnosing import Progress, car_name, read
from bench.diagnosis_report.words import plain, signal_words
from bench.report.formatting import number
from model_diagnosis.data.repeated import refuse_repeats
from signals.measured.channel_map import load_channel_map
from vehicle_model.vehicle_file import VehicleFile, load_vehicle

if TYPE_CHECKING:
    from model_diagnosis.vehicle_fit import Calibrated, VehicleFit

_HEADER = "Calibrated by `bench vehicle fit` on logs of a healthy car; `scatter` is what the logs leave open."


@dataclass(frozen=True)
class FittedVehicle:
    """Result and file of a fit."""

    fit: "VehicleFit"
    file: Path

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "file": str(self.file),
            "parameters": [
                {
                    "effect": one.effect,
                    "values": one.values,
                    "nominal": one.nominal,
                    "low": one.low,
                    "high": one.high,
                    "scatters_off": one.scatters_off,
                    "scatter": one.scatter.model_dump(),
                }
                for one in self.fit.calibrated
            ],
            "misfit": {signal: {"before": a, "after": b} for signal, (a, b) in self.fit.misfit.items()},
            "far_off": self.fit.far_off,
            "data_faults": [fault.model_dump() for fault in self.fit.faults],
        }


def fit(
    logs: Sequence[str],
    vehicle: str | None,
    *,
    channels: Path | None = None,
    out: Path | None = None,
    progress: Progress | None = None,
) -> FittedVehicle:
    """Fit a car to logs and write the vehicle file.

    Raises
    ------
    InputError
        If a log, the map or the vehicle file cannot be read.
    """
    channel_map = None if channels is None else load_channel_map(channels)
    name = car_name(logs, vehicle, channel_map)
    car = load_vehicle(name)
    manoeuvres = read(logs, car, channel_map)
    refuse_repeats(manoeuvres)
    from model_diagnosis.vehicle_fit import fit_vehicle

    result = fit_vehicle(manoeuvres, car, progress)
    path = out or Path(f"{Path(name).stem}_fitted.yaml")
    write_fitted(path, name, car, result, logs)
    return FittedVehicle(result, path)


def write_fitted(
    path: Path, vehicle_argument: str, vehicle: VehicleFile, fit: "VehicleFit", logs: Sequence[str]
) -> None:
    """Write the vehicle file: the given one with the calibrated values as an extension, and their scatter."""
    from ruamel.yaml import YAML

    given = Path(vehicle_argument)
    is_file = given.suffix in (".yaml", ".yml")
    content: dict[str, Any] = {
        "format": 1,
        "name": f"{vehicle.name}_fitted",
        "description": f"{vehicle.name} calibrated on {', '.join(Path(log).name for log in logs)}",
        "extends": os.path.relpath(given.resolve(), path.parent.resolve()) if is_file else vehicle_argument,
        "extensions": [_extension(one) for one in fit.calibrated],
        "scatter": {pattern: one.scatter.model_dump() for one in fit.calibrated for pattern in one.values},
    }
    if not content["extensions"]:
        del content["extensions"], content["scatter"]
    yaml = YAML()
    yaml.width = 110
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.partial")
    with partial.open("w", encoding="utf-8") as stream:
        stream.write(f"# {_HEADER}\n")
        yaml.dump(content, stream)
    os.replace(partial, path)


def print_fit(result: FittedVehicle, console: Console) -> None:
    """Print a fit for people."""
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="dim")
    for head in ("parameter", "file", "fitted", "90 % interval", "scatters off"):
        table.add_column(head, justify="left" if head in ("parameter", "90 % interval") else "right")
    for one in result.fit.calibrated:
        for path, value in one.values.items():
            interval = f"{number(one.low[path], 3)} … {number(one.high[path], 3)}"
            off = f"{one.scatters_off:+.1f}".replace("-", "−")
            table.add_row(path, number(one.nominal[path]), number(value), interval, off)
    console.print(table)
    console.print("\nresidual over the sensor's noise, by the file and fitted", style="dim")
    for signal, (before, after) in result.fit.misfit.items():
        console.print(f"  {signal_words(signal):<30} {number(before, 3):>8} → {number(after, 3)}", markup=False)
    for name in result.fit.far_off:
        console.print(f"[yellow]{plain(name)} is more than three scatters off: is this car healthy? bench diagnose[/]")
    console.print(f"\nfile: {result.file}", markup=False)
    console.print(f"next: bench diagnose LOG --vehicle {result.file}", markup=False)


def _extension(one: "Calibrated") -> dict[str, Any]:
    return {
        "effect": one.effect,
        "parameters": dict(one.values),
        "intervals": {path: [one.low[path], one.high[path]] for path in one.values},
        "evidence": f"fit to a healthy car, {one.scatters_off:+.1f} scatters off",
    }
