"""The command line ``bench``: subcommands, exit codes, and the one place where errors become messages."""

import json
import os
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

import typer

from bench.commands import (
    batch,
    campaign,
    check,
    cluster,
    compare,
    compare_surfaces,
    diagnose,
    doctor,
    ecu,
    estimate,
    estimators,
    inject,
    judge,
    listing,
    recover,
    replay,
    report,
    road,
    run,
    runs,
    schema,
    tyre,
    vehicle,
)
from signals.errors import INTERRUPTED, BenchError, FileFaults

BAD_USAGE = 2
UNEXPECTED = 4

EXIT_CODES = """Exit codes: **0** pass or done · **1** ran, verdict fail · **2** bad usage or bad input file ·
**3** verdict inconclusive · **4** error while running (link, ECU, disk, a defect) · **130** interrupted."""

app = typer.Typer(
    name="bench",
    help="Hardware-in-the-loop test bench for ABS and ESC control units. First: `bench run friction/e4_abs_dry_95`",
    epilog=EXIT_CODES,
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["--help", "-h"], "max_content_width": 120},
)
app.command("run")(run.run)
app.command("ecu")(ecu.ecu)
app.command("cluster")(cluster.cluster)
app.command("batch")(batch.batch)
app.command("list")(listing.list_scenarios)
app.command("check")(check.check)
app.command("doctor")(doctor.doctor)
app.command("inject")(inject.inject)
app.command("report")(report.report)
app.command("replay")(replay.replay)
app.command("recover")(recover.recover)
app.command("judge")(judge.judge)
app.command("runs")(runs.runs)
app.command("compare")(compare.compare)
app.command("compare-surfaces")(compare_surfaces.compare_surfaces)
app.command("estimate")(estimate.estimate)
app.command("schema")(schema.schema)
app.add_typer(campaign.app, name="campaign")
app.add_typer(diagnose.app, name="diagnose")
app.add_typer(estimators.app, name="estimators")
app.add_typer(vehicle.app, name="vehicle")
app.add_typer(tyre.app, name="tyre")
app.add_typer(road.app, name="road")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments : sequence of str, optional
        Without the program's name; by default those of this process, which then ends with the exit code.

    Returns
    -------
    int
        Exit code.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    code = _run(given)
    if arguments is None:
        _leave(code)
    return code


def _run(arguments: list[str]) -> int:
    wants_json = "--json" in arguments
    try:
        result = app(args=arguments, prog_name="bench", standalone_mode=False)
    except BenchError as error:
        return _failed(_text_of(error, arguments), error.exit_code, wants_json)
    except typer.Abort:
        return _failed("interrupted", INTERRUPTED, wants_json)
    except typer.TyperException as error:
        return _usage(error, wants_json)
    except typer.Exit as leave:
        return leave.exit_code
    except KeyboardInterrupt:
        return _failed("interrupted", INTERRUPTED, wants_json)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:
        return _failed(_unexpected(error), UNEXPECTED, wants_json)
    if result == INTERRUPTED:  # typer has made this of a KeyboardInterrupt
        return _failed("interrupted", INTERRUPTED, wants_json)
    return result if isinstance(result, int) else 0


def _text_of(error: BenchError, arguments: Sequence[str]) -> str:
    """A file's faults: all of them from `check`, the first ones elsewhere."""
    return error.message if isinstance(error, FileFaults) and arguments[:1] == ["check"] else str(error)


def _failed(message: str, code: int, wants_json: bool) -> int:
    first, *rest = message.splitlines() or [""]
    prefix = "" if code == INTERRUPTED else "error: "
    print("\n".join([f"{prefix}{first}", *rest]), file=sys.stderr)
    if wants_json:
        print(json.dumps({"error": message, "exit_code": code}, ensure_ascii=False))
    return code


def _usage(error: typer.TyperException, wants_json: bool) -> int:
    context = getattr(error, "ctx", None)
    if not error.format_message():
        return BAD_USAGE  # no command was given, and the help was printed
    hint = f"\n  see: {context.command_path} --help" if context is not None else "\n  see: bench --help"
    return _failed(f"{error.format_message()}{hint}", BAD_USAGE, wants_json)


def _unexpected(error: Exception) -> str:
    """One line for what nobody expected; the traceback goes to a log file."""
    from signals.compile_cache import cache_root

    text = f"{type(error).__name__}: {error}".splitlines()[0]
    log = Path(os.environ.get("BENCH_LOG") or cache_root() / "bench.log")
    try:
        log.parent.mkdir(parents=True, exist_ok=True)
        with log.open("a", encoding="utf-8") as stream:
            stream.write("".join(traceback.format_exception(error)) + "\n")
    except OSError:
        return f"{text}\n{''.join(traceback.format_tb(error.__traceback__, limit=-1)).strip()}"
    return f"{text}\n  a defect of the bench; details: {log}"


def _leave(code: int) -> None:
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.exit(code)


if __name__ == "__main__":
    main()
