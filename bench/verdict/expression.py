"""Safe expressions over signals, phases and metrics, as criteria use them: ``max(abs(true_yaw_rate)) < 0.2``.

A text is parsed by the standard library's ``ast`` and only a short list of node types is accepted; nothing is ever
handed to ``eval``. Numbers are SI. Checking needs neither numpy nor a recording.
"""

import ast
import difflib
import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from bench.verdict.vocabulary import CONSTANTS, FUNCTIONS, METRICS, PHASES, Function

if TYPE_CHECKING:
    from bench.verdict.assessment import Assessment
    from bench.verdict.evaluation import Value

MAX_LENGTH = 2000
WHEEL_SUFFIXES = ("_fl", "_fr", "_rl", "_rr")

_OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow, ast.Mod)
_COMPARISONS = (ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq)
_UNARY = (ast.USub, ast.UAdd, ast.Not)
_UNIT_LITERAL = re.compile(r"(?<![\w.])(\d+\.?\d*(?:[eE][+-]?\d+)?)\s*(%|[A-Za-zµ°][\w^/]*)")
_WORDS = {"and", "or", "not", "if", "else"}


@dataclass(frozen=True)
class ExpressionProblem:
    """What is wrong with an expression, and where.

    Attributes
    ----------
    column : int
        Offset in the text, from 0.
    message : str
        Found, allowed and, for a name, the nearest one.
    """

    column: int
    message: str


class ExpressionError(ValueError):
    """An expression that cannot be parsed or used; carries its problems."""

    def __init__(self, text: str, problems: list[ExpressionProblem]) -> None:
        self.text = text
        self.problems = problems
        super().__init__("; ".join(f"{text!r}, column {p.column + 1}: {p.message}" for p in problems))


@lru_cache(maxsize=4096)
def parse(text: str) -> ast.expr:
    """Syntax tree of an expression, restricted to what the language has.

    Raises
    ------
    ExpressionError
        If the text is no expression or uses anything else of Python.
    """
    flat = re.sub(r"\s", " ", text)
    problem = _syntax_problem(flat)
    if problem is not None:
        raise ExpressionError(text, [problem])
    tree = ast.parse(flat.lstrip(), mode="eval").body
    shift = len(flat) - len(flat.lstrip())
    problems = [ExpressionProblem(p.column + shift, p.message) for p in _structure(tree)]
    if problems:
        raise ExpressionError(text, problems)
    return tree


def _syntax_problem(text: str) -> ExpressionProblem | None:
    if not text.strip():
        return ExpressionProblem(0, "found an empty text; allowed: an expression such as max(speed)")
    if len(text) > MAX_LENGTH:
        return ExpressionProblem(MAX_LENGTH, f"longer than {MAX_LENGTH} characters")
    try:
        ast.parse(text.lstrip(), mode="eval")
    except SyntaxError as error:
        literal = next((m for m in _UNIT_LITERAL.finditer(text) if m[2] not in _WORDS), None)
        if literal is None:
            indent = len(text) - len(text.lstrip())
            return ExpressionProblem(indent + max((error.offset or 1) - 1, 0), f"not an expression: {error.msg}")
        hint = _si_hint(*literal.groups())
        return ExpressionProblem(
            literal.start(), f"found {literal[0]!r}; allowed: numbers in SI units, unit left out{hint}"
        )
    except (RecursionError, MemoryError, ValueError):
        return ExpressionProblem(0, "not an expression: too deeply nested, or a character that no expression has")
    return None


def _si_hint(number: str, unit: str) -> str:
    factors = {"km/h": 1 / 3.6, "bar": 1e5, "deg": 0.017453292519943295, "ms": 1e-3, "g": 9.81, "%": 1e-2, "kN": 1e3}
    if unit not in factors:
        return ""
    return f" (write {float(number) * factors[unit]:.6g})"


def _structure(tree: ast.expr) -> Iterator[ExpressionProblem]:
    """Problems of node types, in reading order."""
    try:
        yield from _structure_of(tree)
    except RecursionError:
        yield ExpressionProblem(0, "too deeply nested")


