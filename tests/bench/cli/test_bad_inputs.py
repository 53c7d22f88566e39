"""Every bad input of the table ends in one clear message and its exit code; docs/errors.md is made from the table."""

from pathlib import Path
from typing import Any

import pytest

from bench.cli import main
from signals.yaml_files import load_yaml

TABLE = load_yaml(Path(__file__).with_name("bad_inputs.yaml")).data
CASES: list[dict[str, Any]] = TABLE["cases"]


def test_the_table_is_long_enough() -> None:
    assert len(CASES) >= 40
    assert len({case["id"] for case in CASES}) == len(CASES)


@pytest.mark.parametrize("case", CASES, ids=[case["id"] for case in CASES])
def test_bad_input(
    case: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("base.yaml").write_text(TABLE["base"])
    Path("folder.yaml").mkdir()
    Path("binary.yaml").write_bytes(b"vehicle: \xff\xfe\x00")
    for name, text in {**case.get("beside", {}), **({"case.yaml": case["file"]} if "file" in case else {})}.items():
        Path(name).write_text(text)
    code = main(case.get("command", ["check", "case.yaml"]))
    printed = capsys.readouterr()
    assert _comparable(printed.err.replace(f"{tmp_path.resolve()}/", ""), case) == _comparable(case["message"], case)
    assert code == case.get("code", 2)
    assert printed.out == ""
    assert len(printed.err.splitlines()) <= 6
    assert "Traceback" not in printed.err


def _comparable(text: str, case: dict[str, Any]) -> list[str]:
    lines = text.splitlines()
    return [line.partition("allowed:")[0] for line in lines] if case.get("list_grows") else lines
