"""Unit of an expression, as far as it follows from the units of its signals.

A number has no unit of its own in the language, so what it is multiplied with loses its: ``0.33 * wheel_speed_fl`` may
be a speed. Such an expression needs its unit written in the criterion.
"""

import ast
import re
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

_FACTOR = re.compile(r"([A-Za-z]+)(?:\^(-?\d+))?$")

Dimension = dict[str, int]


def dimension(unit: str) -> Dimension:
    """Exponents of a unit as the catalogue writes them: ``m/s^2`` is {m: 1, s: -2}."""
    exponents: Dimension = {}
    for position, part in enumerate(unit.split("/")):
        sign = 1 if position == 0 else -1
        for word in part.split():
            match = _FACTOR.match(word)
            if match is not None:
                exponents[match[1]] = exponents.get(match[1], 0) + sign * int(match[2] or 1)
    return {name: exponent for name, exponent in exponents.items() if exponent}


def _written(exponents: Dimension) -> str:
    def part(sign: int) -> str:
        words = [(n, e * sign) for n, e in sorted(exponents.items()) if e * sign > 0]
        return " ".join(n if e == 1 else f"{n}^{e}" for n, e in words)

    above, below = part(1), part(-1)
    return (above or "1") + (f"/{below.replace(' ', '/')}" if below else "")


def _product(first: str, second: str, sign: int = 1) -> str:
    exponents = dimension(first)
    for name, exponent in dimension(second).items():
        exponents[name] = exponents.get(name, 0) + sign * exponent
    return _written({name: exponent for name, exponent in exponents.items() if exponent})


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
            if found is not None and dimension(unit) != dimension(found):
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
