"""The injector between two buses at full load: frames lost and latency added, on UDP of this machine.

python -m benchmarks.injector_gateway [--seconds 3]
A sender in this thread puts the shortest frames (47 bits and 3 of intermission) on the bench's side as fast as a bus of
500 kbit/s and of 1 Mbit/s takes them. Goal: none lost. Latency is from the kernel's time stamp of the reception to the
end of the sending.
"""

import argparse
import time

from bench.codec.codec import Codec
from bench.injection.gateway import Gateway
from bench.links.frame import new_frames
from bench.links.registry import open_link
from can_fault_injector.faults.fault_file import FaultsFile

SHORTEST_BITS = 50
CASES = {
    "nothing armed": [],
    "armed on another identifier": [{"trigger": {"id": 0x7FF}, "disturbance": {"drop": {}}}],
    "every hundredth frame delayed": [{"trigger": {"every": 100}, "disturbance": {"delay": {"by": 0.001}}}],
}


def run(bit_rate: int, faults: list[dict[str, object]], seconds: float) -> tuple[int, int, Gateway]:
    """Frames sent and received at full load, and the gateway between."""
    with open_link("udp_loopback", role="ecu") as left, open_link("udp_loopback", role="bench") as right:
        bench, ecu = open_link(left.text, role="bench"), open_link(right.text, role="ecu")
        with bench, ecu:
            file = FaultsFile.model_validate({"faults": faults}) if faults else None
            gateway = Gateway(left, right, file, Codec.load())
            gateway.restart_clock()
            frames, heard = new_frames(64), new_frames(4096)
            frames["identifier"] = 0x300
            sent = received = 0
            rate = bit_rate / SHORTEST_BITS
            began = time.perf_counter()
            while (now := time.perf_counter() - began) < seconds:
                due = min(int(now * rate) - sent, 64)
                if due > 0:
                    bench.send(frames, due)
                    sent += due
                gateway.step()
                received += ecu.receive(heard)
            for _ in range(200):
                gateway.step()
                received += ecu.receive(heard)
                time.sleep(1e-3)
            return sent, received, gateway


def main() -> None:
    """Print a line per bit rate and case."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=3.0)
    seconds = parser.parse_args().seconds
    for bit_rate in (500_000, 1_000_000):
        for name, faults in CASES.items():
            sent, received, gateway = run(bit_rate, faults, seconds)
            latency = gateway.latency()
            load = sent / seconds / (bit_rate / SHORTEST_BITS)
            print(
                f"{bit_rate / 1e3:6.0f} kbit/s, {name:30}: sent {sent} (load {load:4.0%}), lost {sent - received}, "
                f"added latency p50 {latency.p50_us:.0f} us, p99 {latency.p99_us:.0f} us"
            )


if __name__ == "__main__":
    main()
