"""Seals: changed labels, salts and answers are noticed; nothing opens before the answers are in; one look per seed."""

import json
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import pytest

from bench.challenge.looks import looks, record_look, refuse_second_look
from bench.challenge.seals import hash_of_answers, open_seal, record_answers
from signals.errors import InputError

SEALING = Path(__file__).resolve().parents[2] / "blind" / "hidden_effects" / "sealing.py"
LABEL = {"family": "single", "effects": [{"name": "mass_change", "value": 1.2}]}


def sealing() -> Any:
    """The generator's own module, loaded by its path."""
    spec = spec_from_file_location("sealing_of_the_generator", SEALING)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def challenge(tmp_path: Path) -> tuple[Path, Path, Path, list[Path]]:
    """Folder, case, sealed label and answers of a challenge with one case."""
    case, sealed = tmp_path / "cases" / "case_0000", tmp_path / "sealed" / "case_0000.json"
    sealing().seal(LABEL, case / "seal.sha256", sealed)
    answer = tmp_path / "answers" / "case_0000.json"
    answer.parent.mkdir()
    answer.write_text('{"diagnosis": null}')
    return tmp_path, case, sealed, [answer]


def test_a_seal_opens_once_the_answers_are_recorded(challenge: tuple[Path, Path, Path, list[Path]]) -> None:
    folder, case, sealed, answers = challenge
    with pytest.raises(InputError, match="not recorded yet"):
        open_seal(folder, answers, case, sealed)
    record_answers(folder, answers)
    assert open_seal(folder, answers, case, sealed) == LABEL


def test_a_changed_label_is_noticed(challenge: tuple[Path, Path, Path, list[Path]]) -> None:
    folder, case, sealed, answers = challenge
    record_answers(folder, answers)
    content = json.loads(sealed.read_text())
    content["label"]["effects"][0]["value"] = 1.21
    sealed.write_text(json.dumps(content))
    with pytest.raises(InputError, match="do not belong to the seal"):
        open_seal(folder, answers, case, sealed)


def test_a_changed_salt_is_noticed(challenge: tuple[Path, Path, Path, list[Path]]) -> None:
    folder, case, sealed, answers = challenge
    record_answers(folder, answers)
    content = json.loads(sealed.read_text())
    content["salt"] = "0" * 64
    sealed.write_text(json.dumps(content))
    with pytest.raises(InputError, match="do not belong to the seal"):
        open_seal(folder, answers, case, sealed)


@pytest.mark.parametrize("change", ["content", "removed", "added"])
def test_an_answer_changed_after_it_was_recorded_is_noticed(
    challenge: tuple[Path, Path, Path, list[Path]], change: str
) -> None:
    folder, case, sealed, answers = challenge
    record_answers(folder, answers)
    other = folder / "answers" / "case_0001.json"
    if change == "content":
        answers[0].write_text('{"diagnosis": 1}')
    if change == "removed":
        answers = []
    if change == "added":
        other.write_text("{}")
        answers = [*answers, other]
    with pytest.raises(InputError, match="not those that were recorded"):
        open_seal(folder, answers, case, sealed)


def test_equal_labels_have_different_seals(tmp_path: Path) -> None:
    """The salt keeps anybody from guessing a label by hashing all of them."""
    for name in ("a", "b"):
        sealing().seal(LABEL, tmp_path / name, tmp_path / f"{name}.json")
    assert (tmp_path / "a").read_text() != (tmp_path / "b").read_text()


def test_hash_of_answers_depends_on_names_and_contents(tmp_path: Path) -> None:
    one, other = tmp_path / "one.json", tmp_path / "other.json"
    one.write_text("1")
    other.write_text("2")
    before = hash_of_answers([one, other])
    assert hash_of_answers([other, one]) == before
    one.write_text("2")
    other.write_text("1")
    assert hash_of_answers([one, other]) != before


def test_a_table_seed_is_scored_once(tmp_path: Path) -> None:
    file = tmp_path / "looks.jsonl"
    refuse_second_look(1_000_001, None, "first", None, file)
    record_look(1_000_001, 200, None, "first", "a hash", file)
    for answers in (None, "another hash"):
        with pytest.raises(InputError, match="scored before"):
            refuse_second_look(1_000_001, None, "first", answers, file)
    refuse_second_look(1_000_001, None, "second", None, file)
    refuse_second_look(1_000_001, "clean", "first", None, file)
    assert [look["n"] for look in looks(file)] == [200]


def test_scoring_that_was_broken_off_may_go_on_with_the_same_answers(tmp_path: Path) -> None:
    file = tmp_path / "looks.jsonl"
    for _ in range(2):
        refuse_second_look(1_000_001, None, "first", "a hash" if file.exists() else None, file)
        record_look(1_000_001, 200, None, "first", "a hash", file)
    assert [look["answers"] for look in looks(file)] == ["a hash"]


def test_tuning_seeds_may_be_looked_at_again_and_leave_no_trace(tmp_path: Path) -> None:
    file = tmp_path / "looks.jsonl"
    for _ in range(2):
        refuse_second_look(7, None, "first", None, file)
        record_look(7, 20, None, "first", "a hash", file)
    assert not file.exists()
