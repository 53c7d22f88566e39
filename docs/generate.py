"""Write the pages and schemas that are made from the sources: ``python docs/generate.py``.

docs/scenario_reference.md, docs/errors.md, docs/effects.md and others, and the schemas of the kinds of files.
"""

import json
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

SCHEMA_PLACES = {
    "scenarios/schemas": ("scenario", "procedure", "campaign", "criteria", "mapping", "channel_map"),
    "vehicle_model/schemas": ("vehicle", "tyre", "road", "surfaces"),
    "bench/ecu/schemas": ("calibration",),
    "can_fault_injector/schemas": ("faults",),
}


def pages() -> dict[Path, str]:
    """Content of every generated file by its path."""
    from bench.diagnosis.explaining import effects_page
    from bench.scenario.fault_catalogue import faults_page
    from bench.scenario.file_kinds import schema_of
    from bench.scenario.reference import scenario_reference
    from model_diagnosis.effects.catalogue import EFFECTS

    content = {
        ROOT / "docs/scenario_reference.md": scenario_reference(),
        ROOT / "docs/errors.md": errors_page(),
        ROOT / "docs/faults.md": faults_page(),
        ROOT / "docs/effects.md": effects_page(EFFECTS),
    }
    from docs.generate_parameters import parameters_page

    content[ROOT / "docs/parameters.md"] = parameters_page()
    for folder, kinds in SCHEMA_PLACES.items():
        for kind in kinds:
            text = json.dumps(schema_of(kind), indent=2, ensure_ascii=False)
            content[ROOT / folder / f"{kind}.schema.json"] = text + "\n"
    return content


def errors_page() -> str:
    """The table of bad inputs that a test runs, with what the bench says to each."""
    from signals.yaml_files import load_yaml

    cases = load_yaml(ROOT / "tests/bench/cli/bad_inputs.yaml").data["cases"]
    lines = [
        "# What the bench says to bad input",
        "",
        "Made by `python docs/generate.py` from `tests/bench/cli/bad_inputs.yaml`, which a test runs case by case: the",
        "messages below are what is printed. The files are laid over a correct one (`include: base.yaml`) where they",
        "would be long. Exit code 2 is bad usage or a bad file, 4 an error while running.",
        "",
    ]
    for case in cases:
        command = "bench " + " ".join(case.get("command", ["check", "case.yaml"]))
        lines += [f"## {case['what']}", ""]
        if "file" in case:
            lines += ["```yaml", case["file"].rstrip("\n"), "```", ""]
        lines += [f"`{command}` ends with exit code {case.get('code', 2)}:", "", "```text"]
        lines += [case["message"].rstrip("\n"), "```", ""]
    return "\n".join(lines).rstrip() + "\n"


def main() -> int:
    """Write what has changed."""
    for path, text in pages().items():
        if not path.exists() or path.read_text("utf-8") != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
            print(path.relative_to(ROOT))
    return 0


if __name__ == "__main__":
    sys.exit(main())
