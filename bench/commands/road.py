"""``bench road``: roads and their pictures."""

from pathlib import Path
from typing import Annotated

import typer

from bench.commands.options import JsonOption, SetOption, print_json

app = typer.Typer(help="Roads and their pictures.", no_args_is_help=True, rich_markup_mode="markdown")


@app.callback()
def road() -> None:
    """Roads and their pictures."""


@app.command("list")
def list_roads(
    name: Annotated[str | None, typer.Argument(help="Name of a shipped road, or a road file.")] = None,
    as_json: JsonOption = False,
) -> None:
    """List the roads; with a name, every parameter of that road that can be changed on-line.

    Examples: bench road list

    bench road list iso_8608_c
    """
    from vehicle_model.road_file import load_road, road_names, road_parameter_table

    if name is None:
        roads = {known: load_road(known).description for known in road_names()}
        if as_json:
            print_json(roads)
        width = max(map(len, roads))
        for known, description in {} if as_json else roads.items():
            print(f"{known:<{width}}  {description}")
        return
    table = road_parameter_table(load_road(name))
    if as_json:
        print_json([vars(info) for info in table])
        return
    width = max(len(info.path) for info in table)
    for info in table:
        print(f"{info.path:<{width}} {info.value:>12.6g} {info.unit:<7} {info.description}")


@app.command("plot")
def plot(
    name: Annotated[str, typer.Argument(help="Name of a shipped road, or a road file.")],
    out: Annotated[Path | None, typer.Option(metavar="FILE", help=".png, .svg or .pdf. Default: ROAD.png.")] = None,
    start: Annotated[float | None, typer.Option("--from", metavar="M", help="Start of the stretch.")] = None,
    end: Annotated[float | None, typer.Option("--to", metavar="M", help="End of the stretch.")] = None,
    time: Annotated[float, typer.Option(metavar="S", help="Time for jumps by time.")] = 0.0,
    speed: Annotated[float, typer.Option(metavar="KM/H", help="Speed for the friction under water.")] = 80.0,
    sets: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Draw the friction map, grade and bank, and on a rough road both tracks and their spectra beside the classes.

    Examples: bench road plot mu_split

    bench road plot iso_8608_c --to 200 --out c.svg --set road.roughness.realisation=7
    """
    from bench.report.road_picture import draw_road, usual_stretch
    from bench.scenario.documents import parse_sets
    from signals.errors import InputError
    from vehicle_model.parameters import set_parameter
    from vehicle_model.road_file import load_road

    read = load_road(name)
    for path, value in parse_sets(sets or ()).items():
        if not path.startswith("road."):
            raise InputError(f"--set {path}", allowed="parameters of the road, as road.friction=0.5")
        set_parameter(read, path, value, "road.")
    usual = usual_stretch(read)
    stretch = (usual[0] if start is None else start, usual[1] if end is None else end)
    drawn = draw_road(read, out or Path(f"{Path(name).stem}.png"), along=stretch, time_s=time, speed_m_s=speed / 3.6)
    if as_json:
        print_json({"road": read.name, "picture": str(drawn), "from_m": stretch[0], "to_m": stretch[1]})
    else:
        print(f"picture: {drawn}")
