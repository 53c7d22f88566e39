"""``bench run``: a scenario or a procedure, to its verdict."""

import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bench.commands.options import Interrupted, JsonOption, SetOption, finish, print_json

if TYPE_CHECKING:
    from bench.api import Run


class EcuKind(StrEnum):
    """Who plays the ECU."""

    emulated = "emulated"
    inprocess = "inprocess"
    external = "external"
    none = "none"


def run(
    scenario: Annotated[str, typer.Argument(help="Path of a scenario or procedure file, or the id of one.")],
    realtime: Annotated[bool, typer.Option("--realtime", help="By the wall clock.")] = False,
    lockstep: Annotated[bool, typer.Option("--lockstep", help="In virtual time, reproducible bit for bit.")] = False,
    ecu: Annotated[EcuKind | None, typer.Option(help="Who plays the ECU.")] = None,
    link: Annotated[
        str | None,
        typer.Option(
            metavar="LINK",
            help="virtual, udp[:GROUP:PORT], socketcan:vcan0[,vcan1], slcan:/dev/ttyUSB0@500000, IFACE:CHANNEL. "
            "Default: vcan0 where it exists, else udp.",
        ),
    ] = None,
    vehicle: Annotated[str | None, typer.Option(help="Another car: name of a shipped one, or a file.")] = None,
    seed: Annotated[int | None, typer.Option(help="Of every random number of the run.")] = None,
    sets: SetOption = None,
    variant: Annotated[str | None, typer.Option(help="Run this variant of the scenario.")] = None,
    variants: Annotated[bool, typer.Option("--variants", help="Run all variants, one after the other.")] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder of the run. Default: runs/<scenario>-<time>.")
    ] = None,
    plain: Annotated[
        bool, typer.Option("--plain", help="No dashboard and no progress, only the verdict table.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Run a scenario or a procedure to its verdict, report and recording.

    Examples: bench run stops/dry

    bench run stops/mu_split --lockstep --seed 7 --set brakes.front.pad_friction=0.3

    bench run my.yaml --ecu external --link socketcan:can0 --out results/my
    """
    if realtime and lockstep:
        raise typer.BadParameter("either --realtime or --lockstep")
    pacing = "realtime" if realtime else "lockstep" if lockstep else None
    options: dict[str, Any] = {
        "pacing": pacing,
        "ecu": ecu.value if ecu is not None else None,
        "link": link,
        "vehicle": vehicle,
        "seed": seed,
        "sets": sets or [],
    }
    from bench.scenario.procedure import is_procedure

    try:
        if is_procedure(scenario):
            code = _procedure(scenario, options, out, as_json)
        elif variants:
            code = _variants(scenario, options, out, plain, as_json)
        else:
            result = _one(scenario, {**options, "variant": variant}, out, plain=plain, as_json=as_json)
            if as_json:
                print_json({**result.verdict.as_json(), "folder": str(result.folder)})
            code = result.exit_code
    except KeyboardInterrupt as interrupt:
        raise Interrupted(str(interrupt)) from None
    finish(code)


def _one(scenario: str, options: dict[str, Any], out: Path | None, *, plain: bool, as_json: bool) -> "Run":
    from bench.scenario import resolve

    resolved = resolve(scenario, **options)
    quiet = plain or as_json
    if not quiet:
        print(f"scenario  {resolved.id}: {resolved.title}", flush=True)
        print(f"car       {Path(resolved.vehicle).stem}, plant {resolved.plant}, seed {resolved.seed}", flush=True)
        print(f"ECU       {resolved.ecu.kind}, {resolved.pacing}, link {resolved.ecu.link or 'as found'}", flush=True)
    from bench.api import run as run_scenario

    result = run_scenario(resolved, out=out, dashboard=not quiet, progress=None if quiet else _say)
    if not as_json and result.folder is not None:
        from bench.report import print_summary

        print_summary(result.folder)
    return result


def _say(text: str) -> None:
    print(f"          {text}", file=sys.stderr, flush=True)


def _variants(scenario: str, options: dict[str, Any], out: Path | None, plain: bool, as_json: bool) -> int:
    """Run every variant; the exit code is that of the worst verdict."""
    from bench.scenario.documents import read_document
    from bench.scenario.locate import find_scenario
    from bench.scenario.resolution import variants_of
    from bench.verdict.result import EXIT_CODES, worst
    from signals.errors import InputError

    known = variants_of(read_document(find_scenario(scenario)))
    if not known:
        raise InputError(f"{scenario} declares no variants", mend="add a section `variants:`")
    verdicts = []
    for entry in known:
        folder = None if out is None else out / entry.name
        result = _one(scenario, {**options, "variant": entry.name}, folder, plain=plain, as_json=as_json)
        verdicts.append({"variant": entry.name, "verdict": result.verdict.verdict, "folder": str(result.folder)})
    if as_json:
        print_json({"scenario": scenario, "variants": verdicts})
    return EXIT_CODES[worst(entry["verdict"] for entry in verdicts)]


def _procedure(scenario: str, options: dict[str, Any], out: Path | None, as_json: bool) -> int:
    from bench.scenario.procedure import print_result, run_procedure

    result = run_procedure(scenario, options, out, progress=None if as_json else _say)
    if as_json:
        print_json(result.as_json())
    else:
        print_result(result)
    return result.exit_code
