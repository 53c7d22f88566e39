"""Columns of a protocol node's state and the codes of its phases, events and places, shared by the compiled parts."""

from can_fault_injector import fields as f

(
    PHASE,
    COUNT,
    TRANSMITTER,
    TRANSMIT_ERRORS,
    RECEIVE_ERRORS,
    FD_MODE,
    ISO,
    SILENT,
    RECOVERS,
    SINGLE_SHOT,
    POSITION,
    ROW,
    QUEUE_HEAD,
    QUEUE_TAIL,
    FRAME_BITS,
    FIELD,
    INDEX,
    RUN,
    LAST,
    STUFF_BITS,
    FIXED_STUFF_DUE,
    CRC_15,
    CRC_17,
    CRC_21,
    SEQUENCE,
    CRC_WRONG,
    ACKNOWLEDGED,
    IDENTIFIER,
    EXTENDED,
    REMOTE,
    FD,
    BIT_RATE_SWITCH,
    ERROR_STATE,
    LENGTH_CODE,
    LENGTH,
    EQUAL_LEVEL,
    DOMINANT_AFTER_FLAG,
    IN_ERROR_FRAME,
    ACKNOWLEDGE_EXCEPTION,
    IDLE_SEQUENCES,
    EVENT,
    ERROR_KIND,
    SAMPLE_POINT,
) = range(43)
COLUMNS = 43
"""One row of int64 for each node. ``TRANSMITTER`` stays set after a frame, until another one begins: suspend
transmission and the counters of error and overload frames need to know whose frame it was."""

(
    INTEGRATING,
    IDLE,
    FRAME,
    ACTIVE_FLAG,
    PASSIVE_FLAG,
    OVERLOAD_FLAG,
    AFTER_FLAG,
    DELIMITER,
    INTERMISSION,
    SUSPEND,
    BUS_OFF,
) = range(11)
PHASE_NAMES = (
    "integrating",
    "idle",
    "frame",
    "active_flag",
    "passive_flag",
    "overload_flag",
    "after_flag",
    "delimiter",
    "intermission",
    "suspend",
    "bus_off",
)

FD_ENABLED, FD_TOLERANT, CLASSIC = range(3)
"""A node sends and receives CAN FD, waits without an error flag until such a frame is over, or reads FDF as r0."""
FD_MODES = ("enabled", "tolerant", "classic")

# what a bit means to its receiver; the first codes are those of fields.py
BIT_ERROR = f.TRUNCATED + 1
ACKNOWLEDGE_ERROR = f.TRUNCATED + 2
PROTOCOL_EXCEPTION = f.TRUNCATED + 3
ACCEPTED = f.TRUNCATED + 4
FRAME_END = f.TRUNCATED + 5
OVERLOAD_CONDITION = f.TRUNCATED + 6
ERROR_KINDS = (*f.ERROR_NAMES, "bit", "ack")

(
    NO_EVENT,
    STARTED,
    ARBITRATION_LOST,
    ERROR,
    OVERLOAD,
    RECEIVED,
    TRANSMITTED,
    EXCEPTION,
    WENT_PASSIVE,
    WENT_ACTIVE,
    WENT_BUS_OFF,
    RECOVERED,
    WENT_WARNING,
    WARNING_OVER,
) = range(14)
EVENT_NAMES = (
    "none",
    "started",
    "arbitration_lost",
    "error",
    "overload",
    "received",
    "transmitted",
    "protocol_exception",
    "error_passive",
    "error_active",
    "bus_off",
    "recovered",
    "warning",
    "warning_over",
)

# places outside a frame that a disturbance may name; inside a frame they are the codes of fields.py
ERROR_DELIMITER = 60
OVERLOAD_DELIMITER = 61
FRAME_POSITION = 62
PHASE_PLACE = 40
PLACES = {name: code for code, name in enumerate(f.FIELD_NAMES)} | {
    "active_flag": PHASE_PLACE + ACTIVE_FLAG,
    "passive_flag": PHASE_PLACE + PASSIVE_FLAG,
    "overload_flag": PHASE_PLACE + OVERLOAD_FLAG,
    "error_delimiter": ERROR_DELIMITER,
    "overload_delimiter": OVERLOAD_DELIMITER,
    "intermission": PHASE_PLACE + INTERMISSION,
    "suspend": PHASE_PLACE + SUSPEND,
    "idle": PHASE_PLACE + IDLE,
    "bit": FRAME_POSITION,
}
"""Names by which a disturbance addresses a bit, ``eof.6`` or ``error_delimiter.1``; ``bit.n`` counts from SOF."""
PLACE_NAMES = {code: name for name, code in PLACES.items()} | {
    PHASE_PLACE + INTEGRATING: "integrating",
    PHASE_PLACE + BUS_OFF: "bus_off",
}
