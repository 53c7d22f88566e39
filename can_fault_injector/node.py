"""Compiled protocol node: what it drives and what a sampled bit does to it (ISO 11898-1:2015, Bosch CAN 2.0 part B).

The rule names in the comments (FC01, EF04, …) are those of the tests; FC are the twelve rules of fault confinement.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from can_fault_injector import fields as f
from can_fault_injector import node_state as ns
from can_fault_injector.receiver import Payload, State, begin, read_bit

Table = NDArray[np.uint8]
Rows = NDArray[np.int64]

WARNING_LIMIT = 96
PASSIVE_LIMIT = 128
BUS_OFF_LIMIT = 256
RECEIVE_ERRORS_MAXIMUM = 255
RECEIVE_ERRORS_AFTER_SUCCESS = 119
"""Receive error count after a good reception in the passive state: rule 8 allows 119 to 127."""
RECOVERY_SEQUENCES = 128
INTEGRATION_BITS = 11


@njit(cache=True)
def is_passive(s: State) -> bool:
    """Error passive (FC09), error active otherwise (FC11); bus-off is a phase."""
    return bool(s[ns.TRANSMIT_ERRORS] >= PASSIVE_LIMIT or s[ns.RECEIVE_ERRORS] >= PASSIVE_LIMIT)


@njit(cache=True)
def is_warned(s: State) -> bool:
    """Whether a counter is at the warning level or above (FC16)."""
    return bool(s[ns.TRANSMIT_ERRORS] >= WARNING_LIMIT or s[ns.RECEIVE_ERRORS] >= WARNING_LIMIT)


@njit(cache=True)
def _enter(s: State, phase: int) -> None:
    s[ns.PHASE], s[ns.COUNT] = phase, 0


@njit(cache=True)
def _add(s: State, transmit: int, receive: int) -> bool:
    """Raise the counter of the node's role; True if that made it bus-off (FC10)."""
    if s[ns.TRANSMITTER]:
        s[ns.TRANSMIT_ERRORS] += transmit
        if s[ns.TRANSMIT_ERRORS] >= BUS_OFF_LIMIT:
            _enter(s, ns.BUS_OFF)
            s[ns.IDLE_SEQUENCES] = 0
            return True
    else:
        s[ns.RECEIVE_ERRORS] = min(s[ns.RECEIVE_ERRORS] + receive, RECEIVE_ERRORS_MAXIMUM)
    return False


@njit(cache=True)
def _error(s: State, kind: int, transmit: int, receive: int) -> None:
    """Count an error and begin the flag, an active one even if this error made the node passive (FC09)."""
    flag = ns.PASSIVE_FLAG if is_passive(s) else ns.ACTIVE_FLAG
    s[ns.EVENT], s[ns.ERROR_KIND] = ns.ERROR, kind
    s[ns.ACKNOWLEDGE_EXCEPTION] = 0
    if kind == ns.ACKNOWLEDGE_ERROR and flag == ns.PASSIVE_FLAG:
        s[ns.ACKNOWLEDGE_EXCEPTION] = 1
        transmit = 0
    if s[ns.SINGLE_SHOT] and s[ns.TRANSMITTER] and s[ns.PHASE] == ns.FRAME:
        s[ns.QUEUE_HEAD] += 1
    s[ns.IN_ERROR_FRAME], s[ns.DOMINANT_AFTER_FLAG], s[ns.EQUAL_LEVEL] = 1, 0, 2
    if not _add(s, transmit, receive):
        _enter(s, flag)


@njit(cache=True)
def _overload(s: State) -> None:
    s[ns.EVENT] = ns.OVERLOAD
    s[ns.IN_ERROR_FRAME], s[ns.DOMINANT_AFTER_FLAG] = 0, 0
    _enter(s, ns.OVERLOAD_FLAG)


@njit(cache=True)
def _begin_reception(s: State, data: Payload, bit: int) -> None:
    s[ns.TRANSMITTER] = 0
    begin(s)
    read_bit(s, data, bit)


@njit(cache=True)
def _begin_transmission(s: State, queue: Rows, passive_row: Rows) -> None:
    """Begin the oldest waiting frame; an error passive node sends CAN FD with ESI recessive (FD07)."""
    row = queue[s[ns.QUEUE_HEAD] % queue.size]
    s[ns.ROW] = passive_row[row] if is_passive(s) else row
    s[ns.TRANSMITTER], s[ns.POSITION] = 1, 0
    s[ns.EVENT] = ns.STARTED
    begin(s)


