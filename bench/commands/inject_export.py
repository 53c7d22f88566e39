"""What ``bench inject`` hands to others: faults to the kernel's gateway or a device, a waveform to a logic analyser."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from bench.commands.options import print_json

if TYPE_CHECKING:
    from can_fault_injector.bit_device import Hit
    from can_fault_injector.frame import Frame

_SLOWEST_BIT_S, _FASTEST_BIT_S = 1e3, 20e6
"""Rates [bit/s]: CAN XL ends at 20 Mbit/s; below 1 kbit/s there is no transceiver."""


def print_rules(faults: Path | None, bench_side: str, ecu_side: str, as_json: bool) -> None:
    """Print the commands that make the kernel's gateway do what a fault file says."""
    from can_fault_injector.can_gw import rules
    from can_fault_injector.faults.fault_file import load_faults

    made = rules(load_faults(faults).faults if faults is not None else (), bench_side, ecu_side)
    if as_json:
        print_json([{"command": rule.command, "arguments": rule.arguments()} for rule in made])
        return
    for rule in made:
        print(rule.command)


def write_wave(
    path: Path, frame: "Frame", flipped: Sequence[int], dbc: Path | None, bit_rate: float | None, data_bit_rate: float
) -> None:
    """Write what a receiver sees of a frame, with what it does about flipped bits, as a value change dump.

    Raises
    ------
    InputError
        If a rate is no rate, or the file cannot be written.
    """
    from bench.codec.database import load_database
    from can_fault_injector.waveform import receive_line, value_change_dump
    from signals.errors import InputError

    rate = bit_rate if bit_rate is not None else load_database(dbc).bit_rate
    for option, value in (("--bit-rate", rate), ("--data-bit-rate", data_bit_rate)):
        if not _SLOWEST_BIT_S <= value <= _FASTEST_BIT_S:
            raise InputError(option, found=f"{value:g}", allowed=f"{_SLOWEST_BIT_S:g} to {_FASTEST_BIT_S:g} bit/s")
    wave = receive_line(frame, flipped, bit_rate=rate, data_bit_rate=data_bit_rate)
    try:
        path.write_text(value_change_dump(wave), encoding="ascii")
    except OSError as error:
        raise InputError(f"{path}: {(error.strerror or str(error)).lower()}") from None


def run_device(
    port: str, faults: Path, dbc: Path | None, bit_rate: float | None, duration_s: float | None, as_json: bool
) -> None:
    """Hand a fault file to a bit-banging injector and tell of its hits until the time is over or Ctrl-C."""
    from bench.codec.codec import Codec
    from bench.injection.contents import BusContents
    from can_fault_injector.bit_device import BitDevice
    from can_fault_injector.bit_device_export import disturbances
    from can_fault_injector.faults.fault_file import load_faults

    codec = Codec.load(dbc)
    made = disturbances(load_faults(faults), BusContents(codec))
    end = None if duration_s is None else time.monotonic() + duration_s
    with BitDevice(port) as device:
        device.load(made, bit_rate or codec.bit_rate)
        device.arm()
        if not as_json:
            print(f"{port}: {len(made)} disturbances armed; Ctrl-C ends them", flush=True)
        try:
            while end is None or time.monotonic() < end:
                before = len(device.hits)
                for hit in device.wait(0.1)[before:]:
                    _tell(hit, as_json)
        except KeyboardInterrupt:
            pass
        counts = device.counts()
        device.disarm()
        if as_json:
            print_json({"port": port, "counts": counts, "hits": [hit._asdict() for hit in device.hits]})
        else:
            print(f"{port}: hits {', '.join(map(str, counts))}")


def _tell(hit: "Hit", as_json: bool) -> None:
    if not as_json:
        print(f"{hit.time_us * 1e-6:10.6f} s  slot {hit.slot}  hit {hit.number}", flush=True)
