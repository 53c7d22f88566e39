"""``bench tyre``: tyres beside the car: list, figures, pictures, and fits to measurements of a rig."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.commands.options import JsonOption, print_json

if TYPE_CHECKING:
    from bench.tyre_bench.characteristics import Characteristics

app = typer.Typer(
    help="Tyres: list, figures, pictures, fits to measurements.", no_args_is_help=True, rich_markup_mode="markdown"
)

TyreArgument = Annotated[
    list[str],
    typer.Argument(metavar="TYRE…", help="A .tir file, a tyre file, or a shipped tyre; NAME:rear for the rear one."),
]
LoadOption = Annotated[str | None, typer.Option("--load", help="Vertical load, e.g. '4 kN'; else the nominal one.")]


@app.callback()
def tyre() -> None:
    """Tyres: list, figures, pictures, fits to measurements."""


@app.command("list")
def list_tyres(as_json: JsonOption = False) -> None:
    """List the tyres that ship with the bench.

    Example: bench tyre list
    """
    from signals.yaml_files import load_yaml
    from vehicle_model.vehicle_file import TYRES

    shipped = {file.stem: load_yaml(file).data.get("description", "") for file in sorted(TYRES.glob("*.yaml"))}
    if as_json:
        print_json(shipped)
        return
    width = max(map(len, shipped))
    for name, description in shipped.items():
        print(f"{name:<{width}}  {description}")


@app.command("show")
def show(tyres: TyreArgument, load: LoadOption = None, as_json: JsonOption = False) -> None:
    """Print peaks, locked wheel, stiffnesses and trail of tyres at a load, without camber, at nominal pressure.

    Examples: bench tyre show reduced_set_t tmeasy

    bench tyre show sedan.tir --load '4 kN' --json
    """
    from bench.tyre_bench.characteristics import characteristics
    from bench.tyre_bench.sources import load_source

    newtons = _newtons(load)
    found = [(source, characteristics(source, newtons)) for source in map(load_source, tyres)]
    if as_json:
        print_json([{"name": source.name, "formula": source.formula} | figures.as_dict() for source, figures in found])
        return
    columns = (
        "tyre",
        "formula",
        "load",
        "braking peak",
        "locked",
        "cornering peak",
        "slip stiffness",
        "cornering",
        "trail",
    )
    rows = [columns, *(_row(source.name, source.formula, figures) for source, figures in found)]
    widths = [max(len(row[place]) for row in rows) for place in range(len(columns))]
    for row in rows:
        print("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    print("forces and stiffnesses are over the load")


def _row(name: str, formula: str, figures: "Characteristics") -> tuple[str, ...]:
    return (
        name,
        formula,
        f"{figures.load_n:.0f} N",
        f"{figures.peak_braking:.3f} at {100.0 * figures.slip_at_peak:.1f} %",
        f"{figures.locked:.3f}",
        f"{figures.peak_cornering:.3f} at {figures.angle_at_peak_deg:.1f}°",
        f"{figures.slip_stiffness:.1f}",
        f"{figures.cornering_stiffness_per_rad:.1f} / rad",
        f"{1e3 * figures.pneumatic_trail_m:.0f} mm",
    )


@app.command("plot")
def plot(
    tyres: TyreArgument,
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="Picture: .png, .svg or .pdf.")] = Path(
        "tyres.png"
    ),
    load: LoadOption = None,
    as_json: JsonOption = False,
) -> None:
    """Draw tyres: longitudinal, lateral, aligning moment, combined slip, friction and stiffness over load.

    One tyre is drawn at several loads, several tyres at one load each.

    Examples: bench tyre plot tmeasy --out tmeasy.png

    bench tyre plot sedan.tir reduced_set_t dugoff --load '4 kN'
    """
    from bench.tyre_bench.sources import load_source
    from bench.tyre_bench.tyre_pictures import checked_ending, draw_tyres

    checked_ending(out)
    picture = draw_tyres([load_source(text) for text in tyres], out, _newtons(load))
    if as_json:
        print_json({"picture": str(picture)})
        return
    print(picture)


@app.command("fit")
def fit(
    data: Annotated[
        list[Path],
        typer.Argument(metavar="DATA…", help="Tables of a tyre rig (CSV, .dat, gzipped too), or folders of them."),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder of the results.")] = Path("tyre_fit"),
    name: Annotated[str, typer.Option("--name", help="Name of the tyre and its file.")] = "fitted",
    compare: Annotated[
        Path | None, typer.Option("--compare", metavar="TIR", help="A .tir file whose errors are printed beside.")
    ] = None,
    unit: Annotated[
        list[str] | None, typer.Option("--unit", metavar="COLUMN=UNIT", help="Unit of a column, e.g. P=psi; repeat.")
    ] = None,
    slip: Annotated[str | None, typer.Option("--slip", help="Column of the slip ratio; else SL, or SR.")] = None,
    sae: Annotated[bool, typer.Option("--sae", help="Lateral signs are those of SAE J670, y to the right.")] = False,
    nominal_load: Annotated[str | None, typer.Option("--nominal-load", help="FNOMIN, e.g. '2750 N'.")] = None,
    nominal_pressure: Annotated[
        str | None, typer.Option("--nominal-pressure", help="NOMPRES, e.g. '0.97 bar'.")
    ] = None,
    radius: Annotated[str | None, typer.Option("--radius", help="UNLOADED_RADIUS, e.g. '0.2 m'.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Fit a Magic Formula 6.1 to drive/brake and cornering measurements of a rig.

    Columns: SL or SR, SA, FX, FY, FZ; and IA, P, V, MX, MZ, RL if there are any. Units and signs are judged from the
    numbers and printed. Writes NAME.tir, fit.png, residuals.png and fit.json.

    Examples: bench tyre fit drivebrake.csv.gz cornering.csv.gz --name slick

    bench tyre fit rig/ --compare theirs.tir --unit P=kPa --out slick_fit
    """
    import sys

    from bench.tyre_bench.fit_command import run_fit

    result = run_fit(
        data,
        out,
        name,
        compare=compare,
        units=_units(unit or []),
        slip=slip,
        sae=sae,
        nominal_load=_quantity("nominal-load", nominal_load, "N"),
        nominal_pressure=_quantity("nominal-pressure", nominal_pressure, "Pa"),
        radius=_quantity("radius", radius, "m"),
        say=lambda line: print(line, file=sys.stderr if as_json else sys.stdout, flush=True),
    )
    if as_json:
        print_json(result)


def _newtons(text: str | None) -> float | None:
    return _quantity("load", text, "N")


def _quantity(name: str, text: str | None, unit: str) -> float | None:
    from signals.errors import InputError
    from signals.quantities import QuantityError, to_si

    if text is None:
        return None
    try:
        value = to_si(text, unit)
    except QuantityError as error:
        raise InputError(f"--{name}: {error}") from None
    if not value > 0.0:
        raise InputError(f"--{name}: not positive", found=text)
    return value


def _units(given: list[str]) -> dict[str, str]:
    from signals.errors import InputError

    units = {}
    for text in given:
        column, equals, unit = text.partition("=")
        if not (column and equals and unit):
            raise InputError(f"--unit: {text!r} is no COLUMN=UNIT", allowed="e.g. P=kPa")
        units[column] = unit
    return units