@njit(cache=True)
def drive(s: State, queue: Rows, passive_row: Rows, bits: Table) -> int:
    """Level that the node puts on the bus in the coming bit; an idle node with a waiting frame begins it here."""
    s[ns.EVENT] = ns.NO_EVENT
    phase = s[ns.PHASE]
    if phase == ns.IDLE and s[ns.QUEUE_HEAD] < s[ns.QUEUE_TAIL]:
        _begin_transmission(s, queue, passive_row)
        phase = ns.FRAME
    if phase == ns.FRAME:
        if s[ns.TRANSMITTER]:
            return bits[s[ns.ROW], s[ns.POSITION]]
        if s[ns.FIELD] == f.ACK_SLOT and not s[ns.CRC_WRONG] and not s[ns.SILENT]:
            return 0
        return 1
    # a silent (listen-only) node influences the bus with nothing, flags included
    if (phase == ns.ACTIVE_FLAG or phase == ns.OVERLOAD_FLAG) and not s[ns.SILENT]:
        return 0
    return 1


@njit(cache=True)
def _in_arbitration(code: int, extended: int) -> bool:
    if code == f.IDENTIFIER or code == f.RTR or code == f.RRS:
        return True
    return bool(extended and (code == f.SRR or code == f.IDE or code == f.IDENTIFIER_EXTENSION))


@njit(cache=True)
def _check_own_bit(s: State, bits: Table, codes: Table, extended: Rows, bit: int) -> bool:
    """Compare what a transmitter sent with what it sees; True if that is an error (BE01, AR01, FC03)."""
    row, at = s[ns.ROW], s[ns.POSITION]
    code = codes[row, at]
    # form and acknowledgement of the last fields are read like a receiver's
    if code >= f.CRC_DELIMITER and code <= f.EOF:
        return False
    s[ns.POSITION] += 1
    if bits[row, at] == bit:
        return False
    if bit == 0 and _in_arbitration(code, extended[row]):
        s[ns.TRANSMITTER] = 0
        s[ns.EVENT] = ns.ARBITRATION_LOST
        return False
    if code == f.STUFF and bit == 0 and _in_arbitration(codes[row, at + 1], extended[row]):
        _error(s, f.STUFF_ERROR, 0, 0)  # FC03, exception 2
    else:
        _error(s, ns.BIT_ERROR, 8, 0)
    return True


@njit(cache=True)
def _sample_frame(s: State, data: Payload, bits: Table, codes: Table, extended: Rows, bit: int) -> None:
    acknowledging = s[ns.FIELD] == f.ACK_SLOT and not s[ns.TRANSMITTER] and not s[ns.CRC_WRONG] and not s[ns.SILENT]
    if s[ns.TRANSMITTER] and _check_own_bit(s, bits, codes, extended, bit):
        return
    meaning = read_bit(s, data, bit)
    if meaning == f.NO_ERROR:
        if acknowledging and bit == 1:
            _error(s, ns.BIT_ERROR, 0, 1)  # FC01a
    elif meaning == ns.ACCEPTED:
        s[ns.EVENT] = ns.RECEIVED
        count = s[ns.RECEIVE_ERRORS]  # FC08
        s[ns.RECEIVE_ERRORS] = RECEIVE_ERRORS_AFTER_SUCCESS if count >= PASSIVE_LIMIT else max(count - 1, 0)
    elif meaning == ns.FRAME_END:
        if s[ns.TRANSMITTER]:
            s[ns.EVENT] = ns.TRANSMITTED
            s[ns.TRANSMIT_ERRORS] = max(s[ns.TRANSMIT_ERRORS] - 1, 0)  # FC07
            s[ns.QUEUE_HEAD] += 1
        _enter(s, ns.INTERMISSION)
    elif meaning == ns.OVERLOAD_CONDITION:
        _overload(s)  # EO01: dominant at the last bit of EOF
    elif meaning == ns.PROTOCOL_EXCEPTION:
        s[ns.EVENT] = ns.EXCEPTION  # FD09
        _enter(s, ns.INTEGRATING)
    else:
        _error(s, meaning, 8, 1)  # FC01, FC03


@njit(cache=True)
def _sample_flag(s: State, bit: int) -> None:
    """Active error flag or overload flag: six dominant bits; anything else is a bit error (FC04, FC05)."""
    if bit == 1 and not s[ns.SILENT]:
        _error(s, ns.BIT_ERROR, 8, 8)
        return
    s[ns.COUNT] += 1
    if s[ns.COUNT] == 6:
        _enter(s, ns.AFTER_FLAG)


@njit(cache=True)
def _sample_passive_flag(s: State, bit: int) -> None:
    """Passive error flag: over when six equal bits were seen since its beginning (EF04)."""
    s[ns.COUNT] = s[ns.COUNT] + 1 if bit == s[ns.EQUAL_LEVEL] else 1
    s[ns.EQUAL_LEVEL] = bit
    if bit == 0 and s[ns.ACKNOWLEDGE_EXCEPTION]:
        s[ns.ACKNOWLEDGE_EXCEPTION] = 0  # FC03, exception 1 holds only without a dominant bit here
        if _add(s, 8, 0):
            return
    if s[ns.COUNT] == 6:
        _enter(s, ns.AFTER_FLAG)


