"""Records in compiled code by the address of their memory.

Unpacking an array argument costs a call into compiled code a tenth of a microsecond, one of records a quarter. What is
called once per tick therefore gets one array of addresses in place of the arrays that never move.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray


@intrinsic
def pointer(typing_context: Any, address: Any) -> Any:
    """Pointer to the memory at an address, for ``numba.carray``."""

    def generate(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.intp), generate


def addresses_of(*arrays: NDArray[Any]) -> NDArray[np.int64]:
    """Addresses of arrays, which their owner has to keep alive and where they are."""
    return np.array([array.ctypes.data for array in arrays], dtype=np.int64)
