"""Evaluation of a checked syntax tree over the rows of a run.

Inside, a value is a number or an array of shape (rows, wheels) where either may be 1: signals are (n, 1), the four
wheels of a signal (n, 4), a metric with a value per wheel (1, 4). So every operator broadcasts as it reads.
"""

import ast
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.recording.arrays import RunArrays
from bench.verdict.assessment import Assessment, NoValueError
from bench.verdict.expression import ExpressionError, ExpressionProblem, dotted_name, named_argument
from bench.verdict.functions import IMPLEMENTATIONS, Rows
from bench.verdict.truth import truth_of
from bench.verdict.vocabulary import CONSTANTS, FUNCTIONS, METRICS

Value = float | bool | NDArray[Any]

_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: np.divide,
    ast.Pow: np.power,
    ast.Mod: np.mod,
}
_COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}


def evaluate_tree(tree: ast.expr, text: str, data: Assessment | RunArrays, window: slice | str | None) -> Value:
    """Value of a parsed expression; see :func:`bench.verdict.expression.evaluate`."""
    assessment = data if isinstance(data, Assessment) else Assessment(data)
    try:
        rows = assessment.window(window)
    except KeyError:
        raise ExpressionError(text, [ExpressionProblem(0, f"no phase {window!r}")]) from None
    if rows.stop <= rows.start:
        raise NoValueError("the recording has no row here")
    with np.errstate(all="ignore"):
        return _simple(_Evaluation(assessment, rows, text).value(tree))


def _simple(value: Any) -> Value:
    """Number, truth value or array without dimensions of length one."""
    array = np.asarray(value)
    if array.size == 1:
        single = array.reshape(-1)[0]
        return bool(single) if array.dtype == np.bool_ else float(single)
    if array.ndim == 2 and 1 in array.shape:
        return array.reshape(-1)
    return array


class _Evaluation:
    def __init__(self, assessment: Assessment, window: slice, text: str) -> None:
        self.assessment = assessment
        self.window = window
        self.text = text
        self.rows = Rows.of(assessment.time, window)

    def value(self, node: ast.expr) -> Any:
        match node:
            case ast.Constant(value=bool() as truth):
                return np.bool_(truth)
            case ast.Constant(value=number):
                return np.float64(number)  # type: ignore[arg-type]
            case ast.Name() | ast.Attribute():
                return self.named(node, dotted_name(node) or "")
            case ast.UnaryOp(op=ast.Not()):
                return np.logical_not(self.value(node.operand))
            case ast.UnaryOp(op=ast.USub()):
                return np.negative(np.asarray(self.value(node.operand), np.float64))
            case ast.UnaryOp():
                return self.value(node.operand)
            case ast.BinOp():
                return _BINARY[type(node.op)](self.number(node.left), self.number(node.right))
            case ast.BoolOp():
                combine = np.logical_and if isinstance(node.op, ast.And) else np.logical_or
                value = self.value(node.values[0])
                for other in node.values[1:]:
                    value = combine(value, self.value(other))
                return value
            case ast.Compare():
                return self.comparison(node)
            case ast.Call():
                return self.call(node)
        raise self.problem(node, f"{type(node).__name__} is not part of the language")

    def number(self, node: ast.expr) -> Any:
        """Value as numbers: a condition counts as 0 or 1."""
        value = self.value(node)
        return value if np.asarray(value).dtype == np.float64 else np.asarray(value, np.float64)

    def comparison(self, node: ast.Compare) -> Any:
        left = self.value(node.left)
        result: Any = np.bool_(True)
        for operation, right_node in zip(node.ops, node.comparators, strict=True):
            right = self.value(right_node)
            result = np.logical_and(result, _COMPARE[type(operation)](left, right))
            left = right
        return result

    def named(self, node: ast.expr, name: str) -> Any:
        if name in self.assessment.data:
            return self.assessment.data.array(name)[self.window, None]
        if name in METRICS:
            value = self.assessment.metric(name)
            return np.reshape(value, (1, 4)) if isinstance(value, np.ndarray) else np.float64(value)
        if name in CONSTANTS:
            return np.float64(CONSTANTS[name])
        raise self.problem(node, f"the recording has no signal {name!r}")

    def call(self, node: ast.Call) -> Any:
        function = FUNCTIONS[node.func.id]  # type: ignore[attr-defined]
        if function.takes == "phase":
            return self.phase(node, function.name, named_argument(node) or "")
        if function.takes == "wheels":
            return self.wheels(node, function.name, named_argument(node) or "")
        if function.takes == "estimate":
            return self.estimate(node, function.name, named_argument(node) or "")
        arguments = [self.value(argument) for argument in node.args]
        try:
            return IMPLEMENTATIONS[function.name](self.rows, *arguments)
        except ValueError as error:
            raise self.problem(node, f"{function.name}: {error}") from None

    def phase(self, node: ast.expr, function: str, name: str) -> Any:
        try:
            phase = self.assessment.window(name)
        except KeyError:
            raise self.problem(node, f"no phase {name!r}") from None
        except NoValueError:
            if function == "in_phase":
                return np.zeros((len(self.rows.time), 1), np.bool_)
            raise
        if function == "start":
            return np.float64(self.assessment.time[phase.start])
        if function == "end":
            return np.float64(self.assessment.time[phase.stop - 1])
        inside = np.zeros(len(self.assessment.time), np.bool_)
        inside[phase] = True
        return inside[self.window, None]

    def wheels(self, node: ast.expr, function: str, name: str) -> Any:
        data = self.assessment.data
        wheels = {"wheels": ("fl", "fr", "rl", "rr"), "front": ("fl", "fr"), "rear": ("rl", "rr")}[function]
        missing = [wheel for wheel in wheels if f"{name}_{wheel}" not in data]
        if missing:
            raise self.problem(node, f"the recording has no signal {name}_{missing[0]}")
        values = np.column_stack([data.array(f"{name}_{wheel}")[self.window] for wheel in wheels])
        return values if function == "wheels" else values.mean(axis=1, keepdims=True)

    def estimate(self, node: ast.expr, function: str, name: str) -> Any:
        from bench.verdict import metrics

        if name not in self.assessment.data:
            raise self.problem(node, f"the recording has no estimate {name!r}")
        if truth_of(name) is None:
            raise self.problem(node, f"the simulated car has no true value for {name!r}")
        truth = metrics.truth(self.assessment, name)
        if function == "truth":
            return truth[self.window, None]
        if function == "estimator_error":
            return np.float64(metrics.estimator_error(self.assessment, name, self.window))
        return np.float64(metrics.settling_time(self.assessment, name, self.window))

    def problem(self, node: ast.expr, message: str) -> ExpressionError:
        return ExpressionError(self.text, [ExpressionProblem(node.col_offset, message)])
