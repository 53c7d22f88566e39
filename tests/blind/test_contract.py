"""The generator and the bench share no code: import contract in both directions, and no copied lines."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
GENERATOR = (HERE / "generate.py", *sorted((HERE / "hidden_effects").glob("*.py")))
PACKAGES = ("signals", "vehicle_model", "hydraulics", "can_fault_injector", "estimators", "model_diagnosis", "bench")
LONGEST_COMMON_LINES = 4


def _sources() -> list[Path]:
    return [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]


def _imports_only(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names.add((node.module or "").partition(".")[0])
    return names


@pytest.mark.parametrize("path", GENERATOR, ids=lambda path: path.name)
def test_the_generator_imports_nothing_of_the_bench(path: Path) -> None:
    assert not _imports_only(path) & set(PACKAGES)
    text = path.read_text(encoding="utf-8")
    assert "importlib" not in text
    assert "__import__" not in text


def test_the_bench_imports_nothing_of_the_generator() -> None:
    guilty = [path for path in _sources() if _imports_only(path) & {"hidden_effects", "generate", "tests"}]
    assert guilty == []


def test_the_bench_names_the_generators_package_nowhere() -> None:
    """It runs the program by its path; not even a text may name the package behind it."""
    assert [path for path in _sources() if "hidden_effects" in path.read_text(encoding="utf-8")] == []


def test_import_linter_keeps_both_directions() -> None:
    environment = os.environ | {"PYTHONPATH": str(HERE)}
    program = Path(sys.executable).parent / "lint-imports"
    words = [str(program), "--config", str(HERE / "importlinter.ini"), "--no-cache"]
    done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "2 kept, 0 broken" in done.stdout


def test_no_run_of_lines_is_common_to_both() -> None:
    """Longer runs of the same code would be a copy; short ones (imports, loops over wheels) happen."""

    def runs(path: Path) -> set[tuple[str, ...]]:
        lines = [line.strip() for line in path.read_text(encoding="utf-8").splitlines()]
        code = [line for line in lines if len(line) > 12 and not line.startswith(("#", "from ", "import ", '"""', "@"))]
        size = LONGEST_COMMON_LINES + 1
        return {tuple(code[start : start + size]) for start in range(len(code) - size + 1)}

    ours = set().union(*(runs(path) for path in _sources()))
    assert {path.name for path in GENERATOR if runs(path) & ours} == set()


def test_a_running_generator_has_no_module_of_the_bench(tmp_path: Path) -> None:
    check = f"[m for m in sys.modules if m.partition('.')[0] in {set(PACKAGES)!r}]"
    script = f"import sys; sys.path[:0] = [{str(HERE)!r}]; import hidden_effects.case; sys.exit(len({check}))"
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
