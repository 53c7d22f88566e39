"""A run of the challenge from the generator to the figures; answers that a broken-off run left are taken over."""

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from bench.challenge import run_challenge
from bench.challenge.answering import in_workers
from bench.challenge.generator import generate
from bench.challenge.running import SCORE_FILE
from bench.cli import main
from signals.errors import InputError

CLEAN = {
    "verdict": "nothing_found",
    "causes": [],
    "data_faults": [],
    "discovered_terms": [],
    "insufficient": [],
}
SEED, COUNT = 10_001, 2
TABLE_SEED = 1_999_999  # of hand-made answers that say nothing of the diagnosis


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a run that was broken off after its last answer: cases, seals, answers; nothing opened."""
    folder = tmp_path_factory.mktemp("challenge")
    generate(folder / "cases", folder / "sealed", seed=SEED, count=COUNT, family="clean", generator="first")
    (folder / "answers").mkdir()
    for index in range(COUNT):
        alarm = {"effect": "aero_drag", "probability": 0.9, "parameters": {}, "group": ["aero_drag"]}
        answer = CLEAN | ({"causes": [alarm], "verdict": "effect_found"} if index else {})
        text = json.dumps({"diagnosis": answer, "seconds": 1.0})
        (folder / "answers" / f"case_{index:04d}.json").write_text(text)
    return folder


def test_a_broken_off_run_goes_on_and_scores_its_answers(begun: Path) -> None:
    result = run_challenge(seed=SEED, count=COUNT, family="clean", out=begun)
    assert [score.false_alarm for score in result.scores] == [False, True]
    written = json.loads((begun / SCORE_FILE).read_text())
    alarms = next(figure for figure in written["figures"] if figure["name"] == "false alarms on clean cars")
    assert (alarms["value"], alarms["cases"], alarms["met"]) == (0.5, 2, False)
    assert alarms["interval"] == pytest.approx([0.0945, 0.9055], abs=1e-3)
    assert "false alarms on clean cars" in written["missed"]
    assert written["confusion"] == {"nothing": {"nothing": 1, "aero_drag": 1}}
    record = json.loads((begun / "answers.sha256").read_text())
    assert record["answers"] == COUNT


def test_the_command_ends_with_1_where_a_figure_is_missed(begun: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["diagnose", "challenge", "--seed", str(SEED), "--n", str(COUNT), "--family", "clean", "--out", str(begun)]
    assert main(words) == 1
    text = capsys.readouterr().out
    assert "false alarms on clean cars" in text
    assert "MISSED" in text
    assert (begun / "reliability.svg").read_text().startswith("<svg")


def test_json_is_all_that_is_printed(begun: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["diagnose", "challenge", "--seed", str(SEED), "--n", str(COUNT), "--family", "clean", "--json"]
    assert main([*words, "--out", str(begun)]) == 1
    assert json.loads(capsys.readouterr().out)["seed"] == SEED


def test_a_folder_with_another_challenge_is_refused(begun: Path) -> None:
    with pytest.raises(InputError, match="another challenge"):
        run_challenge(seed=SEED + 1, count=COUNT, family="clean", out=begun)


def test_a_table_seed_is_refused_before_anything_is_made(tmp_path: Path) -> None:
    looks = tmp_path / "looks.jsonl"
    look = {"seed": 1_000_000, "n": 200, "family": None, "generator": "first", "time": "2026-01-01T00:00:00+00:00"}
    looks.write_text(json.dumps(look) + "\n")
    with pytest.raises(InputError, match="scored before"):
        run_challenge(seed=1_000_000, count=200, out=tmp_path / "run", looks=looks)
    assert not (tmp_path / "run").exists()


def test_a_run_broken_off_while_it_scored_goes_on_but_not_with_other_answers(begun: Path, tmp_path: Path) -> None:
    looks, folder = tmp_path / "looks.jsonl", tmp_path / "run"
    shutil.copytree(begun / "answers", folder / "answers")
    generate(folder / "cases", folder / "sealed", seed=TABLE_SEED, count=COUNT, family="clean", generator="first")
    first = run_challenge(seed=TABLE_SEED, count=COUNT, family="clean", out=folder, looks=looks)
    (folder / SCORE_FILE).unlink()
    again = run_challenge(seed=TABLE_SEED, count=COUNT, family="clean", out=folder, looks=looks)
    assert again.as_json() == first.as_json()
    assert len(looks.read_text().splitlines()) == 1
    answer = folder / "answers/case_0000.json"
    answer.write_text(answer.read_text() + " ")
    with pytest.raises(InputError, match="not those that were recorded"):
        run_challenge(seed=TABLE_SEED, count=COUNT, family="clean", out=folder, looks=looks)
    (folder / "answers.sha256").unlink()  # as if nothing had been scored
    with pytest.raises(InputError, match="scored before"):
        run_challenge(seed=TABLE_SEED, count=COUNT, family="clean", out=folder, looks=looks)


def test_what_a_broken_off_run_has_measured_is_kept_and_the_rest_is_measured(tmp_path: Path) -> None:
    def measured(folder: Path, family: str) -> dict[str, object]:
        generate(folder / "cases", folder / "sealed", seed=SEED, count=1, family=family, generator="first")
        (folder / "answers").mkdir()
        (folder / "answers/case_0000.json").write_text(json.dumps({"diagnosis": CLEAN, "seconds": 1.0}))
        (score,) = run_challenge(seed=SEED, count=1, family=family, out=folder).scores
        assert (score.value_std is not None) == (family == "single")
        return {"gain_share": score.gain_share, "separated": score.separated}

    kept = tmp_path / "single" / "measured" / "case_0000.json"
    kept.parent.mkdir(parents=True)
    kept.write_text('{"gain_share": 0.625}')
    assert measured(tmp_path / "single", "single") == {"gain_share": 0.625, "separated": None}
    assert json.loads(kept.read_text()).keys() == {"gain_share", "value_std"}
    # an answer without a cause proposes nothing that could separate look-alikes
    assert measured(tmp_path / "look_alikes", "confounded") == {"gain_share": None, "separated": None}
    assert json.loads((tmp_path / "look_alikes/measured/case_0000.json").read_text()) == {"separated": None}


@pytest.mark.parametrize(("option", "value"), [("--family", "nonsense"), ("--generator", "third")])
def test_unknown_names_end_with_what_is_allowed(option: str, value: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diagnose", "challenge", "--seed", "1", "--n", "1", option, value]) == 2
    assert value in capsys.readouterr().err


def test_more_tasks_than_workers_live_for_are_all_done(tmp_path: Path) -> None:
    # the executor's own way to renew workers stands still after 2 x 25 tasks (CPython issue 115634)
    folders = [tmp_path / str(number) for number in range(120)]
    done = list(in_workers(os.mkdir, [(str(folder),) for folder in folders], 2))
    assert sorted(done) == list(range(120))
    assert all(folder.is_dir() for folder in folders)


def test_workers_end_with_a_challenge_that_is_killed(begun: Path, tmp_path: Path) -> None:
    script, cases, answers = tmp_path / "owner.py", str(begun / "cases"), str(tmp_path / "answers")
    script.write_text(
        "from pathlib import Path\n"
        "from bench.challenge.answering import answer_all\n"
        "if __name__ == '__main__':\n"
        f"    answer_all(sorted(Path({cases!r}).glob('case_*')), Path({answers!r}), 2)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    owner = subprocess.Popen([sys.executable, str(script)], env=environment)
    until = time.monotonic() + 60.0
    workers: list[psutil.Process] = []
    while len(workers) < 3 and time.monotonic() < until:  # two at work, and the tracker of their semaphores
        workers = psutil.Process(owner.pid).children(recursive=True)
        time.sleep(0.1)
    assert len(workers) >= 3
    owner.kill()
    owner.wait()
    _, alive = psutil.wait_procs(workers, timeout=30.0)
    assert alive == []
