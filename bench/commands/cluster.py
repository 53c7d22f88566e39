"""``bench cluster``: the twin of the sensor cluster's microcontroller, alone on a serial line and a CAN link."""

from typing import Annotated

import typer

from bench.commands.options import JsonOption, print_json


def cluster(
    spi: Annotated[str, typer.Option(metavar="DEVICE", help="Serial line of the SPI adapter, e.g. /dev/ttyUSB0.")],
    link: Annotated[
        str, typer.Option(metavar="LINK", help="udp:GROUP:PORT, socketcan:vcan0, slcan:/dev/ttyUSB1@500000.")
    ],
    baud_rate: Annotated[int, typer.Option(help="Bit rate of the serial line.")] = 1_000_000,
    as_json: JsonOption = False,
) -> None:
    """Read an inertial sensor block over SPI, filter, check, and send its frames on a CAN link until Ctrl-C.

    Stands in for a real cluster's microcontroller where a scenario says `sensor_cluster: {kind: external}`.

    Example: bench cluster --spi /dev/ttyUSB0 --link socketcan:vcan0
    """
    from bench.links.registry import open_link
    from bench.loop.ending import until_ended
    from bench.sensor_cluster.process import run_microcontroller

    with open_link(link, role="bench") as opened, until_ended() as ended:
        counts = run_microcontroller(opened, spi, baud_rate, ended)
    if as_json:
        print_json(counts)
    else:
        print(", ".join(f"{name.replace('_', ' ')} {count}" for name, count in counts.items()))
