"""From logs to a folder with ``diagnosis.html``, ``diagnosis.json`` and the extended vehicle file.

>>> import bench
>>> diagnosis = bench.diagnose(["runs/worn_pads"], "ekf_car")
>>> diagnosis.verdict, [cause.effect for cause in diagnosis.causes]
"""

import json
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from bench.diagnosis.recordings import as_log, car_of, recording_of
from bench.verdict.output_files import replace_file
from model_diagnosis.data.repeated import refuse_repeats
from model_diagnosis.findings import Findings
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.rating import ratings_of
from model_diagnosis.result import Diagnosis
from signals.errors import InputError
from signals.measured.channel_map import ChannelMap, load_channel_map
from vehicle_model.vehicle_file import VehicleFile, load_vehicle

Progress = Callable[[str, float], None]
INSUFFICIENT_DATA = 3
PAGE_FILE, ANSWER_FILE, VEHICLE_FILE = "diagnosis.html", "diagnosis.json", "extended_vehicle.yaml"


@dataclass(frozen=True)
class Found:
    """A diagnosis with the arrays behind it, and the car that it is of.

    Attributes
    ----------
    vehicle_argument : str
        Name or file of the car, as given or as the recording tells.
    """

    findings: Findings
    vehicle: VehicleFile
    vehicle_argument: str


@dataclass(frozen=True)
class Written:
    """A diagnosis and the folder that its files are in."""

    findings: Findings
    folder: Path

    @property
    def diagnosis(self) -> Diagnosis:
        """The answer."""
        return self.findings.diagnosis

    @property
    def exit_code(self) -> int:
        """Of the command: 3 where the data cannot answer, else 0."""
        return INSUFFICIENT_DATA if self.diagnosis.verdict == "insufficient_data" else 0

    def as_json(self) -> dict[str, Any]:
        """Contents of ``diagnosis.json`` and the folder."""
        return {"folder": str(self.folder)} | answer_json(self.diagnosis)


