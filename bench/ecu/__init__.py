"""The emulated ABS control unit: it sees decoded frames only, and answers with valve, pump and status frames."""

from signals.compile_cache import prepare_compile_cache

prepare_compile_cache()
