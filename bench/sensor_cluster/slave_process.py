"""SPI slave on a serial line: an adapter passes the bytes that the master clocks out, and back what is answered.

Each transfer is four bytes in, four bytes out, most significant byte first. The values come from the bench through a
mapped file; the process ends with its parent.
"""

import argparse
import signal
from pathlib import Path

from bench.loop.scheduling import die_with_parent
from bench.sensor_cluster.sensor_block import SERVED, SensorBlock
from bench.sensor_cluster.words import WORD_BYTES

WAIT_S = 0.01
"""For a word, and once more for the rest of one that has begun."""


def serve(block: SensorBlock, device: str, baud_rate: int) -> None:
    """Answer transfers until the process is ended; an unfinished word is dropped within 20 ms of its last byte."""
    import serial

    with serial.Serial(device, baud_rate, timeout=WAIT_S) as port:
        block.transfer(0)  # compiled before the master may wait for it
        port.reset_input_buffer()
        block.memory[SERVED] = 1
        while True:
            word = port.read(WORD_BYTES)
            if 0 < len(word) < WORD_BYTES:  # begun at the end of the wait: a whole wait for the rest
                word += port.read(WORD_BYTES - len(word))
            if len(word) == WORD_BYTES:
                port.write(block.transfer(int.from_bytes(word, "big")).to_bytes(WORD_BYTES, "big"))


def main() -> None:
    """Command line of the helper process."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--registers", type=Path, required=True)
    parser.add_argument("--device", required=True)
    parser.add_argument("--baud-rate", type=int, default=1_000_000)
    arguments = parser.parse_args()
    die_with_parent(signal.SIGKILL)
    serve(SensorBlock(arguments.registers), arguments.device, arguments.baud_rate)


if __name__ == "__main__":
    main()
