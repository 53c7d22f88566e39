"""Write the figures of docs/case-studies: each log diagnosed as its page says, second half held out.

``python docs/generate_case_studies.py [LOG…] [--from DIR]`` needs the data of BENCH_SHARED_DATA (by default
../shared/data beside the repository) and chromium for the pictures. The text around the figures is written by hand.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from model_diagnosis.result import Diagnosis, OverallGain

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

PAGES = ROOT / "docs" / "case-studies"
SHIPPED = ROOT / "scenarios" / "diagnosis"
DATA = Path(os.environ.get("BENCH_SHARED_DATA", ROOT.parent / "shared" / "data"))
BEGIN, END = "<!-- figures -->", "<!-- end of the figures -->"
WIDTH, HEIGHT = 1280, 1150
SIGNALS_SHOWN = 10


@dataclass(frozen=True)
class Study:
    """A log: its files below the data folder, or what the script beside its map makes of one; most of it to search."""

    files: str
    made: tuple[str, ...] = ()
    at_most_s: float = 30.0


STUDIES = {
    "iac-av21": Study("*.csv.gz"),
    "revs-250lm-2014": Study("*.csv.gz"),
    "comma2k19-rav4": Study("*.npz", ("can.log", "steering.csv", "pose.csv")),
    "carmaker-bosch": Study("*.CSV.gz"),
    "tyre-rig-ttc-deid": Study("*.csv.gz"),
}


def logs_of(name: str, folder: Path) -> list[Path]:
    """Logs of a study; converted ones are made in ``folder``."""
    study = STUDIES[name]
    files = sorted((DATA / name).glob(study.files))
    if not study.made:
        return files
    subprocess.run([sys.executable, str(SHIPPED / name / "convert.py"), str(files[0]), str(folder)], check=True)
    return [folder / file for file in study.made]


def diagnosed(name: str, folder: Path) -> None:
    """Diagnose a log as ``bench diagnose`` does and write its files into ``folder``."""
    from bench.diagnosis.diagnosing import find, write
    from bench.diagnosis.progress import SearchProgress

    with SearchProgress() as progress:
        found = find(
            [str(path) for path in logs_of(name, folder)],
            SHIPPED / name / "vehicle.yaml",
            channels=SHIPPED / name / "channels.yaml",
            hold_out_share=0.5,
            at_most_s=STUDIES[name].at_most_s,
            progress=progress,
        )
    write(found, folder)


def pictured(folder: Path, picture: Path, height: int = HEIGHT) -> None:
    """Top of the page as an image."""
    picture.parent.mkdir(parents=True, exist_ok=True)
    command = ["chromium", "--headless", "--no-sandbox", "--hide-scrollbars", "--force-device-scale-factor=1"]
    command += [f"--window-size={WIDTH},{height}", f"--screenshot={picture}"]
    subprocess.run([*command, (folder / "diagnosis.html").absolute().as_uri()], check=True, capture_output=True)


def figures(name: str, answer: dict[str, Any]) -> str:
    """What the run printed, as tables."""
    from bench.diagnosis_report.words import BADGES, headline
    from model_diagnosis.result import Diagnosis

    diagnosis = Diagnosis.model_validate({key: answer[key] for key in Diagnosis.model_fields if key in answer})
    parts = [
        f"![top of the diagnosis page of {name}](images/{name}.png)",
        f"**{BADGES[diagnosis.verdict][1]}.** {headline(diagnosis)}",
        _faults(diagnosis),
        _causes(diagnosis),
        _gain(diagnosis),
        _rest(diagnosis),
    ]
    return "\n\n".join(part for part in parts if part)


def _table(heads: list[str], rows: list[list[str]]) -> str:
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join([*lines, *("| " + " | ".join(cell.replace("|", "∣") for cell in row) + " |" for row in rows)])


def _faults(diagnosis: "Diagnosis") -> str:
    if not diagnosis.data_faults:
        return "No fault of the data was found."
    rows = [[f"`{f.kind}`", f"`{f.channel}`", f.message] for f in diagnosis.data_faults]
    return "Faults of the data:\n\n" + _table(["fault", "channel", "what it means"], rows)


def _causes(diagnosis: "Diagnosis") -> str:
    from bench.diagnosis_report.words import parameter_texts, percent

    rows = []
    for cause in diagnosis.causes:
        others = ", ".join(f"`{name}`" for name in cause.group if name != cause.effect)
        for text in parameter_texts(cause):
            value = f"{text.name}: {text.value} {text.interval}"
            rows.append([f"`{cause.effect}`", percent(cause.probability), value, text.nominal, others])
    for term in diagnosis.discovered_terms:
        rows.append([f"term on {term.target}", percent(term.inclusion), term.formula, "", ""])
    heads = ["cause", "probability", "value and 90 % interval", "vehicle file", "not told from"]
    return _table(heads, rows) if rows else ""


def _gain(diagnosis: "Diagnosis") -> str:
    from bench.report.formatting import number

    gain = diagnosis.gain
    if gain is None:
        return "Nothing was built in, so there is no gain to measure."
    words = f"Error left on the second half: {_percent(gain.overall)}"
    if gain.against_refit is not None:
        words += "; against a refit of all nominal parameters within two of their scatters: "
        words += _percent(gain.against_refit)
    rows = [
        [f"`{signal}`", f"{number(one.before, 3)} {one.unit}", f"{number(one.after, 3)} {one.unit}",
         f"{number(one.low, 3)} … {number(one.high, 3)}", f"{number(one.noise_floor, 3)}"]
        for signal, one in list(gain.held_out.items())[:SIGNALS_SHOWN]
    ]  # fmt: skip
    return words + ".\n\n" + _table(["signal", "before", "after", "90 % interval", "sensor's noise"], rows)


def _percent(overall: "OverallGain") -> str:
    return f"{100 * overall.ratio:.0f} % [{100 * overall.low:.0f}, {100 * overall.high:.0f}]"


def _rest(diagnosis: "Diagnosis") -> str:
    lit = sorted(diagnosis.guilty_equations.items(), key=lambda item: -item[1])[:4]
    lines = ["Violated equations, the worst first: " + ", ".join(f"{name}" for name, _ in lit) + "."] if lit else []
    lines += [f"- {remark}" for remark in diagnosis.remarks]
    lines.append(f"\n{len(diagnosis.insufficient)} effects are not excited by this data.")
    return "\n".join(lines)


def main() -> int:
    """Write the figures of the pages."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("log", nargs="*", help=f"of {', '.join(STUDIES)}; all without one")
    parser.add_argument("--from", dest="given", type=Path, help="folder of a diagnosis that was already made")
    arguments = parser.parse_args()
    for name in arguments.log or STUDIES:
        if not (DATA / name).is_dir():
            print(f"{DATA / name}: no such folder; set BENCH_SHARED_DATA")
            return 2
        with tempfile.TemporaryDirectory() as temporary:
            folder = arguments.given or Path(temporary)
            if arguments.given is None:
                diagnosed(name, folder)
            answer = json.loads((folder / "diagnosis.json").read_text("utf-8"))
            pictured(folder, PAGES / "images" / f"{name}.png")
        page = PAGES / f"{name}.md"
        before, _, rest = page.read_text("utf-8").partition(BEGIN)
        after = rest.partition(END)[2]
        page.write_text(f"{before}{BEGIN}\n\n{figures(name, answer)}\n\n{END}{after}", "utf-8")
        print(page.relative_to(ROOT))
    return 0


if __name__ == "__main__":
    sys.exit(main())
