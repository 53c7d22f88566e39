"""``bench inject``: faults between two buses, live; ``--explain`` shows the bits of a frame."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bench.commands.options import JsonOption, print_json

if TYPE_CHECKING:
    from rich.text import Text

    from can_fault_injector.explain import Bit, Explanation, Reading
    from can_fault_injector.faults.running import FaultEvent

_FIELD_WIDTH = 12


def inject(
    faults: Annotated[Path | None, typer.Argument(metavar="[FILE]", help="Fault file; without it all passes.")] = None,
    bench_side: Annotated[
        str | None, typer.Option("--from", metavar="LINK", help="The bench's side: vcan0, udp:GROUP:PORT, …")
    ] = None,
    ecu_side: Annotated[str | None, typer.Option("--to", metavar="LINK", help="The ECU's side: vcan1, …")] = None,
    duration: Annotated[float | None, typer.Option(metavar="S", help="End after this time; else on Ctrl-C.")] = None,
    bit_rate: Annotated[
        float | None, typer.Option(metavar="BIT/S", help="Of the modelled bus; default: the database's.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of everything random.")] = 1,
    replay: Annotated[
        Path | None, typer.Option(metavar="LOG", help="Send a recorded log on --to, at its times (BLF, ASC, candump).")
    ] = None,
    send: Annotated[
        str | None, typer.Option(metavar="FRAME", help="Send a frame on --to in a cycle: 123#DEADBEEF.")
    ] = None,
    every: Annotated[float, typer.Option(metavar="S", help="Cycle of --send.")] = 0.01,
    count: Annotated[int, typer.Option(min=1, help="Frames of --send.")] = 100,
    can_gw: Annotated[
        bool, typer.Option("--can-gw", help="Print rules of the kernel's gateway that do the same, and end.")
    ] = False,
    device: Annotated[
        str | None, typer.Option(metavar="PORT", help="Hand the faults to a bit-banging injector on a serial port.")
    ] = None,
    explain: Annotated[
        str | None,
        typer.Option(
            metavar="FRAME", help="Print the bits of a frame: 123#DEADBEEF, 12345678#R4, 123##1AABB (CAN FD with BRS)."
        ),
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="PLACE", help="Mark a bit: crc.14, stuff.0, data.signal(NAME).bit 5; repeat."),
    ] = None,
    flip: Annotated[
        list[str] | None,
        typer.Option(metavar="PLACE", help="Say what a receiver makes of the frame with this bit inverted; repeat."),
    ] = None,
    vcd: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write what a receiver sees of --explain and --flip for logic analysers."),
    ] = None,
    data_bit_rate: Annotated[float, typer.Option(metavar="BIT/S", help="Of the data phase of CAN FD in --vcd.")] = 2e6,
    dbc: Annotated[
        Path | None, typer.Option(metavar="FILE", help="CAN database for names of signals; default: the shipped one.")
    ] = None,
    non_iso: Annotated[bool, typer.Option("--non-iso", help="CAN FD of the older kind, without stuff count.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Stand between bench and ECU and disturb their bus, or show what stands where on the wire.

    Examples: bench inject --from vcan0 --to vcan1 faults.yaml

    bench inject --from can0 --to can1 faults.yaml --can-gw

    bench inject --device /dev/ttyACM0 faults.yaml --duration 10

    bench inject --to vcan0 --send 123#DEADBEEF --every 0.01 --count 500

    bench inject --explain 123#DEADBEEF

    bench inject --explain 120#0011223344556677 --at "data.signal(wheel_speed_fl).bit 5"

    bench inject --explain 207#0D --flip bit.25 --flip bit.43

    bench inject --explain 207#0D --flip crc.14 --vcd wave.vcd
    """
    from bench.commands.inject_export import print_rules, run_device, write_wave
    from signals.errors import InputError

    if device is not None and faults is not None:
        run_device(device, faults, dbc, bit_rate, duration, as_json)
        return
    if bench_side is not None and ecu_side is not None and can_gw:
        print_rules(faults, bench_side, ecu_side, as_json)
        return
    if bench_side is not None and ecu_side is not None:
        _forward(bench_side, ecu_side, faults, dbc, bit_rate, seed, duration, as_json)
        return
    if ecu_side is not None and (replay is not None or send is not None):
        _send(ecu_side, replay, send, every, count, as_json)
        return
    if explain is None:
        mend = "bench inject --from vcan0 --to vcan1 faults.yaml, or bench inject --explain 123#DEADBEEF"
        raise InputError("bench inject: nothing to do", mend=mend)
    explanation, reading = _explain(explain, tuple(at or ()), tuple(flip or ()), dbc, not non_iso)
    if vcd is not None:
        write_wave(vcd, explanation.frame, reading.flipped if reading else (), dbc, bit_rate, data_bit_rate)
    if as_json:
        print_json(explanation.as_data() | ({"reading": reading.as_data()} if reading else {}))
        return
    _print(explanation)
    if reading:
        print(f"with {', '.join(flip or ())} flipped {reading.summary(explanation.frame)}")
    if vcd is not None:
        print(f"waveform: {vcd}")


