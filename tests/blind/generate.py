"""Command of the generator: ``python generate.py cases --seed 1 --n 20 --out cases --sealed sealed``."""

import argparse
import sys
from pathlib import Path

from hidden_effects.case import GENERATORS, Case, write_manifest
from hidden_effects.families import FAMILIES


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
    return _cases(parser.parse_args(arguments))


def _cases(given: argparse.Namespace) -> int:
    facts = {"seed": given.seed, "n": given.n, "family": given.family, "generator": given.generator}
    given.out.mkdir(parents=True, exist_ok=True)
    write_manifest(given.out, facts)
    for index in given.only if given.only is not None else range(given.n):
        case = Case(given.seed, index, given.n, given.family, given.generator)
        case.write(given.out / f"case_{index:04d}", given.sealed / f"case_{index:04d}.json")
        print(f"case_{index:04d}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
