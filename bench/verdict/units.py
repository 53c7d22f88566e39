"""Unit of an expression, as far as it follows from the units of its signals.

A number has no unit of its own in the language, so what it is multiplied with loses its: ``0.33 * wheel_speed_fl`` may
be a speed. Such an expression needs its unit written in the criterion.
"""

import ast
from collections.abc import Mapping
from typing import Any

from bench.verdict.expression import (
    WHEEL_SUFFIXES,
    ExpressionError,
    ExpressionProblem,
    dotted_name,
    named_argument,
    parse,
)
from bench.verdict.vocabulary import CONSTANTS, FUNCTIONS, METRICS
from signals.units import parse_unit, si_name

_BASES = ("m", "kg", "s", "A", "rad", "degC")


def same_dimension(first: str, second: str) -> bool:
    """True if two units measure the same kind of quantity."""
    one, other = parse_unit(first), parse_unit(second)
    return one is not None and other is not None and one[1] == other[1]


def is_si(unit: str) -> bool:
    """True if a unit is known and has no factor to SI."""
    known = parse_unit(unit)
    return known is not None and known[0] == 1.0


def _product(first: str, second: str, sign: int = 1) -> str | None:
    one, other = parse_unit(first), parse_unit(second)
    if one is None or other is None:
        return None
    a, b, c, d, e, f = (x + sign * y for x, y in zip(one[1], other[1], strict=True))
    exponents = (a, b, c, d, e, f)
    written = " ".join(n if x == 1 else f"{n}^{x}" for n, x in zip(_BASES, exponents, strict=True) if x)
    return si_name(exponents) or written


def unit_of(text: str, units: Mapping[str, str]) -> str | None:
    """SI unit of an expression; None if it does not follow from its parts.

    Raises
    ------
    ExpressionError
        If quantities of different units are added or compared.
    """
    return _Inference(text, units).unit(parse(text))


class _Inference:
    def __init__(self, text: str, units: Mapping[str, str]) -> None:
        self.text = text
        self.units = units

    def unit(self, node: ast.expr) -> str | None:
        match node:
            case ast.Constant():
                return None
            case ast.Name() | ast.Attribute():
                return self.named(dotted_name(node) or "")
            case ast.UnaryOp(op=ast.Not()):
                self.unit(node.operand)
                return "1"
            case ast.UnaryOp():
                return self.unit(node.operand)
            case ast.BinOp(op=ast.Add() | ast.Sub()):
                return self.same(node, node.left, node.right)
            case ast.BinOp():
                return self.product(node)
            case ast.BoolOp():
                for value in node.values:
                    self.unit(value)
                return "1"
            case ast.Compare():
                for side in node.comparators:
                    self.same(side, node.left, side)
                return "1"
            case ast.Call():
                return self.call(node)
        return None

    def named(self, name: str) -> str | None:
        if name in self.units:
            return self.units[name]
        if name in METRICS:
            return METRICS[name].unit
        return None if name in CONSTANTS else self.units.get(name)

    def same(self, place: ast.expr, *nodes: ast.expr) -> str | None:
        found: str | None = None
        for node in nodes:
            unit = self.unit(node)
            if unit is None:
                continue
            if found is not None and not same_dimension(unit, found):
                raise ExpressionError(
                    self.text, [ExpressionProblem(place.col_offset, f"found {found} beside {unit}; allowed: one unit")]
                )
            found = found or unit
        return found

    def product(self, node: ast.BinOp) -> str | None:
        left, right = self.unit(node.left), self.unit(node.right)
        if left is None or right is None or not isinstance(node.op, (ast.Mult, ast.Div)):
            return None
        return _product(left, right, 1 if isinstance(node.op, ast.Mult) else -1)

    def call(self, node: ast.Call) -> str | None:
        function: Any = FUNCTIONS[node.func.id]  # type: ignore[attr-defined]
        if function.takes == "wheels":
            return self.units.get(f"{named_argument(node)}{WHEEL_SUFFIXES[0]}")
        if function.takes == "estimate":
            return function.unit if function.unit == "s" else self.units.get(named_argument(node) or "")
        if function.takes == "phase":
            return str(function.unit)
        if function.name in ("max", "min", "rmse", "hypot"):
            return self.same(node, *node.args)
        arguments = [self.unit(argument) for argument in node.args]
        match function.unit:
            case "first":
                return arguments[0]
            case "second":
                return self.same(node, *node.args[1:])
            case "times_s":
                return None if arguments[0] is None else _product(arguments[0], "s")
            case "per_s":
                return None if arguments[0] is None else _product(arguments[0], "s", -1)
            case "unknown":
                return None
            case unit:
                return str(unit)