@njit(cache=True)
def _sample_after_flag(s: State, bit: int) -> None:
    """Flags of others are waited for; seven dominant bits are free (FC06)."""
    if bit == 1:
        s[ns.PHASE], s[ns.COUNT] = ns.DELIMITER, 1
        return
    s[ns.DOMINANT_AFTER_FLAG] += 1
    first = s[ns.DOMINANT_AFTER_FLAG] == 1 and s[ns.IN_ERROR_FRAME] and not s[ns.TRANSMITTER]
    if first or s[ns.DOMINANT_AFTER_FLAG] % 8 == 0:
        _add(s, 8, 8)  # FC02, FC06a


@njit(cache=True)
def _sample_delimiter(s: State, bit: int) -> None:
    if bit == 1:
        s[ns.COUNT] += 1
        if s[ns.COUNT] == 8:
            _enter(s, ns.INTERMISSION)
    elif s[ns.COUNT] == 7:
        _overload(s)  # OV02
    else:
        _error(s, f.FORM_ERROR, 8, 1)  # FC01b


@njit(cache=True)
def _sample_intermission(s: State, data: Payload, queue: Rows, passive_row: Rows, bit: int) -> None:
    suspends = s[ns.TRANSMITTER] and is_passive(s)
    if bit == 1:
        s[ns.COUNT] += 1
        if s[ns.COUNT] == 3:
            _enter(s, ns.SUSPEND if suspends else ns.IDLE)
    elif s[ns.COUNT] < 2:
        _overload(s)  # OV01
    elif s[ns.QUEUE_HEAD] < s[ns.QUEUE_TAIL] and not suspends:
        # IM01: the dominant third bit is a SOF, so the node's own frame begins with its identifier
        _begin_transmission(s, queue, passive_row)
        s[ns.POSITION] = 1
        read_bit(s, data, 0)
    else:
        _begin_reception(s, data, bit)


@njit(cache=True)
def _sample_bus_off(s: State, bit: int) -> None:
    """Recovery after 128 sequences of 11 recessive bits; a dominant bit restarts only the present one (FC12)."""
    s[ns.COUNT] = s[ns.COUNT] + 1 if bit else 0
    if s[ns.COUNT] == INTEGRATION_BITS:
        s[ns.COUNT] = 0
        s[ns.IDLE_SEQUENCES] += 1
        if s[ns.IDLE_SEQUENCES] >= RECOVERY_SEQUENCES and s[ns.RECOVERS]:
            s[ns.TRANSMIT_ERRORS], s[ns.RECEIVE_ERRORS], s[ns.TRANSMITTER] = 0, 0, 0
            s[ns.EVENT] = ns.RECOVERED
            _enter(s, ns.IDLE)


@njit(cache=True)
def sample(
    s: State, data: Payload, queue: Rows, passive_row: Rows, bits: Table, codes: Table, extended: Rows, bit: int
) -> None:
    """Take the level that the node sees in this bit.

    Parameters
    ----------
    s : int64 array of ``node_state.COLUMNS``
        State of the node.
    data : uint8 array of 64
        Payload being received.
    queue, passive_row, bits, codes, extended
        Rows of the waiting frames in the table of frames; row with ESI recessive; levels, field codes and format.
    """
    phase = s[ns.PHASE]
    if phase == ns.FRAME:
        _sample_frame(s, data, bits, codes, extended, bit)
    elif phase == ns.IDLE:
        if bit == 0:
            _begin_reception(s, data, bit)
    elif phase == ns.INTERMISSION:
        _sample_intermission(s, data, queue, passive_row, bit)
    elif phase == ns.ACTIVE_FLAG or phase == ns.OVERLOAD_FLAG:
        _sample_flag(s, bit)
    elif phase == ns.PASSIVE_FLAG:
        _sample_passive_flag(s, bit)
    elif phase == ns.AFTER_FLAG:
        _sample_after_flag(s, bit)
    elif phase == ns.DELIMITER:
        _sample_delimiter(s, bit)
    elif phase == ns.SUSPEND:
        if bit == 0:
            _begin_reception(s, data, bit)
        else:
            s[ns.COUNT] += 1
            if s[ns.COUNT] == 8:
                _enter(s, ns.IDLE)
    elif phase == ns.INTEGRATING:
        s[ns.COUNT] = s[ns.COUNT] + 1 if bit else 0
        if s[ns.COUNT] == INTEGRATION_BITS:
            _enter(s, ns.IDLE)
    else:
        _sample_bus_off(s, bit)
