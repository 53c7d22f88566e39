"""Four or eight cars side by side in compiled code: a number of each in one vector register, one instruction for all.

Compiled functions that read ``where(condition, a, b)`` and ``if some(condition)`` instead of branching run for one car
(floats) and for several (lanes) alike. Where lanes come from is in ``lane_memory``, logarithms and angles in
``lane_math``.
"""

import math
import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, lower_cast, models, overload, register_model

DOUBLE, LONG, SHORT, BIT = ir.DoubleType(), ir.IntType(64), ir.IntType(32), ir.IntType(1)


class FloatLanes(types.Type):  # type: ignore[misc]
    """A number of each car."""

    def __init__(self, count: int) -> None:
        self.count = count
        super().__init__(f"FloatLanes({count})")

    def can_convert_from(self, _typing: Any, other: types.Type) -> Any:
        return Conversion.safe if isinstance(other, types.Float | types.Integer) else None


class MaskLanes(types.Type):  # type: ignore[misc]
    """True or false for each car."""

    def __init__(self, count: int) -> None:
        self.count = count
        super().__init__(f"MaskLanes({count})")

    def can_convert_from(self, _typing: Any, other: types.Type) -> Any:
        return Conversion.safe if isinstance(other, types.Boolean) else None


def vector(count: int, of: Any = DOUBLE) -> Any:
    """Type of the register that holds so many numbers."""
    return ir.VectorType(of, count)


def hold_as(kind: type[types.Type], held_as: Callable[[Any], Any]) -> None:
    """Tell the compiler what a type is held in."""

    class Model(models.PrimitiveModel):  # type: ignore[misc]
        def __init__(self, manager: Any, of: types.Type) -> None:
            super().__init__(manager, of, held_as(of))

    register_model(kind)(Model)


hold_as(FloatLanes, lambda of: vector(of.count))
hold_as(MaskLanes, lambda of: vector(of.count, BIT))


def _to_all(builder: Any, value: Any, kind: Any) -> Any:
    empty, first = ir.Constant(kind, ir.Undefined), ir.Constant(SHORT, 0)
    everywhere = ir.Constant(vector(kind.count, SHORT), [0] * kind.count)
    return builder.shuffle_vector(builder.insert_element(empty, value, first), empty, everywhere)


@lower_cast(types.Float, FloatLanes)
@lower_cast(types.Integer, FloatLanes)
def _number_to_lanes(context: Any, builder: Any, from_type: Any, to_type: Any, value: Any) -> Any:
    return _to_all(builder, context.cast(builder, value, from_type, types.float64), vector(to_type.count))


@lower_cast(types.Boolean, MaskLanes)
def _bool_to_lanes(_context: Any, builder: Any, _from_type: Any, to_type: Any, value: Any) -> Any:
    bit = builder.icmp_unsigned("!=", value, ir.Constant(value.type, 0))
    return _to_all(builder, bit, vector(to_type.count, BIT))