def _forward(
    bench_side: str,
    ecu_side: str,
    faults: Path | None,
    dbc: Path | None,
    bit_rate: float | None,
    seed: int,
    duration_s: float | None,
    as_json: bool,
) -> None:
    from bench.injection.live import forward

    def ready() -> None:
        print(f"forwarding {bench_side} <-> {ecu_side}; Ctrl-C ends it", file=sys.stderr, flush=True)

    def tell(event: "FaultEvent") -> None:
        if not as_json:
            print(f"{event.time_ns * 1e-9:10.4f} s  {event.fault:20} {event.what:7} {event.detail}", flush=True)

    summary = forward(
        bench_side,
        ecu_side,
        faults,
        dbc=dbc,
        bit_rate=bit_rate,
        seed=seed,
        duration_s=duration_s,
        ready=ready,
        tell=tell,
    )
    if as_json:
        print_json(summary)
    else:
        _print_summary(summary)


def _send(to: str, log: Path | None, frame: str | None, every_s: float, count: int, as_json: bool) -> None:
    from bench.injection.live import send

    report = send(to, log=log, frame=frame, every_s=every_s, count=count)
    if as_json:
        print_json(report)
        return
    jitter = report["jitter_us"]
    print(
        f"{report['frames']} frames in {report['took_s']:.4f} s, planned {report['planned_s']:.4f} s "
        f"({report['duration_error'] * 100:+.4f} %)\n"
        f"jitter: p50 {jitter['p50']:.0f} us, p99 {jitter['p99']:.0f} us, largest {jitter['max']:.0f} us"
    )


def _print_summary(summary: dict[str, Any]) -> None:
    latency = summary["added_latency_us"]
    for way, towards in (("to_ecu", "to the ECU"), ("to_bench", "to the bench")):
        print(f"{towards:12} received {summary['received'][way]}, sent {summary['sent'][way]}")
    print(
        f"added latency of {latency['frames']} frames: p50 {latency['p50']:.0f} us, p99 {latency['p99']:.0f} us, "
        f"largest {latency['max']:.0f} us"
    )
    for side, counts in summary["links"].items():
        print(f"{side:12} refused {counts['send_refused']}, overflowed {counts['overflows']}")
    for fault in summary["faults"]:
        print(
            f"fault {fault['name']}: {fault['frames']} frames in {fault['runs']} runs; {fault['kind']}, "
            f"{fault['realised_as']}, E2E class {fault['e2e']}"
        )
    for name, count in summary["counts"].items():
        print(f"{name:20} {count}")


def _explain(
    text: str, places: tuple[str, ...], flips: tuple[str, ...], dbc: Path | None, iso: bool
) -> "tuple[Explanation, Reading | None]":
    from bench.codec.database import load_database
    from bench.codec.signal_bits import message_of, signal_bits
    from can_fault_injector.explain import explain, reading
    from can_fault_injector.notation import parse_frame

    frame = parse_frame(text, iso)
    message = message_of(load_database(dbc), frame.identifier, frame.extended)
    signals = signal_bits(message) if message is not None else None
    return explain(frame, signals, (*places, *flips)), reading(frame, flips, signals) if flips else None


def _print(explanation: "Explanation") -> None:
    """Rows of fields: positions, name, bits, meaning; stuff bits red and in brackets, marked bits inverse."""
    from rich.console import Console
    from rich.text import Text

    from can_fault_injector.notation import frame_text

    console = Console(highlight=False, soft_wrap=True)
    console.print(Text(frame_text(explanation.frame), style="bold"))
    console.print(explanation.summary())
    for row in explanation.rows:
        first, last = row.bits[0].position, row.bits[-1].position
        span = str(first) if first == last else f"{first}-{last}"
        line = Text(f"{span:>9}  ")
        line.append(f"{row.field:{_FIELD_WIDTH}}", style="cyan")
        for bit in row.bits:
            line.append_text(_bit_text(bit, bit.position in explanation.marked))
        line.append(f"  {row.meaning}", style="dim")
        console.print(line)
    for position in explanation.marked:
        bit = explanation.bits[position]
        signal = f" = {bit.signal}" if bit.signal else ""
        console.print(f"marked: bit {position}, {bit.name}{signal}, level {bit.level}")
    marks = "; <x> marked" if explanation.marked else ""
    console.print(Text(f"1 recessive, 0 dominant; [x] stuff bit{marks}", style="dim"))


def _bit_text(bit: "Bit", marked: bool) -> "Text":
    from rich.text import Text

    colour = "red" if bit.stuff else ("green" if bit.level else "yellow")
    text = f"[{bit.level}]" if bit.stuff else str(bit.level)
    style: Any = f"{colour} reverse" if marked else colour
    return Text(f"<{text}>" if marked else text, style=style)
