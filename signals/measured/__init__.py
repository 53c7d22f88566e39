"""Measured logs of any car through a channel map: MF4, CSV, Parquet, and CAN logs (BLF, ASC, candump) with a DBC.

``read_log(path, channel_map)`` gives channels under our names in SI units; ``MeasuredLog.resample`` puts them on one
time base.
"""

from typing import Any

_EXPORTS = {
    "ChannelMap": "signals.measured.channel_map",
    "MeasuredLog": "signals.measured.measured_log",
    "load_channel_map": "signals.measured.channel_map",
    "read_log": "signals.measured.measured_log",
}

__all__ = ["ChannelMap", "MeasuredLog", "load_channel_map", "read_log"]


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        from importlib import import_module

        return getattr(import_module(_EXPORTS[name]), name)
    raise AttributeError(f"module 'signals.measured' has no attribute {name!r}")
