"""Links to an ECU: one small interface, one module for each kind of bus.

:func:`bench.links.registry.open_link` opens a link by its text (``udp``, ``socketcan:vcan0``, ``slcan:/dev/ttyUSB0``),
:mod:`bench.links.barrier` keeps two processes in lock-step, :mod:`bench.links.frame` is the frame they all hand on.
"""

from signals.compile_cache import prepare_compile_cache

prepare_compile_cache()
