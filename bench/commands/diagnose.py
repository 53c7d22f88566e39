"""``bench diagnose``: what the simulation of a car gets wrong on measured data, and why."""

from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from bench.commands import diagnose_challenge
from bench.commands.options import JsonOption, finish, print_json

DEFAULT = "logs"

Logs = Annotated[list[str], typer.Argument(metavar="LOG...", help="Measured logs, or runs of the bench.")]
VehicleOption = Annotated[
    str | None, typer.Option(metavar="NAME|FILE", help="Car; without it that of a run's scenario.")
]
ChannelsOption = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Channel map of measured logs; runs of the bench need none.")
]


class LogsFirst(TyperGroup):
    """Takes the first word as a log where it is no subcommand, and shows the options of that in its help."""

    _showing_help = False

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put the name of the default command in front where a log or an option comes first."""
        if args and args[0] not in self.commands and args[0] not in ctx.help_option_names:
            args = [DEFAULT, *args]
        return super().parse_args(ctx, args)

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Help with the options of the default command."""
        self._showing_help = True
        super().format_help(ctx, formatter)
        self._showing_help = False

    def get_params(self, ctx: Any) -> list[Any]:
        """Parameters; in the help those of the default command."""
        return self.commands[DEFAULT].get_params(ctx) if self._showing_help else super().get_params(ctx)

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Usage line."""
        return ["LOG...", "[OPTIONS] | COMMAND [ARGS]..."]


app = typer.Typer(cls=LogsFirst, no_args_is_help=True, rich_markup_mode="markdown")


@app.callback()
def diagnose() -> None:
    """Say what the simulation of a car gets wrong on measured data, name the cause, extend the car, measure the gain.

    Logs are MF4, CSV, Parquet, or BLF, ASC and candump with a DBC, read through a channel map; or runs of the bench.
    Results: diagnosis.html (pictures first), diagnosis.json and, where something was found that also gains on data
    that took no part, extended_vehicle.yaml. Exit code 3 where the data cannot answer. How to read it:
    docs/diagnosis.md.

    Examples: bench diagnose runs/worn_pads --vehicle ekf_car

    bench diagnose stops.mf4 turns.mf4 --vehicle car.yaml --channels map.yaml --hold-out monday.mf4 --out result

    bench diagnose lap.csv --vehicle car.yaml --channels map.yaml --hold-out-share 0.5 --at-most 120
    """


@app.command(DEFAULT, hidden=True)
def logs(
    logs: Logs,
    vehicle: VehicleOption = None,
    channels: ChannelsOption = None,
    hold_out: Annotated[
        list[str] | None,
        typer.Option("--hold-out", metavar="LOG", help="Log that only measures the gain; repeat for several."),
    ] = None,
    hold_out_share: Annotated[
        float,
        typer.Option(
            min=0.0, max=0.9, metavar="SHARE", help="Share of each drive, from its end, that only measures the gain."
        ),
    ] = 0.0,
    at_most: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="Search only the liveliest manoeuvres of long logs, of so much time."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Default: diagnosis/ in the run's folder, or diagnosis/LOG for another log."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the bootstraps.")] = 0,
    open_page: Annotated[bool, typer.Option("--open", help="Show the page in the browser.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Diagnose logs.

    Example: bench diagnose logs runs/worn_pads --vehicle ekf_car
    """
    from bench.diagnosis.diagnosing import PAGE_FILE, default_folder, find, write
    from bench.diagnosis.printing import print_diagnosis
    from bench.diagnosis.progress import SearchProgress
    from bench.report.summary import output_console

    with SearchProgress() as progress:
        found = find(
            logs,
            vehicle,
            channels=channels,
            hold_out=hold_out or [],
            hold_out_share=hold_out_share,
            at_most_s=at_most,
            seed=seed,
            progress=progress,
        )
        progress("page and extended car", 0.98)
        written = write(found, out or default_folder(logs))
    if as_json:
        print_json(written.as_json())
    else:
        print_diagnosis(written, output_console())
    if open_page:
        typer.launch((written.folder / PAGE_FILE).absolute().as_uri())
    finish(written.exit_code)


