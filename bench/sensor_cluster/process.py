"""``bench cluster``: the twin of the cluster's microcontroller as a process of its own.

SPI master over a serial line on one side, the frames of the inertial signals on a CAN link on the other.
"""

import time
from collections.abc import Callable

import numpy as np

from bench.codec.codec import Codec
from bench.links.frame import new_frames
from bench.links.interface import Link
from bench.sensor_cluster.microcontroller import REQUESTS, Microcontroller, Plausibility
from bench.sensor_cluster.sensor_block import CHANNELS, FIRST_ADDRESS, SILENT_LINE
from bench.sensor_cluster.words import WORD_BYTES, IntArray, address_of, is_intact
from signals.catalogue import block_slice, index_of
from signals.errors import LinkError

TICK_S = 1e-3
MOST_FRAMES = 64
PAUSE_S = 0.03
"""Without a question: longer than the 20 ms after which the slave drops an unfinished word."""
REPLY_S = 0.03
"""For an answer: adapters on USB hold bytes back for up to 16 ms, and a late answer is better than none."""


def out_of_step(answers: IntArray) -> bool:
    """True where the line speaks and at most one of the answers (7,) stands in its place.

    A chip select would frame the words; over a serial line a byte too many, or an answer that came after it was given
    up, shifts all that follow; one may look right, for the first channel is asked for twice.
    """
    channels = answers[1:]
    placed = [is_intact(word) and address_of(word) == FIRST_ADDRESS + k for k, word in enumerate(channels)]
    return sum(placed) <= 1 and bool(np.any(channels != SILENT_LINE))


def run_microcontroller(link: Link, device: str, baud_rate: int, ended: Callable[[], int]) -> dict[str, int]:
    """Read the sensor block each millisecond and send what is plausible until ``ended``; counts of the checks.

    Raises
    ------
    LinkError
        If the serial line cannot be opened.
    """
    import serial

    bus = block_slice("bus")
    values = np.zeros(bus.stop - bus.start)
    positions = np.array([index_of(name) - bus.start for name in CHANNELS])
    transmitter = Codec.load().transmitter("bench", values)
    own = transmitter.rows_of(CHANNELS)
    others = transmitter.rows_of_all_but(own)
    twin = Microcontroller(Plausibility())
    question = b"".join(int(word).to_bytes(WORD_BYTES, "big") for word in REQUESTS)
    answers = np.zeros(len(REQUESTS), np.int64)
    frames, heard = new_frames(MOST_FRAMES), new_frames(4096)
    try:
        port = serial.Serial(device, baud_rate, timeout=REPLY_S)
    except (OSError, ValueError) as error:
        raise LinkError(
            f"{device}: {error}", mend="name the serial line of the SPI adapter: --spi /dev/ttyUSB0"
        ) from error
    with port:
        start, tick = time.perf_counter(), 0
        while not ended():
            ahead = start + tick * TICK_S - time.perf_counter()
            if ahead > 0:
                time.sleep(ahead)
            port.write(question)
            reply = port.read(len(question))
            if len(reply) == len(question):
                answers[:] = [
                    int.from_bytes(reply[k : k + WORD_BYTES], "big") for k in range(0, len(reply), WORD_BYTES)
                ]
            if len(reply) < len(question) or out_of_step(answers):
                time.sleep(PAUSE_S)
                port.reset_input_buffer()
                answers[:] = SILENT_LINE
            valid = twin.take(answers)
            values[positions] = twin.values
            transmitter.postpone(others, tick)
            if not valid:
                transmitter.postpone(own, tick)
            count = transmitter.due(tick, frames)
            if count:
                link.send(frames, count)
            link.receive(heard)
            tick = max(tick + 1, int((time.perf_counter() - start) / TICK_S))
    return twin.counts()
