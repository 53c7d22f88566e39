"""Numbers of several cars in memory: fields of records, and tables; compiled.

Tables that hold a number of each car have axes more than those that hold one for all: (n, c, 4) of four cars,
(n, c, 2, 4) of eight. Records of several cars are arrays (k, cars), a row for each number of ``REPLAY_RECORD`` or
``STATE_RECORD``.
"""

import operator
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global, signature
from numba.extending import intrinsic, lower_builtin, lower_getattr_generic, lower_setattr_generic, overload

from model_diagnosis.replay.lanes import DOUBLE, LONG, SHORT, FloatLanes, hold_as, vector
from model_diagnosis.replay.record import REPLAY_RECORD
from model_diagnosis.replay.state import STATE_RECORD

LANE_AXES = {4: (4,), 8: (2, 4)}
"""Axes behind those of a table by the number of cars: so many numbers fill a register of 256 or 512 bits."""

_COUNT_BY_AXES = {2 + len(axes): count for count, axes in LANE_AXES.items()}
_LAYOUTS = {
    kind: {name: (offset // 8, of.shape) for name, (of, offset, *_) in record.fields.items()}
    for kind, record in (("car", REPLAY_RECORD), ("state", STATE_RECORD))
    if record.fields is not None
}


class LaneRecord(types.Type):  # type: ignore[misc]
    """Fields of a record of each car."""

    def __init__(self, kind: str, count: int) -> None:
        self.kind, self.count = kind, count
        super().__init__(f"LaneRecord({kind}, {count})")


class LaneField(types.Type):  # type: ignore[misc]
    """An array of each car."""

    def __init__(self, shape: tuple[int, ...], count: int) -> None:
        self.shape, self.count = shape, count
        super().__init__(f"LaneField({shape}, {count})")


hold_as(LaneRecord, lambda _: DOUBLE.as_pointer())
hold_as(LaneField, lambda _: DOUBLE.as_pointer())


@infer_getattr
class _Attributes(AttributeTemplate):  # type: ignore[misc]
    key = LaneRecord

    def generic_resolve(self, record: LaneRecord, name: str) -> types.Type | None:
        known = _LAYOUTS[record.kind].get(name)
        if known is None:
            return None
        return LaneField(known[1], record.count) if known[1] else FloatLanes(record.count)


def _at(builder: Any, base: Any, place: Any, count: int) -> Any:
    """Address of the lanes at a place counted in numbers of one car."""
    place = ir.Constant(LONG, place) if isinstance(place, int) else place
    return builder.gep(base, [builder.mul(place, ir.Constant(LONG, count))])


def _load(builder: Any, address: Any, count: int) -> Any:
    value = builder.load(builder.bitcast(address, vector(count).as_pointer()))
    value.align = 8
    return value


def _store(builder: Any, value: Any, address: Any) -> None:
    builder.store(value, builder.bitcast(address, value.type.as_pointer()), align=8)


@lower_getattr_generic(LaneRecord)
def _get_attribute(_context: Any, builder: Any, record: LaneRecord, base: Any, name: str) -> Any:
    offset, shape = _LAYOUTS[record.kind][name]
    address = _at(builder, base, offset, record.count)
    return address if shape else _load(builder, address, record.count)


@lower_setattr_generic(LaneRecord)
def _set_attribute(context: Any, builder: Any, called: Any, values: Any, name: str) -> None:
    record, given = called.args
    lanes = context.cast(builder, values[1], given, FloatLanes(record.count))
    _store(builder, lanes, _at(builder, values[0], _LAYOUTS[record.kind][name][0], record.count))


@infer_global(operator.getitem)
class _GetItem(AbstractTemplate):  # type: ignore[misc]
    def generic(self, given: Any, _keywords: Any) -> Any:
        return signature(FloatLanes(given[0].count), *given) if isinstance(given[0], LaneField) else None


@infer_global(operator.setitem)
class _SetItem(AbstractTemplate):  # type: ignore[misc]
    def generic(self, given: Any, _keywords: Any) -> Any:
        field, place, _ = given
        return signature(types.none, field, place, FloatLanes(field.count)) if isinstance(field, LaneField) else None


def _places(context: Any, builder: Any, field: LaneField, kind: Any, index: Any) -> tuple[Any, Any]:
    """Place in a field that is the same for all cars, and what each car adds to it; None where none does."""
    kinds, parts = ([kind], [index])
    if isinstance(kind, types.BaseTuple):
        kinds, parts = list(kind), cgutils.unpack_tuple(builder, index)
    same, own = ir.Constant(LONG, 0), None
    for axis, (of, part) in enumerate(zip(kinds, parts, strict=True)):
        stride = int(np.prod(field.shape[axis + 1 :]))
        if isinstance(of, FloatLanes):
            longs = vector(of.count, LONG)
            own = builder.mul(builder.fptosi(part, longs), ir.Constant(longs, [stride] * of.count))
        else:
            whole = context.cast(builder, part, of, types.intp)
            same = builder.add(same, builder.mul(whole, ir.Constant(LONG, stride)))
    return same, own


@lower_builtin(operator.getitem, LaneField, types.Any)
def _get_item(context: Any, builder: Any, called: Any, values: Any) -> Any:
    count = called.args[0].count
    same, own = _places(context, builder, called.args[0], called.args[1], values[1])
    base = _at(builder, values[0], same, count)
    if own is None:
        return _load(builder, base, count)
    found = ir.Constant(vector(count), ir.Undefined)
    for lane in range(count):
        number = ir.Constant(SHORT, lane)
        address = _at(builder, base, builder.extract_element(own, number), count)
        one = builder.load(builder.gep(address, [ir.Constant(LONG, lane)]))
        found = builder.insert_element(found, one, number)
    return found


@lower_builtin(operator.setitem, LaneField, types.Any, FloatLanes)
def _set_item(context: Any, builder: Any, called: Any, values: Any) -> Any:
    same, _ = _places(context, builder, called.args[0], called.args[1], values[1])
    _store(builder, values[2], _at(builder, values[0], same, called.args[0].count))
    return context.get_dummy_value()


def _data(context: Any, builder: Any, kind: Any, array: Any) -> Any:
    return context.make_array(kind)(context, builder, array).data


@intrinsic
def _lanes_at(_typing: Any, values: Any, place: Any) -> Any:
    count = _COUNT_BY_AXES[values.ndim]

    def lower(context: Any, builder: Any, called: Any, given: Any) -> Any:
        base = _data(context, builder, called.args[0], given[0])
        return _load(builder, _at(builder, base, given[1], count), count)

    return signature(FloatLanes(count), values, types.intp), lower


@intrinsic
def _put_lanes(_typing: Any, values: Any, place: Any, lanes: Any) -> Any:
    count = _COUNT_BY_AXES[values.ndim]

    def lower(context: Any, builder: Any, called: Any, given: Any) -> Any:
        base = _data(context, builder, called.args[0], given[0])
        _store(builder, given[2], _at(builder, base, given[1], count))
        return context.get_dummy_value()

    return signature(types.void, values, types.intp, FloatLanes(count)), lower


def at(values: Any, row: int, column: int) -> Any:
    """Number of a table that holds one for all cars, or numbers of each from one that holds them."""
    return values[row, column]


def put(values: Any, row: int, column: int, number: Any) -> None:
    """Write a number, or the numbers of all cars, into a table."""
    values[row, column] = number


@overload(at, strict=False)
def _at_of(values: Any, row: Any, column: Any) -> Any:
    if values.ndim in _COUNT_BY_AXES:
        return lambda values, row, column: _lanes_at(values, row * values.shape[1] + column)
    return lambda values, row, column: values[row, column]


@overload(put, strict=False)
def _put_of(values: Any, row: Any, column: Any, number: Any) -> Any:
    if values.ndim in _COUNT_BY_AXES:

        def put_all(values: Any, row: Any, column: Any, number: Any) -> None:
            _put_lanes(values, row * values.shape[1] + column, number)

        return put_all

    def put_one(values: Any, row: Any, column: Any, number: Any) -> None:
        values[row, column] = number

    return put_one


@intrinsic(prefer_literal=True)
def numbers_of_lanes(_typing: Any, values: Any, count: Any) -> Any:
    """Array of each of ``count`` cars, over the rows of (k, count) values."""

    def lower(context: Any, builder: Any, called: Any, given: Any) -> Any:
        return _data(context, builder, called.args[0], given[0])

    return signature(LaneField((0,), count.literal_value), values, count), lower


@intrinsic(prefer_literal=True)
def lanes_of(_typing: Any, kind: Any, values: Any, count: Any) -> Any:
    """Record of ``count`` cars, of ``kind`` "car" or "state", whose numbers are the rows of (fields, count) values."""

    def lower(context: Any, builder: Any, called: Any, given: Any) -> Any:
        return _data(context, builder, called.args[1], given[1])

    return signature(LaneRecord(kind.literal_value, count.literal_value), kind, values, count), lower