def diagnose(
    logs: str | Path | Sequence[str | Path],
    vehicle: str | Path | None = None,
    *,
    channels: str | Path | None = None,
    hold_out: Sequence[str | Path] = (),
    hold_out_share: float = 0.0,
    at_most_s: float | None = None,
    out: str | Path | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Diagnosis:
    """Say what the simulation of a car gets wrong on measured data, and why.

    Parameters
    ----------
    logs : path or sequence of paths
        Logs of any format with ``channels``, or recordings of the bench.
    vehicle : name or path, optional
        Vehicle file; without it the one that a recording of the bench was made with.
    channels : path, optional
        Channel map of the logs; recordings of the bench need none.
    hold_out : sequence of paths
        Logs that take no part in the search and measure the gain.
    hold_out_share : float
        Share of each drive's time, from its end, that takes no part either: 0.5 is the second half.
    at_most_s : float, optional
        Search only the liveliest manoeuvres, of so much time together [s].
    out : path, optional
        Folder for page, answer and extended vehicle file; nothing is written without it.
    seed : int
        Of the bootstraps.
    progress : callable, optional
        Told what is being done and the share done, 0 to 1.

    Raises
    ------
    InputError
        If a file cannot be read, or holds nothing that can be compared with a simulation.
    """
    found = find(
        _texts(logs),
        vehicle,
        channels=channels,
        hold_out=_texts(hold_out),
        hold_out_share=hold_out_share,
        at_most_s=at_most_s,
        seed=seed,
        progress=progress,
    )
    if out is not None:
        return write(found, Path(out)).diagnosis
    return found.findings.diagnosis


def find(
    logs: Sequence[str],
    vehicle: str | Path | None,
    *,
    channels: str | Path | None = None,
    hold_out: Sequence[str] = (),
    hold_out_share: float = 0.0,
    at_most_s: float | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Found:
    """The diagnosis with the arrays behind it (`diagnose` for the parameters)."""
    from bench.loop.versions import versions

    both = sorted(set(logs) & set(hold_out))
    if both:
        raise InputError(f"{both[0]}: is diagnosed and held out at once", mend="name it once, here or after --hold-out")
    channel_map = None if channels is None else load_channel_map(channels)
    name = car_name(logs, vehicle, channel_map)
    car = load_vehicle(name)
    searched = read(logs, car, channel_map)
    held_out = read(hold_out, car, channel_map) if hold_out else None
    refuse_repeats([*searched, *(held_out or ())])
    from model_diagnosis.diagnosis import (
        diagnose as diagnose_manoeuvres,  # compiles: what cannot be read is told before
    )

    findings = diagnose_manoeuvres(
        searched,
        car,
        hold_out=held_out,
        hold_out_share=hold_out_share,
        at_most_s=at_most_s,
        seed=seed,
        progress=progress,
    )
    answer = findings.diagnosis.model_copy(
        update={
            "ratings": _ratings(findings, restarted=False),
            "ratings_restarted": _ratings(findings, restarted=True),
            "versions": findings.diagnosis.versions | versions(),
        }
    )
    return Found(replace(findings, diagnosis=answer, logs=[*logs, *hold_out]), car, name)


def _ratings(findings: Findings, *, restarted: bool) -> dict[str, dict[str, float]]:
    """Manoeuvre -> signal -> rating of the vehicle as given."""
    return {
        part.manoeuvre.name: {
            name: round(rated.overall, 4) for name, rated in ratings_of(part, restarted=restarted).items()
        }
        for part in findings.manoeuvres
    }


def read(logs: Sequence[str], vehicle: VehicleFile, channel_map: ChannelMap | None) -> list[Manoeuvre]:
    """Manoeuvres of logs through a channel map, or without one of recordings of the bench.

    Raises
    ------
    InputError
        If a log needs a channel map and there is none.
    """
    from model_diagnosis.data import read_manoeuvres

    if channel_map is not None:
        return read_manoeuvres(logs, channel_map, vehicle)
    manoeuvres: list[Manoeuvre] = []
    with tempfile.TemporaryDirectory() as folder:
        for log in logs:
            recording = recording_of(log)
            if recording is None:
                raise _needs_map(log)
            path, own_map = as_log(recording, Path(folder), vehicle.sensors.wheel_speed.teeth)
            manoeuvres += read_manoeuvres([path], own_map, vehicle)
    return manoeuvres


def car_name(logs: Sequence[str], vehicle: str | Path | None, channel_map: ChannelMap | None) -> str:
    """Name or file of the car: as given, or that of a recording's scenario.

    Raises
    ------
    InputError
        If neither tells one.
    """
    if vehicle is not None:
        return str(vehicle)
    recordings = [] if channel_map is not None else [path for log in logs if (path := recording_of(log)) is not None]
    if channel_map is None and len(recordings) < len(logs):
        raise _needs_map(next(log for log in logs if recording_of(log) is None))
    car = car_of(recordings)
    if not car:
        raise InputError(f"{logs[0]}: the log does not say which car it is", mend="give it: --vehicle NAME|FILE")
    return car


def write(found: Found, folder: Path, *, stops: bool = True) -> Written:
    """Write page and answer, and where what was found gains on data that took no part, the extended vehicle file.

    Parameters
    ----------
    found : Found
        What `find` gave.
    folder : Path
        Made where it is not there.
    stops : bool
        Let the extended car stop with the ECU in the loop, beside the vehicle file's.
    """
    from bench.diagnosis.extending import with_stops, write_extension
    from bench.diagnosis_report.page import build

    folder.mkdir(parents=True, exist_ok=True)
    extended = folder / VEHICLE_FILE
    extended.unlink(missing_ok=True)
    answer = write_extension(found.findings, extended, found.vehicle, found.vehicle_argument)
    _write_answer(answer, folder)  # of minutes of searching nothing is lost, should a stop or the page fail
    if stops and answer.extension_file and answer.subject == "car":
        answer = with_stops(answer, found.vehicle_argument, extended)
        _write_answer(answer, folder)
    findings = replace(found.findings, diagnosis=answer)
    build(findings, folder)
    return Written(findings, folder)


def _write_answer(answer: Diagnosis, folder: Path) -> None:
    text = json.dumps(answer_json(answer), indent=2, ensure_ascii=False) + "\n"
    replace_file(folder / ANSWER_FILE, text.encode())


def default_folder(logs: Sequence[str]) -> Path:
    """``diagnosis`` in the run's folder for a recording of the bench, ``diagnosis/LOG`` for another log."""
    recording = recording_of(logs[0])
    if recording is not None:
        return (recording if recording.is_dir() else recording.parent) / "diagnosis"
    return Path("diagnosis") / Path(logs[0]).name.split(".")[0]


def answer_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """Contents of ``diagnosis.json``; numbers that are not finite become null."""
    content: dict[str, Any] = json.loads(diagnosis.model_dump_json())
    return content


def _texts(logs: str | Path | Sequence[str | Path]) -> list[str]:
    several = [logs] if isinstance(logs, (str, Path)) else logs
    return [str(log) for log in several]


def _needs_map(log: str) -> InputError:
    if not Path(log).exists():
        return InputError(f"{log}: no such log and no such run", mend="runs: bench runs")
    return InputError(
        f"{log}: not recorded by the bench",
        mend=f"say which column is which signal: --channels FILE; bench diagnose map {log} --vehicle CAR suggests one",
    )
