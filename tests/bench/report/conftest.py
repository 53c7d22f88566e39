import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import made_up_stop


@pytest.fixture(scope="session")
def finished_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a real-time run of 10 s with a failed criterion and an ECU that falls silent for 0.2 s."""
    data = made_up_stop.simulate(10.0)
    folder = tmp_path_factory.mktemp("runs") / "stops-dry-20260302-101112"
    frames = made_up_stop.frames_of(10.0, silent=(3.0, 3.2))
    return made_up_stop.write_run_folder(folder, data, made_up_stop.verdict_of(data, failing=True), frames)


@pytest.fixture(scope="session")
def other_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a lock-step run without ABS that brakes 0.4 s later."""
    data = made_up_stop.simulate(6.0, brake_at_s=1.4, abs_control=False, seed=2, real_time=False)
    verdict = made_up_stop.verdict_of(data)
    verdict["metrics"] = {**verdict["metrics"], "stopping_distance_m": 61.2}
    scenario = made_up_stop.SCENARIO.replace("kind: emulated", "kind: none").replace("seed: 1", "seed: 2")
    folder = tmp_path_factory.mktemp("other") / "stops-no_ecu-20260302-111213"
    return made_up_stop.write_run_folder(folder, data, verdict, scenario=scenario)


@pytest.fixture(scope="session")
def report_page(finished_run: Path) -> Path:
    """``report.html`` of the finished run."""
    from bench.report import build

    return build(finished_run)
