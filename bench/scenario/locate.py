"""Where scenario files are: a path, or an id looked up in ``./scenarios``, then among the shipped ones."""

from importlib import resources
from pathlib import Path

from signals.errors import InputError, nearest_name

SHARED = "common"
"""Folder of parts that scenarios include; they are no scenarios themselves."""
CHANNEL_MAP = "channels.yaml"
"""A folder with this file holds the map and the car of a measured log: no scenarios."""


def shipped_folder() -> Path:
    """Folder of the scenarios that ship with the bench: in the installed package, else beside the sources."""
    installed = Path(str(resources.files("bench"))) / "data" / "scenarios"
    return installed if installed.is_dir() else Path(__file__).resolve().parents[2] / "scenarios"


def scenario_folders() -> list[Path]:
    """Folders in which ids are looked up, the user's own first."""
    folders = [Path("scenarios"), shipped_folder()]
    unique: list[Path] = []
    for folder in folders:
        if folder.is_dir() and all(not folder.samefile(other) for other in unique):
            unique.append(folder)
    return unique


def scenario_files() -> dict[str, Path]:
    """Every scenario by its id; of two with one id the user's own."""
    found: dict[str, Path] = {}
    for folder in scenario_folders():
        for path in sorted(folder.rglob("*.yaml")):
            if path.relative_to(folder).parts[0] != SHARED and not (path.parent / CHANNEL_MAP).exists():
                found.setdefault(path.relative_to(folder).with_suffix("").as_posix(), path)
    return found


def find_scenario(argument: str | Path) -> Path:
    """File of a scenario argument.

    Raises
    ------
    InputError
        If it is neither a file nor the id of a scenario; the message names the nearest id.
    """
    text = str(argument)
    if text.endswith((".yaml", ".yml")) or Path(text).is_file():
        return Path(text)
    for folder in scenario_folders():
        path = folder / f"{text}.yaml"
        if path.is_file():
            return path
    known = list(scenario_files())
    short = [name for name in known if name.rpartition("/")[2] == text]
    raise InputError(
        f"no scenario {text!r}",
        nearest=short[0] if short else nearest_name(text, known),
        mend="all of them: bench list; or give the path of a .yaml file",
    )


def id_of(path: Path) -> str:
    """Id of a scenario file: its path below a folder of scenarios, else its name."""
    resolved = path.resolve()
    for folder in scenario_folders():
        if resolved.is_relative_to(folder.resolve()):
            return resolved.relative_to(folder.resolve()).with_suffix("").as_posix()
    return path.stem
