"""Logs of the challenge's generator, which shares no code with the diagnosis, with one thing hidden on purpose."""

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "blind"))

from hidden_effects.case import Case
from hidden_effects.data_faults import Fault
from hidden_effects.families import Draw, Hidden, named
from hidden_effects.recording import Loggers

from model_diagnosis.data import read_manoeuvres
from model_diagnosis.manoeuvre import Manoeuvre
from signals.measured import load_channel_map
from vehicle_model import load_vehicle
from vehicle_model.vehicle_file import VehicleFile

WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in ("fl", "fr", "rl", "rr"))
INERTIAL = ("longitudinal_acceleration", "lateral_acceleration", "yaw_rate")


def late(kind: str, channels: tuple[str, ...], delay_s: float) -> Fault:
    """Channels that come late."""
    return Fault(kind, channels, delay_s, "s")


def hidden_logs(
    folder: Path,
    seed: int,
    names: Sequence[str],
    effect: tuple[str, float, int] | None = None,
    fault: Fault | None = None,
) -> tuple[VehicleFile, list[Manoeuvre]]:
    """Vehicle file and manoeuvres of a car of the series, all its numbers off within their scatter.

    ``effect`` is name, deviation and place (wheel or axle) of what is wrong with the car.
    """
    case = Case(seed, 0, "clean", "first")
    case.format = "csv"
    hidden = () if effect is None else (Hidden(named(effect[0]), effect[1], effect[2]),)
    case.draw = Draw("single", hidden, fault)
    case.loggers = Loggers(0.0, dict.fromkeys(case.loggers.phases_s, 0.0), (), fault)
    case.write_further(folder, (), "")
    vehicle = load_vehicle(str(folder / "vehicle.yaml"))
    channel_map = load_channel_map(str(folder / "channels.yaml"))
    return vehicle, read_manoeuvres([folder / "logs" / f"{name}.csv" for name in names], channel_map, vehicle)


def drawn_logs(
    case: Path, seed: int, index: int, family: str | None = None, folder: str = "logs"
) -> tuple[VehicleFile, list[Manoeuvre]]:
    """Vehicle file and manoeuvres of a case of the mixture, or of a family, as it was drawn.

    ``folder`` is ``logs`` or ``held_out``.
    """
    Case(seed, index, family, "first").write(case, case / "label.json")
    vehicle = load_vehicle(str(case / "vehicle.yaml"))
    channel_map = load_channel_map(str(case / "channels.yaml"))
    return vehicle, read_manoeuvres(sorted((case / folder).iterdir()), channel_map, vehicle)