def _structure_of(node: ast.expr) -> Iterator[ExpressionProblem]:
    match node:
        case ast.Constant(value=bool() | int() | float()):
            return
        case ast.Constant(value=str()):
            yield ExpressionProblem(node.col_offset, "a text stands only where a phase is named, as in start('brake')")
        case ast.Name():
            return
        case ast.Attribute():
            if dotted_name(node) is None:
                yield ExpressionProblem(node.col_offset, "a dot stands only in the name of an estimator's output")
        case ast.BinOp(op=ast.BitAnd() | ast.BitOr()):
            yield ExpressionProblem(node.col_offset, "found & or |; allowed: and, or")
        case ast.BinOp(op=ast.BitXor()):
            yield ExpressionProblem(node.col_offset, "found ^; a power is written **")
        case ast.BinOp() if isinstance(node.op, _OPERATORS):
            yield from _structure_of(node.left)
            yield from _structure_of(node.right)
        case ast.UnaryOp() if isinstance(node.op, _UNARY):
            yield from _structure_of(node.operand)
        case ast.BoolOp():
            for value in node.values:
                yield from _structure_of(value)
        case ast.Compare() if all(isinstance(op, _COMPARISONS) for op in node.ops):
            for side in (node.left, *node.comparators):
                yield from _structure_of(side)
        case ast.Call():
            yield from _structure_of_call(node)
        case _:
            yield ExpressionProblem(
                node.col_offset, f"{type(node).__name__} is not part of the language (see docs/verdicts.md)"
            )


def _structure_of_call(node: ast.Call) -> Iterator[ExpressionProblem]:
    if not isinstance(node.func, ast.Name):
        yield ExpressionProblem(node.col_offset, "only the functions of docs/verdicts.md can be called")
        return
    function = FUNCTIONS.get(node.func.id)
    if function is None:
        yield ExpressionProblem(node.col_offset, f"no function {node.func.id!r}{nearest(node.func.id, FUNCTIONS)}")
        return
    if node.keywords or not function.least <= len(node.args) <= function.most:
        yield ExpressionProblem(
            node.col_offset, f"found {len(node.args) + len(node.keywords)} arguments; allowed: {name_call(function)}"
        )
        return
    if function.takes == "values":
        for argument in node.args:
            yield from _structure_of(argument)
    elif named_argument(node) is None:
        yield ExpressionProblem(node.args[0].col_offset, f"the argument has to be a name: {name_call(function)}")


def name_call(function: Function) -> str:
    """How a function is called, for messages."""
    return f"{function.name}({function.arguments})"


