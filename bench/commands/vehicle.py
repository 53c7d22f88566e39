"""``bench vehicle``: cars and their parameters."""

from pathlib import Path
from typing import Annotated

import typer

from bench.commands.options import JsonOption, print_json
from signals.errors import InputError

app = typer.Typer(help="Cars and their parameters.", no_args_is_help=True, rich_markup_mode="markdown")


@app.callback()
def vehicle() -> None:
    """Cars and their parameters."""


@app.command("list")
def list_parameters(
    name: Annotated[str | None, typer.Argument(help="Name of a shipped car, or a vehicle file.")] = None,
    text: Annotated[str, typer.Option("--filter", metavar="TEXT", help="Only paths that contain this.")] = "",
    as_json: JsonOption = False,
) -> None:
    """List every parameter of a car with unit, default, range, neutral value and source; without a name, the cars.

    Examples: bench vehicle list

    bench vehicle list ekf_car --filter brakes
    """
    from vehicle_model.vehicle_file import load_vehicle, parameter_table, vehicle_names

    if name is None:
        cars = {car: load_vehicle(car).description for car in vehicle_names()}
        if as_json:
            print_json(cars)
        for car, description in {} if as_json else cars.items():
            print(f"{car:<14} {description}")
        return
    table = [info for info in parameter_table(load_vehicle(name)) if text in info.path]
    if as_json:
        print_json([vars(info) for info in table])
        return
    width = max((len(info.path) for info in table), default=0)
    print(f"{'parameter':<{width}} {'value':>12} {'unit':<8} {'default':>10} {'range':<20} {'neutral':>7}  source")
    for info in table:
        limits = f"{_number(info.low)} … {_number(info.high)}"
        print(
            f"{info.path:<{width}} {info.value:>12.6g} {info.unit:<8} {_number(info.default):>10} {limits:<20} "
            f"{_number(info.neutral):>7}  {info.source or info.description}"
        )


@app.command("show")
def show(
    name: Annotated[str, typer.Argument(help="Name of a shipped car, or a vehicle file.")],
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="PNG file. Default: CAR.png.")] = None,
    steer: Annotated[float, typer.Option(metavar="DEG", help="Angle of the front wheels, left positive.")] = 12.0,
    azimuth: Annotated[float, typer.Option(metavar="DEG", help="Direction of view; 0 looks along the road.")] = 140.0,
    elevation: Annotated[float, typer.Option(metavar="DEG", help="Negative looks down.")] = -16.0,
    width: Annotated[int, typer.Option(min=16, max=1920, help="Of the picture, in pixels.")] = 1280,
    height: Annotated[int, typer.Option(min=16, max=1080, help="Of the picture, in pixels.")] = 720,
    viewer: Annotated[bool, typer.Option("--viewer", help="MuJoCo's window instead, where a screen is.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Draw a car, as large as its file says, into a picture; no screen is needed.

    Examples: bench vehicle show ekf_car --out car.png

    bench vehicle show ekf_car --viewer
    """
    import math

    from bench.report.car_scene import Pose
    from vehicle_model.vehicle_file import load_vehicle

    vehicle = load_vehicle(name)
    if viewer:
        from bench.report.car_viewer import show as open_window

        open_window(vehicle)
        return
    from bench.report.car_render import View, render_car

    path = out or Path(f"{Path(name).stem}.png")
    if path.suffix.lower() != ".png":
        raise InputError(f"{path}: unknown kind of picture", allowed=".png")
    angle = math.radians(steer)
    view = View(width=width, height=height, azimuth_deg=azimuth, elevation_deg=elevation)
    render_car(name, [Pose(steer=(angle, angle))], [path], view)
    if as_json:
        print_json({"vehicle": vehicle.name, "picture": str(path)})
    else:
        print(f"picture: {path}")


@app.command("fit")
def fit(
    logs: Annotated[list[str], typer.Argument(metavar="LOG...", help="Logs of a healthy car, or runs of the bench.")],
    vehicle: Annotated[
        str | None, typer.Option(metavar="NAME|FILE", help="Car to begin with; without it that of a run's scenario.")
    ] = None,
    channels: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Channel map of measured logs; runs of the bench need none.")
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="Default: CAR_fitted.yaml.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Calibrate a car on logs of a healthy one, so that later diagnoses start from that car.

    Every parameter may be off by its scatter; the file that is written extends the given one, with the fitted values
    and the scatter that the logs leave open. docs/diagnosis.md tells more.

    Example: bench vehicle fit runs/healthy_drive --vehicle ekf_car --out my_car.yaml
    """
    from bench.diagnosis.progress import SearchProgress
    from bench.diagnosis.vehicle_fitting import fit as fit_to_logs
    from bench.diagnosis.vehicle_fitting import print_fit
    from bench.report.summary import output_console

    with SearchProgress() as progress:
        result = fit_to_logs(logs, vehicle, channels=channels, out=out, progress=progress)
    if as_json:
        print_json(result.as_json())
    else:
        print_fit(result, output_console())


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.6g}"
