"""Expressions over the results of runs: ``mean(abs.stopping_distance) / mean(locked.stopping_distance)``.

``NAME.QUANTITY`` is a list with a value per run of that name; quantities are the metrics of a verdict and the ids of
the scenario's criteria. Arithmetic acts value by value, a function makes one value of a list.
"""

import ast
import math
import statistics
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

from signals.errors import nearest_name

Values = list[float]
Results = Mapping[str, Mapping[str, Sequence[float]]]

_OPERATORS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b if b else math.nan,
    ast.Pow: lambda a, b: a**b,
}


def _deviation(values: Values) -> float:
    return statistics.stdev(values) if len(values) > 1 else math.nan


def half_width(values: Values) -> float:
    """Half the width of the 95 % interval of the mean, by Student's t-distribution."""
    if len(values) < 2:
        return math.nan
    from scipy.stats import t

    return float(t.ppf(0.975, len(values) - 1)) * _deviation(values) / math.sqrt(len(values))


FUNCTIONS: dict[str, Callable[[Values], float]] = {
    "mean": statistics.fmean,
    "median": statistics.median,
    "min": min,
    "max": max,
    "std": _deviation,
    "variation": lambda values: _deviation(values) / abs(statistics.fmean(values)),
    "half_width": half_width,
    "count": lambda values: float(len(values)),
}


@dataclass(frozen=True)
class Problem:
    """What is wrong with an expression."""

    message: str
    nearest: str = ""
    allowed: str = ""


def check(text: str, quantities: Mapping[str, Collection[str]]) -> list[Problem]:
    """Everything that is wrong with an expression for runs that have these quantities by name."""
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError):
        return [Problem(f"not an expression: {text!r}", allowed="e.g. mean(abs.stopping_distance)")]
    return list(_problems(tree, quantities))


def _problems(node: ast.expr, quantities: Mapping[str, Collection[str]]) -> Iterator[Problem]:
    match node:
        case ast.Constant(value=int() | float()):
            return
        case ast.Attribute(value=ast.Name(id=name), attr=quantity):
            if name not in quantities:
                yield Problem(
                    f"no runs of the name {name!r}", nearest_name(name, list(quantities)), ", ".join(quantities)
                )
            elif quantity not in quantities[name]:
                yield Problem(f"runs have no quantity {quantity!r}", nearest_name(quantity, list(quantities[name])))
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
            yield from _problems(left, quantities)
            yield from _problems(right, quantities)
        case ast.UnaryOp(op=ast.USub() | ast.UAdd(), operand=operand):
            yield from _problems(operand, quantities)
        case ast.Call(func=ast.Name(id=function), args=[argument], keywords=[]):
            if function not in FUNCTIONS:
                yield Problem(
                    f"no function {function!r}", nearest_name(function, list(FUNCTIONS)), ", ".join(FUNCTIONS)
                )
            yield from _problems(argument, quantities)
        case _:
            allowed = "NAME.QUANTITY, numbers, + - * / **, one of the functions with one argument"
            yield Problem(f"not part of the language: {ast.unparse(node)}", allowed=allowed)


def names_used(text: str) -> set[str]:
    """Names of the runs that an expression reads."""
    tree = ast.parse(text.strip(), mode="eval")
    return {
        node.value.id for node in ast.walk(tree) if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name)
    }


def evaluate(text: str, results: Results) -> float:
    """Value of an expression that `check` has passed; NaN where a run has no value.

    Raises
    ------
    ValueError
        If the expression has a value per run and no function makes one of them.
    """
    values = _evaluate(ast.parse(text.strip(), mode="eval").body, results)
    if len(values) != 1:
        raise ValueError(f"{len(values)} values; take mean(…), max(…) or another of {', '.join(FUNCTIONS)}")
    return values[0]


def _evaluate(node: ast.expr, results: Results) -> Values:
    match node:
        case ast.Constant(value=int() | float() as number):
            return [float(number)]
        case ast.Attribute(value=ast.Name(id=name), attr=quantity):
            return list(results[name][quantity])
        case ast.UnaryOp(op=op, operand=operand):
            sign = -1.0 if isinstance(op, ast.USub) else 1.0
            return [sign * value for value in _evaluate(operand, results)]
        case ast.BinOp(left=left, op=op, right=right):
            return _combined(_OPERATORS[type(op)], _evaluate(left, results), _evaluate(right, results))
        case ast.Call(func=ast.Name(id=function), args=[argument]):
            values = _evaluate(argument, results)
            return [math.nan if any(map(math.isnan, values)) else FUNCTIONS[function](values)]
    raise ValueError(f"not part of the language: {ast.unparse(node)}")


def _combined(operation: Callable[[float, float], float], left: Values, right: Values) -> Values:
    if len(left) == 1:
        left = left * len(right)
    if len(right) == 1:
        right = right * len(left)
    if len(left) != len(right):
        raise ValueError(f"{len(left)} values with {len(right)}: runs of different numbers have to be averaged first")
    return [operation(a, b) for a, b in zip(left, right, strict=True)]
