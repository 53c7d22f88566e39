"""Scores of runs in parts, put together as one table."""

import json
from dataclasses import asdict
from pathlib import Path

import pytest

from bench.challenge.code_digest import code_digest
from bench.challenge.merging import merged_figures
from bench.challenge.printing import table_row
from bench.challenge.scoring import CaseScore
from signals.errors import InputError


def _score(folder: Path, seed: int, alarms: int, count: int, code: str = "abc", **more: object) -> Path:
    cases = [
        asdict(CaseScore(f"case_{k:04d}", "clean", "nothing", 0.0, "nothing", false_alarm=k < alarms))
        for k in range(count)
    ]
    whole = {"seed": seed, "n": count, "family": "clean", "generator": "first", "code": code, "cases": cases, **more}
    file = folder / f"{seed}_{code}.json"
    file.write_text(json.dumps(whole))
    return file


def test_figures_are_those_of_all_cases_together(tmp_path: Path) -> None:
    parts = [_score(tmp_path, 1, 2, 40), _score(tmp_path, 2, 1, 60)]
    figure = next(one for one in merged_figures(parts).shares if one.name == "false alarms on clean cars")
    assert (figure.value, figure.count) == (0.03, 100)
    # Wilson's interval of 3 of 100
    assert (figure.low, figure.high) == pytest.approx((0.0103, 0.0845), abs=1e-4)
    assert table_row(figure) == "| false alarms on clean cars | ≤ 1 % | 3.0 % | 1.0 … 8.5 % | 100 | missed |"


def test_the_same_run_twice_is_refused(tmp_path: Path) -> None:
    twice = [_score(tmp_path, 1, 0, 5), _score(tmp_path.parent, 1, 0, 5)]
    with pytest.raises(InputError, match="the same run"):
        merged_figures(twice)


def test_scores_of_different_code_are_refused(tmp_path: Path) -> None:
    parts = [_score(tmp_path, 1, 0, 5, "abc"), _score(tmp_path, 2, 0, 5, "def")]
    with pytest.raises(InputError, match="different code"):
        merged_figures(parts)


def test_what_is_no_score_is_told(tmp_path: Path) -> None:
    file = tmp_path / "other.json"
    file.write_text('{"seed": 1}')
    with pytest.raises(InputError, match="no score of a challenge"):
        merged_figures([file])
    file.write_text("no JSON")
    with pytest.raises(InputError, match="cannot be read"):
        merged_figures([file])


def test_the_digest_is_of_this_code_and_stays_the_same() -> None:
    assert len(code_digest()) == 16
    assert code_digest() == code_digest()


def test_published_scores_are_of_one_code() -> None:
    scores = sorted((Path(__file__).parents[3] / "docs/challenge_scores").glob("*.json"))
    if not scores:
        pytest.skip("no scores are published yet")
    assert merged_figures(scores).shares
