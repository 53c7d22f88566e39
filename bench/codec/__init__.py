"""CAN database → compiled packing and unpacking of frames, with end-to-end protection.

:class:`~bench.codec.codec.Codec` is what the rest of the bench uses; ``database``, ``mapping_file`` and ``layout`` need
neither numba nor (once a database was read) cantools, so that checking files stays quick.
"""

from signals.compile_cache import prepare_compile_cache

prepare_compile_cache()
