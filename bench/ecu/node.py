"""The emulated ECU on a bus: frames in, frames out, the same in the bench's process and in its own."""

from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.codec.codec import AGE_NAMES, Codec
from bench.codec.mapping_file import Protection
from bench.codec.tables import CRC_ERRORS, LAST_TICK, PERIOD, REPEATED, WRONG_LENGTH, WRONG_SEQUENCE
from bench.ecu.calibration import CalibrationFile
from bench.ecu.controller import Controller, controller_task
from bench.ecu.records import (
    AGE_TICKS,
    BUS_SIGNALS,
    PERIOD_TICKS,
    PRESENT,
    REJECTED,
    SOURCES,
    TASK_OFFSET_TICKS,
    TASK_TICKS,
)
from signals.wheels import WHEELS

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
def node_task(
    calibration: Any,
    state: Any,
    values: Any,
    messages: Any,
    rows: Any,
    health: Any,
    tick: int,
    command: Any,
    with_edges: bool,
) -> None:
    """The 5 ms task of the node: look at the messages, then control."""
    _look_at_messages(messages, rows, tick, health)
    controller_task(calibration, state, values, health, command, with_edges)


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
        self.silent = silent
        self._values = np.zeros(BUS_SIGNALS)
        self._command = np.zeros(BUS_SIGNALS)
        self._receiver = codec.receiver("ecu", self._values, np.zeros(len(AGE_NAMES)), protection=protection)
        self._transmitter = codec.transmitter("ecu", self._command)
        self._rows = np.array([self._row(signals) for signals in _SIGNAL_OF_SOURCE], np.int64)
        self._health = np.zeros((len(SOURCES), 4), np.int64)
        self._health[:, PRESENT] = self._rows >= 0
        record, state = self.controller.records
        self._task_arguments = (record, state, self._values, self._receiver.messages, self._rows, self._health)
        self._with_edges = with_edges
        self._next_task = TASK_OFFSET_TICKS

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
        self._receiver.accept(frames_in, n_in, tick)
        if tick >= self._next_task:
            self._next_task = tick + TASK_TICKS - (tick - TASK_OFFSET_TICKS) % TASK_TICKS
            node_task(*self._task_arguments, tick, self._command, self._with_edges)
        if self.silent:
            return 0
        return self._transmitter.due(tick, frames_out, start)
