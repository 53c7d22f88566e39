"""Fields of a CAN frame, in the order of transmission, and the codes by which compiled code names them."""

(
    SOF,
    IDENTIFIER,
    RTR,
    SRR,
    IDE,
    IDENTIFIER_EXTENSION,
    R1,
    R0,
    RRS,
    FDF,
    RES,
    BRS,
    ESI,
    DLC,
    DATA,
    STUFF_COUNT,
    CRC,
    CRC_DELIMITER,
    ACK_SLOT,
    ACK_DELIMITER,
    EOF,
    STUFF,
    FIXED_STUFF,
) = range(23)

FIELD_NAMES = (
    "sof",
    "id",
    "rtr",
    "srr",
    "ide",
    "id_ext",
    "r1",
    "r0",
    "rrs",
    "fdf",
    "res",
    "brs",
    "esi",
    "dlc",
    "data",
    "stuff_count",
    "crc",
    "crc_del",
    "ack_slot",
    "ack_del",
    "eof",
    "stuff",
    "fixed_stuff",
)
"""Name of each code; bit n of a field is written ``crc.14``, counted from 0 in the order of transmission."""

NO_ERROR, STUFF_ERROR, CRC_ERROR, FORM_ERROR, TRUNCATED = range(5)
ERROR_NAMES = ("none", "stuff", "crc", "form", "truncated")

MAX_BITS = 1024
"""More than the longest frame on the wire has: 64 data bytes of CAN FD, every stuff bit included, are below 800."""

FD_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)
"""Payload bytes of CAN FD by data length code (ISO 11898-1)."""
