"""``bench campaign``: a scenario under many faults, the report of what they did, and single runs of it again."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from bench.commands.options import JsonOption, finish, print_json

if TYPE_CHECKING:
    from bench.campaign.engine import Progress

FolderArgument = Annotated[
    str | None, typer.Argument(help="Folder of a campaign, or its name under runs/campaigns; default: the latest.")
]


class RunByDefault(TyperGroup):
    """Takes what is no subcommand for the campaign file of ``run``."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The subcommand, its name and its arguments."""
        if args and args[0] not in self.commands:
            args = ["run", *args]
        return super().resolve_command(ctx, args)


app = typer.Typer(
    name="campaign",
    cls=RunByDefault,
    no_args_is_help=True,
    help="A scenario under many faults: what each of them does to the car.\n\n"
    "Examples: bench campaign campaigns/wheel_speed_bits --workers 2\n\n"
    "bench campaign report --open\n\n"
    "bench campaign show 3f2a91bc04de",
)


@app.command("run")
def run(
    campaign: Annotated[str, typer.Argument(help="Path of a campaign file, or the id of one.")],
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes on this machine. Default: one per core.")
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Run on the workers of this dask.distributed scheduler instead."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder of the campaign. Default: runs/campaigns/<id>.")
    ] = None,
    plain: Annotated[bool, typer.Option("--plain", help="No progress lines.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Make the runs of a campaign; the same command again goes on where it was stopped.

    Exit codes: 0 done, 1 a limit of the campaign is broken, 2 a bad file, 4 a run has no result.

    Examples: bench campaign campaigns/wheel_speed_bits

    bench campaign run my.yaml --workers 2 --out results/my

    bench campaign run my.yaml --scheduler tcp://10.0.0.5:8786
    """
    from bench.campaign.engine import CampaignRun, read_campaign
    from bench.campaign.printing import print_summary, summary_json
    from bench.campaign.report_page import build
    from bench.campaign.store import read_rows
    from bench.campaign.summary import summarise
    from bench.scenario.locate import find_scenario

    path = find_scenario(campaign)
    read = read_campaign(path)
    folder = out or Path("runs") / "campaigns" / read.id.replace("/", "-")
    quiet = plain or as_json
    running = CampaignRun(read, path, folder, None if quiet else _Lines().say)
    if not quiet:
        print(f"campaign  {read.id}: {read.title}", flush=True)
        print(f"space     {running.space.singles} single faults; strategy {read.strategy.kind}", flush=True)
        print(f"folder    {folder}", flush=True)
    progress = running.run(workers, scheduler)
    summary = summarise(read, list(read_rows(folder)))
    page = build(folder)
    if as_json:
        print_json(summary_json(summary, folder, progress))
    else:
        print_summary(summary, folder, progress)
        print(f"report: {page}")
    finish(summary.exit_code)


class _Lines:
    """A line of progress every few seconds."""

    EVERY_S = 5.0

    def __init__(self) -> None:
        self._next = 0.0

    def say(self, progress: "Progress") -> None:
        """Print a line if it is time."""
        if progress.wall_s < self._next:
            return
        self._next = progress.wall_s + self.EVERY_S
        print(
            f"          {progress.known + progress.made} runs, {progress.hazardous} hazardous, "
            f"{progress.per_hour:.0f} per hour on {progress.workers} workers",
            file=sys.stderr,
            flush=True,
        )


@app.command("report")
def report(
    campaign: FolderArgument = None,
    open_page: Annotated[bool, typer.Option("--open", help="Show the page in the browser.")] = False,
    as_markdown: Annotated[
        bool, typer.Option("--markdown", help="Print the table as Markdown, by class of fault and variant.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Make the page of a campaign and print its figures; also of one that is still running.

    Exit codes are those of `bench campaign run`.

    Example: bench campaign report runs/campaigns/campaigns-wheel_speed_bits --open
    """
    from bench.campaign.folders import campaign_of, find_campaign
    from bench.campaign.printing import markdown, print_summary, summary_json
    from bench.campaign.report_page import build
    from bench.campaign.store import read_rows
    from bench.campaign.summary import summarise

    folder = find_campaign(campaign)
    summary = summarise(campaign_of(folder), list(read_rows(folder)))
    page = build(folder)
    if as_json:
        print_json(summary_json(summary, folder, None) | {"report": str(page)})
    elif as_markdown:
        print("\n".join(markdown(summary)))
    else:
        print_summary(summary, folder, None)
        print(f"report: {page}")
    if open_page:
        typer.launch(page.absolute().as_uri())
    finish(summary.exit_code)


@app.command("show")
def show(
    run_id: Annotated[str, typer.Argument(metavar="ID", help="Key of a run, or the beginning of it.")],
    campaign: Annotated[
        str | None, typer.Option("--campaign", metavar="DIR", help="Folder of the campaign; default: any below runs/.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder of the run. Default: show/<ID> in the campaign's.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Repeat one run of a campaign with recording, verdict and report, and say whether it came out the same.

    Exit codes: 0 the car moved the same, bit for bit; 1 it did not; 2 there is no such run.

    Example: bench campaign show 3f2a91bc04de --campaign runs/campaigns/campaigns-wheel_speed_bits
    """
    from bench.campaign.showing import repeat

    repeated = repeat(run_id, campaign, out)
    if as_json:
        print_json(repeated.as_json())
    else:
        for line in repeated.lines():
            print(line)
    finish(0 if repeated.same else 1)