def dotted_name(node: ast.expr) -> str | None:
    """``friction_ekf.speed`` of an attribute chain of names, the name itself of a name, else None."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        head = dotted_name(node.value)
        return None if head is None else f"{head}.{node.attr}"
    return None


def named_argument(node: ast.Call) -> str | None:
    """What the only argument of ``start('brake')`` or ``wheels(slip_ratio)`` names."""
    argument = node.args[0]
    if isinstance(argument, ast.Constant) and isinstance(argument.value, str):
        return argument.value
    return dotted_name(argument)


def nearest(name: str, allowed: Collection[str]) -> str:
    """``; did you mean …?`` for the nearest allowed name, or an empty text."""
    close = difflib.get_close_matches(name, list(allowed), n=1, cutoff=0.6)
    return f"; did you mean {close[0]}?" if close else ""


def check(text: str, known_names: Collection[str], phases: Collection[str] = ()) -> list[ExpressionProblem]:
    """Everything that is wrong with an expression; an empty list if nothing is.

    Parameters
    ----------
    text : str
        The expression.
    known_names : collection of str
        Signals of the run: the catalogue's and the outputs of its estimators.
    phases : collection of str
        Steps of the manoeuvre; the built-in phases need not be in it.
    """
    try:
        tree = parse(text)
    except ExpressionError as error:
        return error.problems
    known = known_names if isinstance(known_names, (set, frozenset, dict)) else set(known_names)
    shift = len(text) - len(text.lstrip())
    problems = [_name_problem(node, name, known, phases) for node, name in _uses(tree)]
    return [ExpressionProblem(p.column + shift, p.message) for p in problems if p is not None]


def _uses(tree: ast.expr) -> Iterator[tuple[ast.expr, str]]:
    """Every use of a name: plain names, and calls whose argument is a name."""
    match tree:
        case ast.Call(func=ast.Name(id=function)) if FUNCTIONS[function].takes != "values":
            yield tree, named_argument(tree) or ""
        case ast.Call():
            for argument in tree.args:
                yield from _uses(argument)
        case ast.Name() | ast.Attribute():
            yield tree, dotted_name(tree) or ""
        case _:
            for child in ast.iter_child_nodes(tree):
                if isinstance(child, ast.expr):
                    yield from _uses(child)


def _name_problem(
    node: ast.expr, name: str, known: Collection[str], phases: Collection[str]
) -> ExpressionProblem | None:
    if not isinstance(node, ast.Call):
        if name in known or name in METRICS or name in CONSTANTS:
            return None
        hint = nearest(name, [*known, *METRICS, *CONSTANTS])
        if name in FUNCTIONS:
            hint = f"; {name} is a function: {name_call(FUNCTIONS[name])}"
        elif all(name + suffix in known for suffix in WHEEL_SUFFIXES):
            hint = f"; write wheels({name}) for its four wheels or {name}_fl for one"
        return ExpressionProblem(node.col_offset, f"no signal or metric {name!r}{hint}")
    column = node.args[0].col_offset
    kind = FUNCTIONS[node.func.id].takes if isinstance(node.func, ast.Name) else "values"
    if kind == "phase" and name not in PHASES and name not in phases:
        return ExpressionProblem(column, f"no phase {name!r}{nearest(name, [*PHASES, *phases])}")
    if kind == "wheels" and not all(name + suffix in known for suffix in WHEEL_SUFFIXES):
        stems = {known_name[:-3] for known_name in known if known_name.endswith("_fl")}
        return ExpressionProblem(column, f"no signal {name!r} with a value per wheel{nearest(name, stems)}")
    if kind == "estimate":
        return _estimate_problem(name, column, known)
    return None


def _estimate_problem(name: str, column: int, known: Collection[str]) -> ExpressionProblem | None:
    from bench.verdict.truth import truth_of

    estimates = [known_name for known_name in known if "." in known_name]
    if name not in known:
        return ExpressionProblem(column, f"no estimate {name!r}{nearest(name, estimates)}")
    if truth_of(name) is None:
        return ExpressionProblem(column, f"the simulated car has no true value for {name!r}; write it: rmse({name}, …)")
    return None


def names_used(text: str) -> set[str]:
    """Signals and metrics that an expression names; for ``wheels(slip_ratio)`` the four signals."""
    found: set[str] = set()
    for node, name in _uses(parse(text)):
        kind = FUNCTIONS[node.func.id].takes if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""
        if kind == "wheels":
            found.update(name + suffix for suffix in WHEEL_SUFFIXES)
        elif kind != "phase" and name not in CONSTANTS:
            found.add(name)
    return found


def evaluate(text: str, data: "Assessment | Any", window: slice | str | None = None) -> "Value":
    """Value of an expression over a window of a run.

    Parameters
    ----------
    data : Assessment or RunArrays
        The run; an assessment keeps phases and metrics that several expressions use.
    window : slice or str, optional
        Rows, or the name of a phase; without it the whole run.

    Returns
    -------
    float, bool or ndarray
        A number or a truth value; four of them, shape (4,), if the expression is one per wheel; shape (n,) or (n, 4) if
        it has a value per row.

    Raises
    ------
    ExpressionError
        If the expression does not fit the run.
    bench.verdict.assessment.NoValueError
        If the run has no value for it (the phase does not occur, the car never stands).
    """
    from bench.verdict.evaluation import evaluate_tree

    return evaluate_tree(parse(text), text, data, window)
