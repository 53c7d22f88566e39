"""``bench vehicle``: cars and their parameters."""

from typing import Annotated

import typer

from bench.commands.options import JsonOption, print_json

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


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.6g}"
