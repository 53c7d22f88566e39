"""Logarithm, exponential and angles of several cars at once, to the last digit or the last but one."""

import math
import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import njit, types
from numba.core.typing.templates import signature
from numba.extending import intrinsic, overload

from model_diagnosis.replay.lanes import FloatLanes, by_llvm, one_of, some, vector, where, with_one

_LN_2_HIGH, _LN_2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
"""The natural logarithm of 2 in two parts, the first with so few digits that its multiples are exact."""

_SMALL_ANGLE = 0.8
"""Angle [rad] up to which the series below hold to the last digit."""

_LARGEST_EXPONENT = 708.0
"""Whose exponential is a normal number still, as that of its negative is (e^709.8 is the largest double)."""

_PER_LN_2 = 1.0 / math.log(2.0)
_FACTORIAL_13, _FACTORIAL_14, _FACTORIAL_15 = 6227020800.0, 87178291200.0, 1307674368000.0
_FACTORIAL_16, _FACTORIAL_17 = 20922789888000.0, 355687428096000.0

_ABOVE_HALF_ROOT = (0x3FF00000 - 0x3FE6A09E) << 32
_HALF_ROOT = 0x3FE6A09E << 32
"""Bits of sqrt(1/2), and what they lack of those of 1."""


def _longs(count: int) -> Any:
    return vector(count, ir.IntType(64))


def _all(count: int, value: int) -> Any:
    return ir.Constant(_longs(count), [value] * count)


@intrinsic
def _mantissa_and_exponent(_typing: Any, values: Any) -> Any:
    """Positive normal numbers as m 2^e, m from sqrt(1/2) to sqrt(2)."""
    n = values.count

    def lower(context: Any, builder: Any, called: Any, given: Any) -> Any:
        bits = builder.add(builder.bitcast(given[0], _longs(n)), _all(n, _ABOVE_HALF_ROOT))
        exponent = builder.sub(builder.lshr(bits, _all(n, 52)), _all(n, 1023))
        mantissa = builder.add(builder.and_(bits, _all(n, (1 << 52) - 1)), _all(n, _HALF_ROOT))
        parts = builder.bitcast(mantissa, vector(n)), builder.sitofp(exponent, vector(n))
        return context.make_tuple(builder, called.return_type, parts)

    return signature(types.UniTuple(values, 2), values), lower


@intrinsic
def _times_power_of_two(_typing: Any, values: Any, exponent: Any) -> Any:
    n = values.count

    def lower(_context: Any, builder: Any, _called: Any, given: Any) -> Any:
        added = builder.shl(builder.fptosi(given[1], _longs(n)), _all(n, 52))
        return builder.bitcast(builder.add(builder.bitcast(given[0], _longs(n)), added), vector(n))

    return signature(values, values, values), lower


@intrinsic
def _fused(_typing: Any, factor: Any, other: Any, added: Any) -> Any:
    """Product and sum in one, rounded once."""

    def lower(_context: Any, builder: Any, _called: Any, given: Any) -> Any:
        return by_llvm(builder, "fma", *given)

    return signature(factor, factor, factor, factor), lower


