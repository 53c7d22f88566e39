"""Logs of the kinematic car as files, read as a user's."""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

import kinematic_car as car

from model_diagnosis.data import read_manoeuvres
from model_diagnosis.manoeuvre import Manoeuvre
from signals.measured.channel_map import ChannelMap
from vehicle_model.vehicle_file import VehicleFile, load_vehicle

KINDS = ("stop", "slalom", "turn_brake", "accelerate")


@pytest.fixture(scope="session")
def vehicle() -> VehicleFile:
    return load_vehicle("ekf_car")


@pytest.fixture(scope="session")
def channel_map() -> ChannelMap:
    return ChannelMap(channels={n: {"source": n, "unit": unit} for n, (unit, _, _) in car.CHANNELS.items()})


@pytest.fixture
def recorded(tmp_path: Path, vehicle: VehicleFile, channel_map: ChannelMap) -> Callable[..., list[Manoeuvre]]:
    """Manoeuvres of one car: a fault of the true signals, a fault of the log, whatever ``logged`` takes."""

    def record(seed, *, before=None, after=None, kinds=KINDS, off=0.03, quiet=(), **options):
        random = np.random.default_rng(seed)
        paths = []
        for kind in kinds:
            driven = car.drive(kind, random)
            signals = car.sensed(driven, random, off=off)
            if before is not None:
                signals = before(driven.time, signals)
            log = car.logged(driven, signals, random, quiet=quiet, **options)
            paths.append(car.write_csv(tmp_path / f"{kind}.csv", after(log, random) if after is not None else log))
        return read_manoeuvres(paths, channel_map, vehicle)

    return record
