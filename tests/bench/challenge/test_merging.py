"""Scores of runs in parts, put together as one table."""

import json
import runpy
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from bench.challenge.code_digest import code_digest
from bench.challenge.figures import figures_of
from bench.challenge.merging import merged_cases, read_score
from bench.challenge.printing import table_row
from bench.challenge.scoring import CaseScore
from signals.errors import InputError


def _score(folder: Path, seed: int, alarms: int, count: int, code: str = "abc", **more: object) -> Path:
    cases = [
        asdict(CaseScore(f"case_{k:04d}", "clean", "nothing", 0.0, "nothing", false_alarm=k < alarms))
        for k in range(count)
    ]
    whole = {"seed": seed, "n": count, "family": "clean", "generator": "first", "code": code, "cases": cases, **more}
    file = folder / f"{seed}_{code}_{whole['family']}_{whole['generator']}.json"
    file.write_text(json.dumps(whole))
    return file


def _merged(files: Sequence[Path]) -> list[CaseScore]:
    return [case.score for case in merged_cases({file: read_score(file) for file in files})]


def _pages() -> dict[str, Any]:
    return runpy.run_path(str(Path(__file__).parents[3] / "docs/generate_challenge.py"))


def test_figures_are_those_of_all_cases_together(tmp_path: Path) -> None:
    parts = [_score(tmp_path, 1, 2, 40), _score(tmp_path, 2, 1, 60)]
    figure = next(one for one in figures_of(_merged(parts)).shares if one.name == "false alarms on clean cars")
    assert (figure.value, figure.count) == (0.03, 100)
    # Wilson's interval of 3 of 100
    assert (figure.low, figure.high) == pytest.approx((0.0103, 0.0845), abs=1e-4)
    assert table_row(figure) == "| false alarms on clean cars | ≤ 1 % | 3.0 % | 1.0 … 8.5 % | 100 | MISSED |"


def test_the_same_run_twice_is_refused(tmp_path: Path) -> None:
    twice = [_score(tmp_path, 1, 0, 5), _score(tmp_path.parent, 1, 0, 5)]
    with pytest.raises(InputError, match="the same run"):
        _merged(twice)


def test_a_familys_case_is_that_of_the_mixture_of_its_seed_and_counts_once(tmp_path: Path) -> None:
    family, mixture = _score(tmp_path, 1, 1, 40), _score(tmp_path, 1, 1, 3, family=None)
    others = [_score(tmp_path, 2, 0, 3), _score(tmp_path, 1, 0, 4, generator="second")]
    shares = figures_of(_merged([family, mixture, *others])).shares
    figure = next(one for one in shares if one.name == "false alarms on clean cars")
    assert (figure.value, figure.count) == (pytest.approx(1 / 47), 47)


def test_scores_of_different_code_are_refused(tmp_path: Path) -> None:
    parts = [_score(tmp_path, 1, 0, 5, "abc"), _score(tmp_path, 2, 0, 5, "def")]
    with pytest.raises(InputError, match="different code"):
        _merged(parts)


def test_what_is_no_score_is_told(tmp_path: Path) -> None:
    file = tmp_path / "other.json"
    file.write_text('{"seed": 1}')
    with pytest.raises(InputError, match="no score of a challenge"):
        _merged([file])
    file.write_text("no JSON")
    with pytest.raises(InputError, match="cannot be read"):
        _merged([file])


def test_the_digest_is_of_this_code_and_stays_the_same() -> None:
    assert len(code_digest()) == 16
    assert code_digest() == code_digest()


def test_the_page_of_figures_says_where_they_come_from(tmp_path: Path) -> None:
    parts = [_score(tmp_path, 1, 2, 40), _score(tmp_path, 2, 1, 60)]
    page = _pages()["figures_page"]({file: read_score(file) for file in parts})
    assert "all of code `abc`" in page
    assert "2: 1 (clean, 40, first generator); 2 (clean, 60, first generator)" in page
    assert "| false alarms on clean cars | ≤ 1 % | 3.0 % | 1.0 … 8.5 % | 100 | MISSED |" in page
    assert "Cases: clean 100." in page


def test_each_generator_has_figures_of_its_own_and_sizes_are_of_the_first(tmp_path: Path) -> None:
    single = asdict(CaseScore("case_0000", "single", "road_grade", 7.0, "road_grade", in_group=True))
    first = _score(tmp_path, 1, 1, 4)
    second = _score(tmp_path, 2, 3, 5, generator="second")
    content = json.loads(second.read_text())
    second.write_text(json.dumps({**content, "cases": [*content["cases"], single]}))
    limit = {"effect": "road_grade", "scatter": 0.001, "unit": "1", "limit": 6.3, "smallest": 6.5, "largest": 40.0}
    made = _pages()["pages"]([limit], {file: read_score(file) for file in (first, second)})
    by_name = {file.name: text for file, text in made.items()}
    assert "Cases: clean 4." in by_name["challenge_figures.md"]
    assert "Cases: clean 5, single 1." in by_name["challenge_figures_second.md"]
    assert "| – | – | 0 |" in by_name["challenge_limits.md"].splitlines()[-1]


def test_an_old_score_beside_new_ones_is_told_as_other_code(tmp_path: Path) -> None:
    """Also where its cases are such as this version does not know."""
    old = _score(tmp_path, 1, 0, 1, "old")
    content = json.loads(old.read_text())
    content["cases"][0]["unheard_of"] = 1
    old.write_text(json.dumps(content))
    with pytest.raises(InputError, match="different code"):
        _merged([old, _score(tmp_path, 2, 0, 1, "new")])


def test_a_case_of_another_version_is_told(tmp_path: Path) -> None:
    file = _score(tmp_path, 1, 0, 1)
    content = json.loads(file.read_text())
    content["cases"][0]["unheard_of"] = 1
    file.write_text(json.dumps(content))
    with pytest.raises(InputError, match="no run of this version writes"):
        merged_cases({file: read_score(file)})


def test_the_page_lists_what_went_wrong(tmp_path: Path) -> None:
    page = _pages()["figures_page"]({file: read_score(file) for file in [_score(tmp_path, 7, 1, 2)]})
    rows = page.partition("| Seed/case |")[2].splitlines()[2:]
    assert rows == ["| 7/0 | clean | nothing | – | nothing | false alarm |"]
