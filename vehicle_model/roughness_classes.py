"""Roughness classes of ISO 8608, apart from the numerics so that road files are read without them."""

from types import MappingProxyType

CLASS_LEVELS = MappingProxyType({name: 16e-6 * 4.0**number for number, name in enumerate("ABCDEFGH")})
"""Geometric mean of G_d(0.1 cycles/m) of each class, m^3 (ISO 8608, table C.1: 16, 64, 256, … times 1e-6)."""