@app.command("map")
def suggest_map(
    logs: Annotated[list[str], typer.Argument(metavar="LOG...", help="Logs that nobody has mapped yet.")],
    vehicle: Annotated[
        str, typer.Option(metavar="NAME|FILE", help="Car: units are told by its radii, steering and brakes.")
    ],
    dbc: Annotated[Path | None, typer.Option(metavar="FILE", help="Database of CAN logs.")] = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="Default: LOG_channels.yaml.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Suggest a channel map: which column is which signal, by its name, unit, sign and the way it goes.

    Wheel speeds, accelerations, yaw rate, steering and pressures measure one motion: by that a column in degrees, or
    one that counts the other way, is found, and columns whose names say nothing. Every line of the file tells why.

    Example: bench diagnose map stops.csv --vehicle car.yaml --out map.yaml
    """
    from bench.diagnosis.channel_mapping import print_map, suggest
    from bench.diagnosis.progress import SearchProgress
    from bench.report.summary import output_console

    with SearchProgress(quiet=as_json) as progress:
        written = suggest(logs, vehicle, dbc, out, progress)
    if as_json:
        print_json(written.as_json())
    else:
        print_map(written, logs, vehicle, output_console())


@app.command("explain")
def explain(
    effect: Annotated[
        str, typer.Argument(metavar="EFFECT", help="Name of an effect; bench diagnose effects lists them.")
    ],
    as_json: JsonOption = False,
) -> None:
    """Explain an effect of the catalogue: equation, parameters, where it shows, what it looks like.

    Example: bench diagnose explain brake_pad_friction
    """
    from bench.diagnosis.explaining import effect_json, effect_text
    from model_diagnosis.effects.catalogue import effect as find_effect

    found = find_effect(effect)
    if as_json:
        print_json(effect_json(found))
    else:
        print(effect_text(found))


@app.command("effects")
def effects(
    text: Annotated[str, typer.Argument(help="Only those whose name, group or equation contains this.")] = "",
    as_json: JsonOption = False,
) -> None:
    """List the effects that a diagnosis can name.

    Example: bench diagnose effects hydraulics
    """
    from bench.diagnosis.explaining import catalogue_text, effect_json
    from model_diagnosis.effects.catalogue import EFFECTS
    from signals.errors import InputError

    wanted = text.lower()
    shown = [e for e in EFFECTS if wanted in f"{e.name} {e.group.value} {e.equation}".lower()]
    if not shown:
        raise InputError(f"no effect contains {text!r}", mend="all of them: bench diagnose effects")
    if as_json:
        print_json([effect_json(e) for e in shown])
    else:
        print(catalogue_text(shown))


@app.command("plan")
def plan(
    effects: Annotated[
        list[str], typer.Argument(metavar="DIR|EFFECT...", help="Folder of a diagnosis, or effects to be told apart.")
    ],
    vehicle: VehicleOption = None,
    channels: ChannelsOption = None,
    size: Annotated[
        float, typer.Option(min=0.01, help="Size of the effects, in their usual sizes (bench diagnose explain).")
    ] = 1.0,
    as_json: JsonOption = False,
) -> None:
    """Say which manoeuvre would tell causes apart that a diagnosis could not.

    Every manoeuvre of a library is simulated with the car and ranked by the evidence to be expected of it; 3 is enough.
    Where none is enough, the sensor is named that would be.

    Examples: bench diagnose plan runs/worn_pads/diagnosis --vehicle ekf_car

    bench diagnose plan mass_change aero_drag --vehicle ekf_car
    """
    from bench.diagnosis.planning import plan_json, plan_text, planned
    from bench.diagnosis.progress import SearchProgress

    with SearchProgress(quiet=as_json) as progress:
        result = planned(effects, vehicle, channels=channels, size=size, progress=progress)
    if as_json:
        print_json(plan_json(result))
    else:
        print(plan_text(result))


app.command("challenge")(diagnose_challenge.challenge)
