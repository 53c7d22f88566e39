"""Write docs/estimators_robustness*.md and their charts: ``python docs/generate_robustness.py [GROUP [NAME …]]``.

Some eighty lock-step runs and several hundred estimates of them, ten minutes. With a group only its page is written;
with names only these perturbations are run, to look at them, and the page is left alone.
"""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
sys.path.insert(0, str(ROOT / "docs"))

DOCS = ROOT / "docs"


def page_of(group: str) -> Path:
    """File of a group's page."""
    return DOCS / ("estimators_robustness.md" if group == "friction" else f"estimators_robustness_{group}.md")


def images_of(group: str) -> Path:
    """Folder of a group's charts."""
    folder = DOCS / "images" / "robustness"
    return folder if group == "friction" else folder / group


def page(group: str, only: list[str]) -> str:
    """Text of a group's page; charts are written on the way."""
    from robustness_reasons import HEADS, REASONS

    from bench.estimation.robustness import try_all
    from bench.estimation.robustness_output import draw, table
    from bench.estimation.robustness_plans import plan_of

    plan, images = plan_of(group), images_of(group)
    images.mkdir(parents=True, exist_ok=True)
    parts = [HEADS[group]]
    for result in try_all(plan, only, lambda text: print(f"{group}: {text}", file=sys.stderr, flush=True)):
        name, title = result.perturbation.name, result.perturbation.title
        draw(images / f"{name}.png", plan, result)
        parts.append(f"## {title[0].upper()}{title[1:]}\n\n{REASONS[group][name]}\n")
        shown = (images / f"{name}.png").relative_to(DOCS).as_posix()
        parts.append(f"![{title}]({shown})\n\n{table(plan, result)}\n")
    return "\n".join(parts)


def main() -> int:
    """Write the pages, or print what was asked for."""
    from bench.estimation.robustness_plans import PLANS

    groups, only = sys.argv[1:2] or list(PLANS), sys.argv[2:]
    for group in groups:
        text = page(group, only)
        if only:
            print(text)
        else:
            page_of(group).write_text(text, encoding="utf-8")
            print(page_of(group).relative_to(ROOT))
    return 0


if __name__ == "__main__":
    sys.exit(main())
