"""Command of the generator: ``python generate.py cases --seed 1 --n 20 --out cases --sealed sealed``."""

import argparse
import json
import sys
from pathlib import Path

from hidden_effects.case import GENERATORS, Case, write_manifest
from hidden_effects.effects import EFFECTS
from hidden_effects.families import FAMILIES
from hidden_effects.isolability import limits_table
from hidden_effects.manoeuvres import tabulated


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; 0 where everything was written."""
    parser = argparse.ArgumentParser(prog="generate.py", description="Measured-like logs with a hidden effect.")
    commands = parser.add_subparsers(dest="command", required=True)
    cases = commands.add_parser("cases", help="write cases and, apart from them, their sealed labels")
    cases.add_argument("--seed", type=int, required=True)
    cases.add_argument("--n", type=int, required=True)
    cases.add_argument("--out", type=Path, required=True, help="folder of the cases")
    cases.add_argument("--sealed", type=Path, required=True, help="folder of salts and labels")
    cases.add_argument("--family", choices=FAMILIES)
    cases.add_argument("--generator", choices=tuple(GENERATORS), default="first")
    cases.add_argument("--only", type=int, nargs="*", help="numbers of the cases; by default all")
    separate = commands.add_parser("separate", help="expected log evidence for the truth of a case against rivals")
    separate.add_argument("--rivals", nargs="+", required=True, help="names of effects")
    precision = commands.add_parser("precision", help="how precisely a case tells the value of its effects, at best")
    courses = commands.add_parser("courses", help="what the unknown term of a case does to the brakes over time")
    further = commands.add_parser("further", help="write a case again with more data")
    further.add_argument("--out", type=Path, required=True, help="folder of the case")
    further.add_argument("--script", type=Path, help="JSON of a manoeuvre: name, speed, and lists over time")
    further.add_argument("--channel", default="", help="channel that is recorded this time")
    for one in (separate, precision, courses, further):
        one.add_argument("--seed", type=int, required=True)
        one.add_argument("--index", type=int, required=True)
        one.add_argument("--family", choices=FAMILIES)
        one.add_argument("--generator", choices=tuple(GENERATORS), default="first")
    commands.add_parser("limits", help="sizes from which the shipped manoeuvres show each effect, by theory")
    commands.add_parser("effects", help="effects that can be hidden: units, largest deviations")
    given = parser.parse_args(arguments)
    called = {
        "cases": _cases,
        "separate": _separate,
        "precision": _precision,
        "courses": _courses,
        "further": _further,
        "limits": _limits,
        "effects": _effects,
    }
    return called[given.command](given)


def _cases(given: argparse.Namespace) -> int:
    facts = {"seed": given.seed, "n": given.n, "family": given.family, "generator": given.generator}
    given.out.mkdir(parents=True, exist_ok=True)
    write_manifest(given.out, facts)
    for index in given.only if given.only is not None else range(given.n):
        case = Case(given.seed, index, given.family, given.generator)
        case.write(given.out / f"case_{index:04d}", given.sealed / f"case_{index:04d}.json")
        print(f"case_{index:04d}", flush=True)
    return 0


def _separate(given: argparse.Namespace) -> int:
    print(json.dumps(_case(given).separation(given.rivals)))
    return 0


def _precision(given: argparse.Namespace) -> int:
    print(json.dumps(_case(given).value_stds()))
    return 0


def _courses(given: argparse.Namespace) -> int:
    print(json.dumps(_case(given).torque_courses()))
    return 0


def _further(given: argparse.Namespace) -> int:
    scripts = []
    if given.script is not None:
        table = json.loads(given.script.read_text(encoding="utf-8"))
        scripts.append(tabulated(table["name"], table))
    _case(given).write_further(given.out, scripts, given.channel)
    return 0


def _case(given: argparse.Namespace) -> Case:
    return Case(given.seed, given.index, given.family, given.generator)


def _limits(given: argparse.Namespace) -> int:
    print(json.dumps(limits_table()))
    return 0


def _effects(given: argparse.Namespace) -> int:
    facts = [
        {
            **{name: getattr(one, name) for name in ("name", "unit", "relative", "places")},
            "extremes": [sign * one.largest * one.scatter for sign in one.signs],
        }
        for one in EFFECTS
    ]
    print(json.dumps(facts))
    return 0


if __name__ == "__main__":
    sys.exit(main())
