"""Reading of ``.tir`` files: sections, names, values, comments and tables as tyre programs write them.

[SECTION]
NAME = 1.5          $ comment
NAME = 'text'
! a line of comment
{a  table}          rows of numbers follow
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from signals.errors import Fault, FileFaults, InputError, nearest_name

_SI = {
    "LENGTH": ("meter", "metre", "m"),
    "FORCE": ("newton", "n"),
    "ANGLE": ("radian", "radians", "rad"),
    "MASS": ("kg", "kilogram"),
    "TIME": ("second", "s", "sec"),
    "PRESSURE": ("pascal", "pa"),
}
_DEGREES = ("deg", "degree", "degrees")
_ANGLES = ("ALPMIN", "ALPMAX", "CAMMIN", "CAMMAX")
_NUMBER = re.compile(r"^[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?$")


@dataclass
class TirFile:
    """Content of a file.

    Attributes
    ----------
    path : str
    numbers, texts : dict
        Values by name in upper case.
    lines : dict
        Line of each name, counted from 1.
    sections : dict
        Line of each section by its name in upper case.
    repeated : list
        Names that stand twice with different values: name, line of the first, line of the second.
    """

    path: str
    numbers: dict[str, float] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)
    lines: dict[str, int] = field(default_factory=dict)
    sections: dict[str, int] = field(default_factory=dict)
    repeated: list[tuple[str, int, int]] = field(default_factory=list)

    def fault(self, name: str, problem: str, *, found: str = "", allowed: str = "") -> Fault:
        """A fault at the line of a name, at the end of the file if the name is missing."""
        return Fault(self.path, self.lines.get(name, 0), 1 if name in self.lines else 0, name, problem, found, allowed)


def read_tir_file(path: str | Path) -> TirFile:
    """Read names and values; units are checked to be SI (angle limits may be in degrees).

    Raises
    ------
    InputError
        If the file cannot be read, has lines that are none of a ``.tir`` file, or other units than SI.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise InputError(f"{path}: {(error.strerror or str(error)).lower()}") from None
    if b"\x00" in content[:4096]:
        raise InputError(f"{path}: not a text file", allowed="a .tir file of a tyre program")
    tir = TirFile(str(path))
    faults: list[Fault] = []
    in_table = False
    # tyre programs write these files in the code page of their machine; only comments have more than ASCII
    for number, raw in enumerate(content.decode("latin-1").splitlines(), 1):
        line = _without_comment(raw)
        if not line:
            continue
        if line.startswith("["):
            in_table = False
            tir.sections.setdefault(line.strip("[] ").upper(), number)
        elif line.startswith("{"):
            in_table = True
        elif "=" in line:
            _take(tir, line, number)
        elif not (in_table and all(_NUMBER.match(word) for word in line.split())):
            faults.append(Fault(tir.path, number, 1, "", "no line of a .tir file", repr(line[:40]), "NAME = value"))
    if not tir.sections:
        raise InputError(f"{path}: no section, e.g. [MODEL]", allowed="a .tir file of a tyre program")
    faults += _unit_faults(tir)
    if faults:
        raise FileFaults(faults, tir.path)
    return tir


def _without_comment(raw: str) -> str:
    line = raw.strip()
    if line.startswith(("!", "$", "#")):
        return ""
    inside = False
    for place, character in enumerate(line):
        if character in "'\"":
            inside = not inside
        elif character in "$!" and not inside:
            return line[:place].rstrip()
    return line


def _take(tir: TirFile, line: str, number: int) -> None:
    name, _, text = line.partition("=")
    name, text = name.strip().upper(), text.strip()
    first = tir.lines.get(name, 0)
    tir.lines[name] = number
    if not text:  # a blank value stands for a missing one
        return
    if _NUMBER.match(text):
        value = float(text.lower().replace("d", "e"))
        if tir.numbers.get(name, value) != value:
            tir.repeated.append((name, first, number))
        tir.numbers[name] = value
    else:
        tir.texts[name] = text.strip("'\"").strip()


def _unit_faults(tir: TirFile) -> list[Fault]:
    faults = []
    for name, allowed in _SI.items():
        unit = tir.texts.get(name, "").lower()
        if name == "ANGLE" and unit in _DEGREES:
            for limit in _ANGLES:
                if limit in tir.numbers:
                    tir.numbers[limit] = math.radians(tir.numbers[limit])
        elif unit and unit not in allowed:
            faults.append(tir.fault(name, "not an SI unit", found=repr(tir.texts[name]), allowed=allowed[0]))
    return faults


def missing(tir: TirFile, required: Mapping[str, Sequence[str]]) -> list[Fault]:
    """Faults for names that a file has to give and does not; one for a section that it lacks altogether.

    Parameters
    ----------
    required : mapping
        Section → names, which may stand elsewhere too.
    """
    faults = []
    known = {name for names in required.values() for name in names}
    for section, names in required.items():
        absent = [name for name in names if name not in tir.numbers]
        if len(absent) == len(names) and section not in tir.sections:
            allowed = f"[{section}] with {', '.join(names)}"
            faults.append(Fault(tir.path, 0, 0, f"[{section}]", "section is missing", allowed=allowed))
            continue
        for name in absent:
            near = nearest_name(name, [other for other in tir.numbers if other not in known])
            problem = "needs a number" if name in tir.lines else f"is missing in [{section}]"
            line = tir.lines.get(name) or tir.sections.get(section, 0)
            faults.append(Fault(tir.path, line, 1 if line else 0, name, problem, nearest=near))
    return faults
