"""The emulated ECU on a bus: frames in, frames out, the same in the bench's process and in its own."""

from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.codec.codec import AGE_NAMES, Codec
from bench.codec.kernels import receive, transmit
from bench.codec.mapping_file import Protection
from bench.codec.tables import (
    CRC_ERRORS,
    LAST_TICK,
    MESSAGE_COLUMNS,
    PERIOD,
    REPEATED,
    WRONG_LENGTH,
    WRONG_SEQUENCE,
)
from bench.ecu.calibration import CalibrationFile
from bench.ecu.controller import Controller, controller_task
from bench.ecu.records import (
    AGE_TICKS,
    BUS_SIGNALS,
    CALIBRATION_RECORD,
    PERIOD_TICKS,
    PRESENT,
    REJECTED,
    SOURCES,
    STATE_RECORD,
    TASK_OFFSET_TICKS,
    TASK_TICKS,
)
from bench.links.frame import FRAME_DTYPE, frames_address
from signals.record_memory import addresses_at, addresses_of, pointer
from signals.wheels import WHEELS

AT_RECEIVER, AT_TRANSMITTER, AT_CALIBRATION, AT_STATE, AT_VALUES, AT_ROWS, AT_HEALTH, AT_COMMAND = range(8)
"""Places in the node's list of addresses."""
MESSAGES, WITH_EDGES, SILENT, NEXT_TASK = range(8, 12)
"""Plain numbers in the same list: rows of the receiver's table, two flags, the tick of the next task."""
AT_MESSAGES = 12
PLACES = 13

_SIGNAL_OF_SOURCE = (
    ("wheel_speed_fl",),
    ("wheel_speed_rl",),
    *((f"wheel_edge_count_{wheel}",) for wheel in WHEELS),
    ("master_pressure", "brake_switch", "pedal_force"),
    ("ignition",),
    ("longitudinal_acceleration",),
)
"""Signals by which the message of a source is found in the database, the first that is there."""


@njit(cache=True)
def _look_at_messages(messages: Any, rows: Any, tick: int, health: Any) -> None:
    """Age and refused frames of each source, from the receiver's table of messages."""
    for source in range(rows.shape[0]):
        row = rows[source]
        if row >= 0:
            message = messages[row]
            health[source, AGE_TICKS] = tick - message[LAST_TICK]
            refused = message[CRC_ERRORS] + message[REPEATED] + message[WRONG_SEQUENCE] + message[WRONG_LENGTH]
            health[source, REJECTED] = refused
            health[source, PERIOD_TICKS] = message[PERIOD]


@njit(cache=True)
def _task(places: Any, tick: int) -> None:
    """The 5 ms task of the node: look at the messages, then control."""
    messages = numba.carray(pointer(places[AT_MESSAGES]), (places[MESSAGES], MESSAGE_COLUMNS), numba.int64)
    rows = numba.carray(pointer(places[AT_ROWS]), len(SOURCES), numba.int64)
    health = numba.carray(pointer(places[AT_HEALTH]), (len(SOURCES), 4), numba.int64)
    _look_at_messages(messages, rows, tick, health)
    controller_task(
        numba.carray(pointer(places[AT_CALIBRATION]), 1, CALIBRATION_RECORD),
        numba.carray(pointer(places[AT_STATE]), 1, STATE_RECORD),
        numba.carray(pointer(places[AT_VALUES]), BUS_SIGNALS, numba.float64),
        health,
        numba.carray(pointer(places[AT_COMMAND]), BUS_SIGNALS, numba.float64),
        places[WITH_EDGES] != 0,
    )


@njit(cache=True)
def node_tick(memory: int, frames_in_at: int, n_in: int, frames_out_at: int, start: int, tick: int) -> int:
    """`EcuNode.tick`, everything by address; ``memory`` is that of the list ``AT_...``."""
    places: Any = addresses_at(memory)
    receive(places[AT_RECEIVER], frames_in_at, n_in, tick)
    if tick >= places[NEXT_TASK]:
        places[NEXT_TASK] = tick + TASK_TICKS - (tick - TASK_OFFSET_TICKS) % TASK_TICKS
        _task(places, tick)
    if places[SILENT] != 0:
        return 0
    return int(transmit(places[AT_TRANSMITTER], frames_out_at, start, tick))


