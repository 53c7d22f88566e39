"""``bench judge RUN --criteria FILE``: a recording, or a foreign log with a channel map, under new criteria."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from bench.recording.arrays import RunArrays
from bench.verdict.criteria_file import CriteriaFile, check_criteria
from bench.verdict.judge import judge
from bench.verdict.result import Verdict
from signals.errors import FileFaults, InputError

if TYPE_CHECKING:
    from signals.yaml_files import DataPath, Document


@dataclass(frozen=True)
class LoadedCriteria:
    """Criteria of a file and the document that knows their places."""

    file: CriteriaFile
    document: "Document"


def judge_recording(
    run: str | Path,
    criteria: str | Path,
    *,
    channels: str | Path | None = None,
    vehicle: str | Path | None = None,
) -> Verdict:
    """Judge a recording by the criteria of a file.

    Parameters
    ----------
    run : str or Path
        A run's folder, an MF4 or MCAP file of the bench, or with ``channels`` any log.
    criteria : str or Path
        File with ``criteria`` and, if wanted, ``valid_if``; a scenario has them too.
    channels : str or Path, optional
        Channel map of a foreign log.
    vehicle : str or Path, optional
        Vehicle file or name, for the wheel radius.

    Raises
    ------
    InputError
        If a file is missing or wrong, or a criterion names what the recording does not have, with every place.
    """
    loaded = load_criteria(criteria)
    radius = wheel_radius_m(vehicle)
    data = open_foreign(run, channels, radius) if channels is not None else _open_own(run)
    _check(loaded, data)
    information = data.information
    return judge(
        data,
        loaded.file.criteria,
        valid_if=loaded.file.valid_if,
        scenario=str(information.get("scenario") or Path(run).name),
        seed=information.get("seed"),
        versions=information.get("versions"),
        wheel_radius_m=radius,
    )


def load_criteria(path: str | Path) -> LoadedCriteria:
    """Read a criteria file, or the criteria of a scenario given by its path or id.

    Raises
    ------
    InputError
        With the place of every fault.
    """
    from bench.scenario.documents import read_document
    from bench.scenario.locate import find_scenario
    from signals.yaml_files import validate

    document = read_document(find_scenario(path))
    if isinstance(document.data, dict) and "manoeuvre" in document.data:
        document.data = {key: document.data[key] for key in ("criteria", "valid_if") if key in document.data}
    return LoadedCriteria(validate(document, CriteriaFile), document)


def _open_own(run: str | Path) -> RunArrays:
    from bench.recording.reading import Recording

    return Recording.open(run)


def open_foreign(log: str | Path, channels: str | Path, wheel_radius_m: float | None = None) -> RunArrays:
    """A foreign log on one time base, from its first sample on."""
    from signals.measured.channel_map import load_channel_map
    from signals.measured.measured_log import read_log

    measured = read_log(log, load_channel_map(channels), wheel_radius_m=wheel_radius_m)
    time, columns = measured.resample()
    return RunArrays(time, {"time": time} | columns, {"time": "s"} | measured.units())


def wheel_radius_m(vehicle: str | Path | None) -> float | None:
    """Mean wheel radius of a car, None without one [m]."""
    if vehicle is None:
        return None
    from vehicle_model.vehicle_file import load_vehicle

    wheels = load_vehicle(vehicle).wheels
    return float(sum(wheel.radius for wheel in (wheels.fl, wheels.fr, wheels.rl, wheels.rr)) / 4)


def _check(loaded: LoadedCriteria, data: RunArrays) -> None:
    problems = check_criteria(loaded.file.criteria, data.units, data.phase_names, loaded.file.valid_if)
    if len(data) == 0:
        raise InputError("the recording holds no row to judge")
    faults = []
    for problem in problems:
        path: DataPath = problem.path if problem.path[0] == "valid_if" else ("criteria", *problem.path)
        faults.append(loaded.document.fault(path, problem.message))
    if faults:
        raise FileFaults(faults, loaded.document.file)
