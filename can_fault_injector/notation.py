"""Frames as text, in the notation of can-utils: ``123#DEADBEEF``, ``1F334455##1A0B0``, ``7E0#R8``."""

import re

from can_fault_injector.frame import Frame
from signals.errors import InputError

_PATTERN = re.compile(
    r"(?P<identifier>[0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})#"
    r"(?:#(?P<flags>[0-9A-Fa-f])(?P<fd_data>[0-9A-Fa-f.]*)"
    r"|[Rr](?P<remote>[0-8]?)(?:_(?P<remote_dlc>[9A-Fa-f]))?"
    r"|(?P<data>[0-9A-Fa-f.]*)(?:_(?P<dlc>[9A-Fa-f]))?)"
)
_BIT_RATE_SWITCH, _ERROR_STATE = 1, 2
_ALLOWED = "ID#DATA, ID#DATA_DLC (DLC 9 to F), ID#R or ID#R4, ID##FLAGS DATA in hexadecimal; ID of 3 or 8 digits"
_MEND = "for example 123#DEADBEEF, 12345678#R8, 123##1.AABBCC (CAN FD, flags: 1 = BRS, 2 = ESI)"


def parse_frame(text: str, iso: bool = True) -> Frame:
    """Frame that a text in the notation of can-utils names.

    Three digits of identifier make a standard frame, eight an extended one. ``iso`` is for CAN FD, as in `Frame`.

    Raises
    ------
    InputError
        With what was found and what is allowed.
    """
    match = _PATTERN.fullmatch(text.replace(" ", ""))
    if match is None:
        raise InputError("frame", found=repr(text), allowed=_ALLOWED, mend=_MEND)
    fd, remote = match["flags"] is not None, match["remote"] is not None
    digits = (match["fd_data"] if fd else match["data"] or "").replace(".", "")
    if len(digits) % 2:
        raise InputError("frame: data", found=f"{len(digits)} hexadecimal digits", allowed="two for each byte")
    flags = int(match["flags"] or "0", 16)
    code = match["dlc"] or match["remote_dlc"]
    remote_length = int(match["remote"] or "0") if remote else None
    try:
        return Frame(
            int(match["identifier"], 16),
            bytes.fromhex(digits),
            extended=len(match["identifier"]) == 8,
            remote=remote,
            fd=fd,
            bit_rate_switch=bool(flags & _BIT_RATE_SWITCH),
            error_state_indicator=bool(flags & _ERROR_STATE),
            dlc=int(code, 16) if code else remote_length,
            iso=iso or not fd,
        )
    except ValueError as error:
        raise InputError(f"frame {text}: {error}", mend=_MEND) from None


def frame_text(frame: Frame) -> str:
    """Text of a frame in the notation of can-utils."""
    identifier = f"{frame.identifier:08X}" if frame.extended else f"{frame.identifier:03X}"
    if frame.remote:
        code = frame.length_code
        return f"{identifier}#R{min(code, 8) or ''}" + (f"_{code:X}" if code > 8 else "")
    data = frame.data.hex().upper()
    if frame.fd:
        flags = _BIT_RATE_SWITCH * frame.bit_rate_switch + _ERROR_STATE * frame.error_state_indicator
        return f"{identifier}##{flags:X}{data}"
    return f"{identifier}#{data}" + (f"_{frame.length_code:X}" if frame.length_code > 8 else "")
