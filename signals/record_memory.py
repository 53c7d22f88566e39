"""Records and rows of numbers in compiled code by the address of their memory.

Unpacking an array argument costs a call into compiled code a tenth of a microsecond, one of records a quarter. What is
called once per tick therefore gets the address of one list of addresses in place of the arrays that never move. Between
compiled functions a pointer is cheaper than an array too: arrays are counted in and out of every call.
"""

from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray


@intrinsic
def pointer(typing_context: Any, address: Any) -> Any:
    """Pointer to the memory at an address, for ``numba.carray``."""

    def generate(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.intp), generate


@intrinsic
def record_at(typing_context: Any, address: Any, dtype: Any) -> Any:
    """The record of a structured dtype at an address."""
    record = dtype.dtype

    def generate(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], context.get_value_type(record))

    return record(types.intp, dtype), generate


def _pointer_to(number: Any) -> Any:
    result = types.CPointer(number)

    def generate(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], context.get_value_type(result))

    return result(types.intp), generate


@intrinsic
def numbers_at(typing_context: Any, address: Any) -> Any:
    """Float64 that lie one after the other from an address on, by index; nothing checks the index."""
    return _pointer_to(types.float64)


@intrinsic
def addresses_at(typing_context: Any, address: Any) -> Any:
    """What `addresses_of` gave, by index, from its own address."""
    return _pointer_to(types.intp)


@intrinsic
def address_in(typing_context: Any, row: Any, place: Any) -> Any:
    """Address of a place in a row of float64: one-dimensional contiguous array, or what `numbers_at` gave."""
    array = isinstance(row, types.Array)
    if not array and not isinstance(row, types.CPointer):
        return None

    def generate(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> Any:
        first = arguments[0]
        if array:
            first = context.make_array(row)(context, builder, first).data
        return builder.ptrtoint(builder.gep(first, [arguments[1]]), cgutils.intp_t)

    return types.intp(row, types.intp), generate


@njit(cache=True)
def matrix_in(table: Any, place: int) -> Any:
    """Float64 matrix of a place in what `table_of` gave."""
    return numba.carray(pointer(table[3 * place]), (table[3 * place + 1], table[3 * place + 2]), numba.float64)


@njit(cache=True)
def row_in(table: Any, place: int) -> Any:
    """Float64 row of a place in what `table_of` gave."""
    return numba.carray(pointer(table[3 * place]), table[3 * place + 1], numba.float64)


@njit(cache=True)
def whole_matrix_in(table: Any, place: int) -> Any:
    """Int64 matrix of a place in what `table_of` gave."""
    return numba.carray(pointer(table[3 * place]), (table[3 * place + 1], table[3 * place + 2]), numba.int64)


@njit(cache=True)
def whole_row_in(table: Any, place: int) -> Any:
    """Int64 row of a place in what `table_of` gave."""
    return numba.carray(pointer(table[3 * place]), table[3 * place + 1], numba.int64)


def table_of(*arrays: NDArray[np.float64] | NDArray[np.int64]) -> NDArray[np.int64]:
    """Address and shape of rows and matrices, three numbers each; their owner has to keep them where they are.

    Raises
    ------
    ValueError
        If one is not of consecutive float64 or int64, or has more than two dimensions.
    """
    table = np.zeros((len(arrays), 3), np.int64)
    for entry, array in zip(table, arrays, strict=True):
        if array.dtype not in (np.float64, np.int64) or array.ndim not in (1, 2) or not array.flags.c_contiguous:
            raise ValueError(f"found {array.dtype} of shape {array.shape}, allowed: rows or matrices without gaps")
        entry[0], entry[1 : 1 + array.ndim] = array.ctypes.data, array.shape
    return table.ravel()


def addresses_of(*arrays: NDArray[Any]) -> NDArray[np.int64]:
    """Addresses of arrays, which their owner has to keep alive and where they are."""
    return np.array([array.ctypes.data for array in arrays], dtype=np.int64)


def numbers_address(array: NDArray[np.float64], count: int) -> int:
    """Address of an array for `numbers_at`; its owner has to keep it alive.

    Raises
    ------
    ValueError
        If it is not ``count`` consecutive float64.
    """
    if array.shape != (count,) or array.dtype != np.float64 or not array.flags.c_contiguous:
        raise ValueError(
            f"found {array.dtype} of shape {array.shape}, allowed: {count} consecutive float64, as numpy.zeros gives"
        )
    return int(array.ctypes.data)