@intrinsic
def _count(_typing: Any, values: Any) -> Any:
    """How many cars there are."""

    def lower(_context: Any, _builder: Any, _called: Any, _given: Any) -> Any:
        return ir.Constant(ir.IntType(64), values.count)

    return signature(types.intp, values), lower


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def _logarithm(x: Any) -> Any:
    """ln m = 2 artanh((m - 1)/(m + 1)), its series in pairs of terms so that they wait for each other less."""
    mantissa, exponent = _mantissa_and_exponent(x)
    t = (mantissa - 1.0) / (mantissa + 1.0)
    z = t * t
    z_2 = z * z
    z_4 = z_2 * z_2
    low = _fused(z_2, _fused(z, 2.0 / 9.0, 2.0 / 7.0), _fused(z, 2.0 / 5.0, 2.0 / 3.0))
    middle = _fused(z_2, _fused(z, 2.0 / 17.0, 2.0 / 15.0), _fused(z, 2.0 / 13.0, 2.0 / 11.0))
    series = _fused(z_4, _fused(z_4, _fused(z, 2.0 / 21.0, 2.0 / 19.0), middle), low)
    # 2 t + t z series, and 2 t is as long as x - 1 is exact
    return _fused(exponent, _LN_2_HIGH, _fused(t * z, series, 2.0 * t) + exponent * _LN_2_LOW)


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def _exponential(x: Any) -> Any:
    """2^k e^r, r within half a ln 2."""
    x = min(max(x, -_LARGEST_EXPONENT), _LARGEST_EXPONENT)
    power = math.floor(_fused(x, _PER_LN_2, 0.5))
    r = _fused(power, -_LN_2_LOW, _fused(power, -_LN_2_HIGH, x))
    r_2 = r * r
    r_4 = r_2 * r_2
    a, b = _fused(r, 1.0 / 6.0, 1.0 / 2.0), _fused(r, 1.0 / 120.0, 1.0 / 24.0)
    c, d = _fused(r, 1.0 / 5040.0, 1.0 / 720.0), _fused(r, 1.0 / 362880.0, 1.0 / 40320.0)
    e, f = _fused(r, 1.0 / 39916800.0, 1.0 / 3628800.0), _fused(r, 1.0 / 6227020800.0, 1.0 / 479001600.0)
    series = _fused(r_4, _fused(r_4, _fused(r_2, f, e), _fused(r_2, d, c)), _fused(r_2, b, a))
    return _times_power_of_two(1.0 + _fused(r_2, series, r), power)


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def _sine(x: Any) -> Any:
    z = x * x
    z_2 = z * z
    a, b = _fused(z, 1.0 / 120.0, -1.0 / 6.0), _fused(z, 1.0 / 362880.0, -1.0 / 5040.0)
    c, d = _fused(z, 1.0 / _FACTORIAL_13, -1.0 / 39916800.0), _fused(z, 1.0 / _FACTORIAL_17, -1.0 / _FACTORIAL_15)
    series = _fused(z_2 * z_2, _fused(z_2, d, c), _fused(z_2, b, a))
    found, is_large = _fused(x * z, series, x), abs(x) > _SMALL_ANGLE
    return where(is_large, _one_by_one_sine(x), found) if some(is_large) else found


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def _cosine(x: Any) -> Any:
    z = x * x
    z_2 = z * z
    a, b = _fused(z, 1.0 / 24.0, -1.0 / 2.0), _fused(z, 1.0 / 40320.0, -1.0 / 720.0)
    c, d = _fused(z, 1.0 / 479001600.0, -1.0 / 3628800.0), _fused(z, 1.0 / _FACTORIAL_16, -1.0 / _FACTORIAL_14)
    series = _fused(z_2 * z_2, _fused(z_2, d, c), _fused(z_2, b, a))
    found, is_large = _fused(z, series, 1.0), abs(x) > _SMALL_ANGLE
    return where(is_large, _one_by_one_cosine(x), found) if some(is_large) else found


def _one_by_one(function: Callable[[float], float]) -> Any:
    @njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
    def each(x: Any) -> Any:
        found = x
        for lane in range(_count(x)):
            found = with_one(found, lane, function(one_of(x, lane)))
        return found

    return each


_one_by_one_sine, _one_by_one_cosine = _one_by_one(math.sin), _one_by_one(math.cos)


def _overload(function: Any, by_lanes: Any) -> None:
    @overload(function, strict=False)
    def _of(x: Any) -> Any:
        return (lambda x: by_lanes(x)) if isinstance(x, FloatLanes) else None


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def _hyperbolic_tangent(x: Any) -> Any:
    return 1.0 - 2.0 / (_exponential(2.0 * x) + 1.0)


for _function, _by_lanes in (
    (math.log, _logarithm),
    (math.exp, _exponential),
    (math.sin, _sine),
    (math.cos, _cosine),
    (math.tanh, _hyperbolic_tangent),
    (math.tan, _one_by_one(math.tan)),
    (math.atan, _one_by_one(math.atan)),
):
    _overload(_function, _by_lanes)


@overload(operator.pow, strict=False)
def _power(base: Any, exponent: Any) -> Any:
    if isinstance(base, FloatLanes) and isinstance(exponent, FloatLanes):
        return lambda base, exponent: _exponential(exponent * _logarithm(base))
    return None


@overload(math.atan2, strict=False)
def _arc_tangent(y: Any, x: Any) -> Any:
    if not isinstance(y, FloatLanes) or not isinstance(x, FloatLanes):
        return None

    def each(y: Any, x: Any) -> Any:
        found = x
        for lane in range(_count(x)):
            found = with_one(found, lane, math.atan2(one_of(y, lane), one_of(x, lane)))
        return found

    return each
