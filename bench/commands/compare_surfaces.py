"""``bench compare-surfaces``: two asphalts by braking distance and friction."""

from pathlib import Path
from typing import Annotated

import typer

from bench.commands.options import JsonOption, finish, print_json


def compare_surfaces(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Surfaces, stops on each, and record of the tests.")],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Default: comparison/ beside the working folder's other results.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Compare two asphalts from stops on each, by the method of the friction document (4.5).

    Nine rules are checked, distances corrected to the target speed run by run, friction estimated by the friction EKF
    without torques and by the simple model. Exit code 3 where a rule is broken or not shown to be kept.

    Example: bench compare-surfaces site1_dry.yaml --out comparison/site1
    """
    from bench.estimation.surfaces import compare_surfaces as compare
    from bench.estimation.surfaces_file import SurfaceComparisonFile
    from bench.estimation.surfaces_output import as_json as result_as_json
    from bench.estimation.surfaces_output import text_of, write_comparison
    from signals.yaml_files import load_yaml, validate

    document = load_yaml(file)
    result = compare(validate(document, SurfaceComparisonFile), document.folder)
    folder = out or Path("comparison") / file.stem
    write_comparison(folder, result)
    if as_json:
        print_json(result_as_json(result) | {"folder": str(folder)})
    else:
        print(text_of(result))
        print(f"files: {folder}")
    finish(result.exit_code)