def _operation(function: Any, makes: type[types.Type], make: Callable[..., Any], of: Any = FloatLanes) -> None:
    """Teach the compiler an operation of lanes with lanes or plain numbers."""
    arity = make.__code__.co_argcount - 1
    plain = types.Boolean if of is MaskLanes else types.Float | types.Integer

    @infer_global(function)
    class _Of(AbstractTemplate):  # type: ignore[misc]
        def generic(self, given: Any, _keywords: Any) -> Any:
            operand = next((one for one in given if isinstance(one, of)), None)
            if operand is None or len(given) != arity:
                return None
            fits = all(one == operand or isinstance(one, plain) for one in given)
            return signature(makes(operand.count), *([operand] * arity)) if fits else None

    def lower(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        return make(builder, *values)

    lower_builtin(function, *([of] * arity))(lower)


def by_llvm(builder: Any, name: str, *values: Any) -> Any:
    """Call of an operation that LLVM has for vectors."""
    kind = values[0].type
    function = ir.FunctionType(kind, [kind] * len(values))
    return builder.call(
        cgutils.get_or_insert_function(builder.module, function, f"llvm.{name}.v{kind.count}f64"), values
    )


def _compared(function: Any, sign: str) -> None:
    _operation(function, MaskLanes, lambda b, x, y: b.fcmp_ordered(sign, x, y))


# a product that is added to something may be rounded once, with it
_FUSING = ("contract",)
for _add, _sub, _mul, _div in (
    (operator.add, operator.sub, operator.mul, operator.truediv),
    (operator.iadd, operator.isub, operator.imul, operator.itruediv),
):
    _operation(_add, FloatLanes, lambda b, x, y: b.fadd(x, y, flags=_FUSING))
    _operation(_sub, FloatLanes, lambda b, x, y: b.fsub(x, y, flags=_FUSING))
    _operation(_mul, FloatLanes, lambda b, x, y: b.fmul(x, y, flags=_FUSING))
    _operation(_div, FloatLanes, lambda b, x, y: b.fdiv(x, y))
for _function, _sign in ((operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">=")):
    _compared(_function, _sign)
_operation(operator.eq, MaskLanes, lambda b, x, y: b.fcmp_ordered("==", x, y))
_operation(operator.ne, MaskLanes, lambda b, x, y: b.fcmp_unordered("!=", x, y))
_operation(operator.and_, MaskLanes, lambda b, x, y: b.and_(x, y), MaskLanes)
_operation(operator.or_, MaskLanes, lambda b, x, y: b.or_(x, y), MaskLanes)
_operation(operator.neg, FloatLanes, lambda b, x: b.fneg(x))
# the order of the comparison is Python's, which keeps its first argument where one is not a number
_operation(max, FloatLanes, lambda b, x, y: b.select(b.fcmp_ordered(">", y, x), y, x))
_operation(min, FloatLanes, lambda b, x, y: b.select(b.fcmp_ordered("<", y, x), y, x))
_operation(abs, FloatLanes, lambda b, x: by_llvm(b, "fabs", x))
_operation(math.sqrt, FloatLanes, lambda b, x: by_llvm(b, "sqrt", x))
_operation(math.copysign, FloatLanes, lambda b, x, y: by_llvm(b, "copysign", x, y))
_operation(math.floor, FloatLanes, lambda b, x: by_llvm(b, "floor", x))


@intrinsic
def _selected(_typing: Any, condition: Any, yes: Any, no: Any) -> Any:
    def lower(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        return builder.select(*values)

    lanes = FloatLanes(condition.count)
    return signature(lanes, condition, lanes, lanes), lower


@intrinsic
def _any_of(_typing: Any, condition: Any) -> Any:
    def lower(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
        bits = ir.IntType(condition.count)
        return builder.icmp_unsigned("!=", builder.bitcast(values[0], bits), ir.Constant(bits, 0))

    return signature(types.boolean, condition), lower


@intrinsic
def one_of(_typing: Any, values: Any, lane: Any) -> Any:
    """Number of one car."""

    def lower(_context: Any, builder: Any, _signature: Any, given: Any) -> Any:
        return builder.extract_element(given[0], builder.trunc(given[1], SHORT))

    return signature(types.float64, values, types.intp), lower


@intrinsic
def with_one(_typing: Any, values: Any, lane: Any, number: Any) -> Any:
    """The same with another number of one car."""

    def lower(_context: Any, builder: Any, _signature: Any, given: Any) -> Any:
        return builder.insert_element(given[0], given[2], builder.trunc(given[1], SHORT))

    return signature(values, values, types.intp, types.float64), lower


def where(condition: Any, yes: Any, no: Any) -> Any:
    """``yes`` of the cars for which the condition holds, ``no`` of the others."""
    return yes if condition else no


def some(condition: Any) -> bool:
    """Whether a condition holds for any of the cars."""
    return bool(condition)


def cell_of(place: Any, last: int) -> Any:
    """Cell of a table of cells of width 1 in which a place lies; the first and the last one go on outside."""
    return min(max(int(place), 0), last)


@overload(where, strict=False)
def _where(condition: Any, yes: Any, no: Any) -> Any:
    if isinstance(condition, MaskLanes):
        return lambda condition, yes, no: _selected(condition, yes, no)
    return lambda condition, yes, no: yes if condition else no


@overload(some, strict=False)
def _some(condition: Any) -> Any:
    if isinstance(condition, MaskLanes):
        return lambda condition: _any_of(condition)
    return lambda condition: condition


@overload(cell_of, strict=False)
def _cell_of(place: Any, last: Any) -> Any:
    if isinstance(place, FloatLanes):
        # what is not a number lies in the first cell: it must not lead out of the table
        return lambda place, last: max(0.0, min(math.floor(place), last))
    return lambda place, last: min(max(int(place), 0), last)
