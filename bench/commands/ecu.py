"""``bench ecu``: the emulated ABS ECU alone, on any link."""

from enum import StrEnum
from typing import Annotated, Any

import typer

from bench.commands.options import JsonOption, finish, print_json


class EcuProtection(StrEnum):
    """What the ECU checks of protected frames."""

    full = "full"
    crc = "crc"
    none = "none"


def ecu(
    link: Annotated[
        str | None,
        typer.Option(metavar="LINK", help="udp:GROUP:PORT, socketcan:vcan0, slcan:/dev/ttyUSB0@500000, IFACE:CHANNEL."),
    ] = None,
    calibration: Annotated[str, typer.Option(help="sensitive, coarse, or a calibration file.")] = "sensitive",
    dbc: Annotated[str | None, typer.Option(metavar="FILE", help="CAN database in place of the shipped one.")] = None,
    mapping: Annotated[str | None, typer.Option(metavar="FILE", help="Mapping file of a database of its own.")] = None,
    barrier: Annotated[
        str | None, typer.Option(metavar="PATH", help="Socket of a bench in lock-step; without it real time.")
    ] = None,
    core: Annotated[int | None, typer.Option(help="Processor core to stay on.")] = None,
    protection: Annotated[
        EcuProtection, typer.Option(help="What is checked of protected frames.")
    ] = EcuProtection.full,
    silent: Annotated[bool, typer.Option("--silent", help="Listen but answer nothing.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Be the ABS ECU on a link until the bench ends the run, or Ctrl-C. With --json its counts are printed then.

    Example, in two terminals: bench ecu --link socketcan:vcan0

    bench run stops/dry --ecu external --link socketcan:vcan0
    """
    from bench.ecu.process import serve

    told: list[dict[str, Any]] = []
    code = serve(
        link,
        calibration,
        dbc=dbc,
        mapping=mapping,
        barrier=barrier,
        core=core,
        silent=silent,
        protection=protection.value,
        at_end=told.append,
    )
    if as_json:
        print_json(told[0])
        raise SystemExit(code)  # its own end, also by Ctrl-C: nothing more is to be said
    finish(code)
