"""What ``bench estimate`` does: from a log and names to files."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.estimation.offline import requests_of, run_offline, with_estimates
from bench.estimation.output_files import write_estimates
from bench.estimation.source import Source, open_source
from signals.errors import InputError


@dataclass(frozen=True)
class EstimateResult:
    """Folder and contents of the files that were written."""

    folder: Path
    summaries: Sequence[Mapping[str, Any]]

    def as_json(self) -> dict[str, Any]:
        """Folder and the contents of every ``estimates.json``."""
        return {"folder": str(self.folder), "estimators": list(self.summaries)}

    def text(self) -> str:
        """A table for people: outputs that there is a reference of, and the cost of a step."""
        lines = []
        for summary in self.summaries:
            lines.append(
                f"{summary['estimator']}: {summary['step_time_us']:.1f} us per step, "
                f"ran {100 * summary['active_share']:.0f} % of the time"
            )
            compared = {name: entry for name, entry in summary["outputs"].items() if "rmse" in entry}
            lines += [
                f"  {name:<28} RMSE {entry['rmse']:<10.4g} mean error {entry['mean_error']:<+10.3g} "
                f"{'' if entry['unit'] == '1' else entry['unit']}{_confident(entry)}".rstrip()
                for name, entry in compared.items()
            ]
            if not compared:
                lines.append("  nothing to compare it with in this log")
        return "\n".join([*lines, f"files: {self.folder}"])


def estimate_log(
    log: str | Path,
    estimators: Sequence[str] = (),
    *,
    vehicle: str | Path | None = None,
    channels: str | Path | None = None,
    sets: Sequence[str] | Mapping[str, Any] = (),
    out: Path | None = None,
) -> EstimateResult:
    """Run estimators over a log and write what they gave.

    Parameters
    ----------
    log : str or Path
        Folder of a run, its recording, or with ``channels`` any log.
    estimators : sequence of str
        Names as in a scenario; without any, those of the recording's scenario.
    vehicle : str or Path, optional
        Car by name or file; without it that of the recording's scenario.
    channels : str or Path, optional
        Channel map of a measured log.
    sets : sequence of ``key=value``, or mapping
        Settings.
    out : Path, optional
        Folder of the results.

    Raises
    ------
    InputError
        If a file, a name, a setting or a signal is missing or wrong.
    """
    from bench.scenario.documents import parse_sets
    from vehicle_model.vehicle_file import load_vehicle

    source = open_source(log, channels, vehicle)
    car = vehicle or source.vehicle
    if not car:
        raise InputError(f"{source.path}: the log does not say which car it is", mend="give it: --vehicle NAME|FILE")
    requests = requests_of(estimators, parse_sets(sets), source)
    estimates = run_offline(source, load_vehicle(car).numbers(), requests)
    folder = out or _default_folder(source)
    return EstimateResult(folder, write_estimates(folder, with_estimates(source.data, estimates), estimates))


def _confident(entry: Mapping[str, Any]) -> str:
    return f" RMSE where confident {entry['rmse_confident']:.4g}" if "rmse_confident" in entry else ""


def _default_folder(source: Source) -> Path:
    if source.measured:
        return Path("estimates") / source.path.name.split(".")[0]
    return (source.path if source.path.is_dir() else source.path.parent) / "estimates"