class EcuNode:
    """An ABS ECU that sees frames only.

    Parameters
    ----------
    calibration
        Name of a shipped calibration, or the path of a file.
    codec
        The bus; without pulse counters on it the wheel-speed frames are used.
    silent
        Receives and controls, but sends nothing.
    protection
        "full": frames are refused for their CRC or alive counter, and missing ones are a fault; "crc": for their CRC
        only; "none": every frame of a known identifier and right length is believed.

    Raises
    ------
    InputError
        If the calibration has faults.

    Attributes
    ----------
    address : int
        Of the memory that `node_tick` works on, for compiled callers.
    """

    def __init__(
        self,
        calibration: str | Path | CalibrationFile,
        codec: Codec,
        *,
        silent: bool = False,
        protection: Protection = "full",
    ) -> None:
        heard = set(codec.layout.names("bench"))
        with_edges = all(f"wheel_edge_{what}_{wheel}" in heard for what in ("count", "time") for wheel in WHEELS)
        self.controller = Controller(calibration, with_edges=with_edges, watch_timeouts=protection == "full")
        self._values = np.zeros(BUS_SIGNALS)
        self._command = np.zeros(BUS_SIGNALS)
        self._receiver = codec.receiver("ecu", self._values, np.zeros(len(AGE_NAMES)), protection=protection)
        self._transmitter = codec.transmitter("ecu", self._command)
        self._rows = np.array([self._row(signals) for signals in _SIGNAL_OF_SOURCE], np.int64)
        self._health = np.zeros((len(SOURCES), 4), np.int64)
        self._health[:, PRESENT] = self._rows >= 0
        record, state = self.controller.records
        self._places = np.zeros(PLACES, np.int64)
        self._places[[AT_RECEIVER, AT_TRANSMITTER]] = self._receiver.address, self._transmitter.address
        self._places[AT_CALIBRATION : AT_COMMAND + 1] = addresses_of(
            record, state, self._values, self._rows, self._health, self._command
        )
        self._places[AT_MESSAGES] = self._receiver.messages.ctypes.data
        self._places[[MESSAGES, WITH_EDGES, SILENT]] = len(self._receiver.messages), with_edges, silent
        self._places[NEXT_TASK] = TASK_OFFSET_TICKS
        self.address = int(self._places.ctypes.data)
        self._in = self._out = np.zeros(0, FRAME_DTYPE)
        self._in_at = self._out_at = 0

    def _row(self, signals: tuple[str, ...]) -> int:
        return next((row for row in map(self._receiver.row_of, signals) if row >= 0), -1)

    def statistics(self) -> dict[str, Any]:
        """What the ECU has seen: stored fault codes, and counts of each message by name as the receiver keeps them."""
        return {"fault_codes": self.controller.stored_faults(), "frames": self._receiver.statistics()}

    def tick(
        self, tick: int, frames_in: NDArray[np.void], n_in: int, frames_out: NDArray[np.void], start: int = 0
    ) -> int:
        """One millisecond: take in frames, run the task if it is due, fill in the frames that are due.

        Parameters
        ----------
        tick
            Milliseconds since the start; must not go back. Skipped ticks are made up for once.
        frames_in, n_in
            What was received since the last call.
        frames_out
            Filled from ``start`` on.

        Returns
        -------
        int
            Number of frames to send.
        """
        if frames_in is not self._in or frames_out is not self._out:
            # the same come tick by tick, so their addresses are kept
            self._in, self._out = frames_in, frames_out
            self._in_at, self._out_at = frames_address(frames_in), frames_address(frames_out)
        count: int = node_tick(self.address, self._in_at, n_in, self._out_at, start, tick)
        return count
