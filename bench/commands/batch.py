"""``bench batch``: many cars through one scenario, on all cores."""

import csv
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bench.commands.options import JsonOption, SetOption, finish, print_json

if TYPE_CHECKING:
    from bench.batch import BatchResult

_SHOWN = ("stopping_distance_m", "mfdd_m_s2", "slip_mean", "yaw_rad", "lateral_offset_m")


def batch(
    scenario: Annotated[str, typer.Argument(help="Path of a scenario file, or the id of one.")],
    cars: Annotated[int, typer.Option(min=1, help="Number of cars.")] = 64,
    scatter: Annotated[
        list[str] | None,
        typer.Option(metavar="PATH=STD", help="Standard deviation of a parameter: 5 % of its value, or 20 kg; repeat."),
    ] = None,
    vehicle: Annotated[
        list[str] | None, typer.Option(help="Cars to take in turn; repeat. Default: the scenario's.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the scatter.")] = 1,
    workers: Annotated[int | None, typer.Option(min=1, help="Processes. Default: one per core.")] = None,
    sets: SetOption = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="A row per car, .csv.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Run many cars through a scenario in virtual time, on all cores, and sum up what they did.

    Examples: bench batch stops/dry --cars 64 --scatter body.mass=5% --scatter brakes.front.pad_friction=10%

    bench batch stops/wet --vehicle ekf_car --vehicle baseline_car --cars 8 --out wet.csv
    """
    from bench.batch import row_table, run_batch, varied_cars
    from bench.verdict.result import EXIT_CODES, worst
    from signals.errors import InputError

    if out is not None and out.suffix.lower() != ".csv":
        raise InputError(f"{out}: unknown kind of table", allowed=".csv")
    scenarios = varied_cars(scenario, cars, _scatter(scatter or []), seed=seed, vehicles=vehicle or (), sets=sets or ())
    result = run_batch(scenarios, workers=workers, progress=None if as_json else _progress)
    if out is not None:
        _write(out, row_table(scenarios, result.rows))
    if as_json:
        print_json({**_summary(result), "rows": [row.as_json() for row in result.rows]})
    else:
        _print(result, out)
    finish(EXIT_CODES[worst(row.verdict for row in result.rows)])


def _scatter(texts: list[str]) -> dict[str, float | str]:
    from bench.scenario.documents import parse_sets

    return {path: value if isinstance(value, (int, float)) else str(value) for path, value in parse_sets(texts).items()}


def _progress(done: int, total: int) -> None:
    if sys.stderr.isatty():
        print(f"\r{done} of {total} cars", end="\n" if done == total else "", file=sys.stderr, flush=True)


def _summary(result: "BatchResult") -> dict[str, Any]:
    names = ("mean", "standard_deviation", "smallest", "largest")
    verdicts: dict[str, int] = {}
    for row in result.rows:
        verdicts[row.verdict] = verdicts.get(row.verdict, 0) + 1
    return {
        "cars": len(result.rows),
        "verdicts": verdicts,
        "metrics": {name: dict(zip(names, values, strict=True)) for name, values in result.figures().items()},
        "workers": result.workers,
        "wall_s": result.wall_s,
        "start_s": result.start_s,
        "runs_per_hour": result.runs_per_hour,
        "real_time_factor": result.real_time_factor,
    }


def _print(result: "BatchResult", out: Path | None) -> None:
    summary = _summary(result)
    counts = ", ".join(f"{number} {name}" for name, number in summary["verdicts"].items())
    print(f"{summary['cars']} cars: {counts}")
    print(f"{'metric':<24} {'mean':>10} {'std':>10} {'smallest':>10} {'largest':>10}")
    for name in _SHOWN:
        if name in summary["metrics"]:
            mean, deviation, low, high = summary["metrics"][name].values()
            print(f"{name:<24} {mean:>10.4g} {deviation:>10.3g} {low:>10.4g} {high:>10.4g}")
    for row in [row for row in result.rows if row.reason][:3]:
        print(f"car {row.key}: {row.outcome}: {row.reason.splitlines()[0]}")
    print(
        f"{result.workers} workers, {result.wall_s:.1f} s (start {result.start_s:.1f} s), "
        f"{result.runs_per_hour:.0f} runs/h, {result.real_time_factor:.0f} x real time"
    )
    if out is not None:
        print(f"rows: {out}")


def _write(path: Path, table: list[dict[str, Any]]) -> None:
    names = list(dict.fromkeys(name for entry in table for name in entry))
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, names)
        writer.writeheader()
        writer.writerows(table)
