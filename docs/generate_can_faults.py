"""Write the table of docs/can_faults.md from the models of the fault files: ``python docs/generate_can_faults.py``."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/can_faults.md"
BEGIN, END = "<!-- vocabulary: begin -->", "<!-- vocabulary: end -->"
sys.path.insert(0, str(ROOT))

_TITLES = {
    "bit": "Bits, rules of the frame, flags",
    "frame": "Whole frames",
    "signal": "Signals in frames",
    "node": "Nodes",
    "wire": "Wires",
}


def vocabulary() -> str:
    """Tables of all kinds of disturbances, one for each group."""
    from can_fault_injector.faults.vocabulary import kinds

    listed = list(kinds())
    lines: list[str] = []
    for group, title in _TITLES.items():
        lines += [f"### {title}", "", "| `disturbance` | What it does | Fields | E2E class | Realised as |"]
        lines.append("|---|---|---|---|---|")
        for kind in (kind for kind in listed if kind.group == group):
            fields = ", ".join(f"`{name}`" for name in kind.fields) or "–"
            e2e = kind.e2e.replace("_", " ")
            lines.append(f"| `{kind.name}` | {kind.description} | {fields} | {e2e} | `{kind.realised_as}` |")
        lines.append("")
    return "\n".join(lines).rstrip()


def page() -> str:
    """The page with its tables as the models have them now."""
    text = PAGE.read_text("utf-8")
    head, tail = text.split(BEGIN)[0], text.split(END)[1]
    return f"{head}{BEGIN}\n\n{vocabulary()}\n\n{END}{tail}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
