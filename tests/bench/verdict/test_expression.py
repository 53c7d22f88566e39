"""Language of the criteria: what it accepts, what it says about the rest, and what it computes."""

import subprocess
import sys

import numpy as np
import pytest
from synthetic_run import BRAKE_AT, DECELERATION, FRONT_SLIP, REAR_SLIP, SPEED, stop

from bench.verdict.assessment import Assessment, NoValueError
from bench.verdict.evaluation import _BINARY, _COMPARE
from bench.verdict.expression import ExpressionError, check, evaluate, names_used, parse
from bench.verdict.functions import IMPLEMENTATIONS
from bench.verdict.units import unit_of
from bench.verdict.vocabulary import FUNCTIONS, METRICS

KNOWN = {"speed", "time", "brake_pressure_fl", "brake_pressure_fr", "brake_pressure_rl", "brake_pressure_rr"}
KNOWN |= {"friction_ekf.speed", "friction_ekf.innovation"}


@pytest.fixture(scope="module")
def run() -> Assessment:
    return Assessment(stop())


@pytest.mark.parametrize(
    ("text", "column", "part"),
    [
        ("max(brake_presure_fl)", 4, "did you mean brake_pressure_fl?"),
        ("speed > 5 km/h", 8, "write 1.38889"),
        ("__import__('os')", 0, "no function '__import__'"),
        ("speed.__class__", 0, "no signal or metric 'speed.__class__'"),
        ("(speed).real()", 0, "only the functions"),
        ("[s for s in speed]", 0, "ListComp is not part of the language"),
        ("lambda: 1", 0, "Lambda is not part of the language"),
        ("speed[0]", 0, "Subscript is not part of the language"),
        ("speed > 5 & time > 1", 8, "allowed: and, or"),
        ("speed ^ 2", 0, "a power is written **"),
        ("speed = 5", 6, "not an expression"),
        ("", 0, "empty text"),
        ("percentile(speed)", 0, "percentile(x, p)"),
        ("max(speed, where=time)", 0, "found 2 arguments"),
        ("duration(brakig)", 9, "no signal or metric 'brakig'"),
        ("start(brakin)", 6, "did you mean braking?"),
        ("wheels(brake_presure)", 7, "did you mean brake_pressure?"),
        ("brake_pressure", 0, "write wheels(brake_pressure)"),
        ("max + 1", 0, "max is a function: max(x or x, y, …)"),
        ("estimator_error(friction_ekf.sped)", 16, "did you mean friction_ekf.speed?"),
        ("estimator_error(friction_ekf.innovation)", 16, "no true value"),
        ("'text'", 0, "a text stands only where a phase is named"),
        ("speed if time else 0", 0, "IfExp is not part of the language"),
        ("9**9**9**9 < " + "1" * 2000, 2000, "longer than"),
        ("(" * 300 + "1" + ")" * 300, 200, "not an expression"),
    ],
)
def test_names_the_place_and_what_is_allowed(text: str, column: int, part: str) -> None:
    problems = check(text, KNOWN, ("hold",))
    assert problems, text
    assert problems[0].column == column
    assert part in problems[0].message


def test_finds_all_unknown_names_at_once() -> None:
    problems = check("  sped + max(tme) > start('hold')", KNOWN, ("hold",))
    assert [(p.column, p.message.split(";")[1].strip()) for p in problems] == [
        (2, "did you mean speed?"),
        (13, "did you mean time?"),
    ]


@pytest.mark.parametrize(
    "text",
    [
        "stopping_distance",
        "max(abs(speed)) <= 3.5 and not any(speed < 0)",
        "rmse(friction_ekf.speed, speed)",
        "estimator_error(friction_ekf.speed)",
        "start('hold') < 1",
        "first_time(speed < 5) - start(brake)",
        "max(wheels(brake_pressure)) / 1e5",
        "2 * pi * g",
    ],
)
def test_accepts_the_language(text: str) -> None:
    assert check(text, KNOWN, ("hold",)) == []


def test_tables_and_implementations_agree() -> None:
    from bench.verdict import metrics

    assert set(IMPLEMENTATIONS) == {name for name, function in FUNCTIONS.items() if function.takes == "values"}
    assert all(callable(getattr(metrics, name)) for name in METRICS)
    assert not set(FUNCTIONS) & set(METRICS)
    assert len(_BINARY) == 6
    assert len(_COMPARE) == 6


@pytest.mark.parametrize(
    ("text", "phase", "expected"),
    [
        # closed forms of the constant-deceleration stop: t = v/a, s = v²/2a
        ("max(speed)", None, SPEED),
        ("first_time(speed < 5)", None, BRAKE_AT + (SPEED - 5) / DECELERATION + 1e-3),
        ("last_time(speed >= 5)", None, BRAKE_AT + (SPEED - 5) / DECELERATION),
        ("integral(speed)", None, SPEED * BRAKE_AT + SPEED**2 / (2 * DECELERATION)),
        ("min(derivative(speed))", None, -DECELERATION),
        ("at(speed, 1.5)", None, SPEED - 0.5 * DECELERATION),
        ("at(speed, start(stop) + 1)", None, SPEED - DECELERATION),
        ("first(speed)", "stop", SPEED),
        ("last(speed)", None, 0.0),
        ("start('brake')", None, BRAKE_AT),
        ("end(hold)", None, BRAKE_AT - 1e-3),
        ("duration(speed > 0.5 * 25 + 0.504)", None, BRAKE_AT + 1.5),
        ("longest(speed > 13.004)", "stop", 1.5),
        ("share(slip_ratio_fl < -0.1)", "brake", 1.0),
        ("mean(abs(wheels(slip_ratio)))", "braking", (FRONT_SLIP + REAR_SLIP) / 2),
        ("mean(front(slip_ratio) - rear(slip_ratio))", "braking", -FRONT_SLIP + REAR_SLIP),
        ("count_rising(true_yaw_rate > 0.05)", None, 5),
        ("max(longest(abs(wheels(slip_ratio)) > 0.1 and speed > 13.004))", None, 1.5),
        ("rms(true_yaw_rate)", "hold", 0.1 / np.sqrt(2)),
        ("percentile(speed, 50)", "hold", SPEED),
        ("max(clip(speed, 0, 10))", None, 10.0),
        ("mean(where(speed > 100, 1, 2))", None, 2.0),
        ("min(select(speed, time < 1.5))", None, SPEED - 0.499 * DECELERATION),
        ("max(in_phase(hold) * time)", None, BRAKE_AT - 1e-3),
        ("rmse(speed, speed + 3)", None, 3.0),
        ("std(speed)", "hold", 0.0),
        ("max(moving_mean(speed, 0.1))", None, SPEED),
        ("last(moving_mean(time, 0.01)) - last(time)", None, -0.0045),
        ("2 * 3 ** 2 - 7 % 4 / 2", None, 16.5),
        ("hypot(3, 4) + sign(-2) + sqrt(9) + sin(0) + cos(0) + tan(0)", None, 8.0),
        ("max(3, min(1, 2), 2)", None, 3.0),
    ],
)
def test_computes(run: Assessment, text: str, phase: str | None, expected: float) -> None:
    assert evaluate(text, run, phase) == pytest.approx(expected, abs=2e-6, rel=1e-6)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0 < max(speed) <= 25", True),
        ("any(speed > 24) and all(speed < 26)", True),
        ("not any(speed > 24)", False),
        ("first_time(speed > 99) < 5", False),
    ],
)
def test_conditions_are_truth_values(run: Assessment, text: str, expected: bool) -> None:
    assert evaluate(text, run) is expected


def test_a_value_per_wheel_has_four(run: Assessment) -> None:
    value = evaluate("duration(abs(wheels(slip_ratio)) > 0.1)", run)
    assert isinstance(value, np.ndarray)
    # the sample at the brake start still has no loss of speed but slips
    assert value == pytest.approx([SPEED / DECELERATION] * 2 + [0.0] * 2, abs=2e-3)


def test_never_is_infinite(run: Assessment) -> None:
    assert evaluate("first_time(speed > 99)", run) == np.inf
    assert evaluate("last_time(speed > 99)", run) == -np.inf


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("max(select(speed, speed > 99))", "no sample is left"),
        ("at(speed, 99)", "outside the phase"),
    ],
)
def test_says_why_there_is_no_value(run: Assessment, text: str, part: str) -> None:
    with pytest.raises(NoValueError, match=part):
        evaluate(text, run)


@pytest.mark.parametrize(
    "text", ["max(brake_pressure_fl)", "longest(select(speed, speed > 1) > 2)", "percentile(speed, 101)"]
)
def test_an_expression_that_does_not_fit_the_run_is_an_error(run: Assessment, text: str) -> None:
    with pytest.raises(ExpressionError):
        evaluate(text, run)


def test_the_syntax_tree_refuses_what_ast_would_allow() -> None:
    with pytest.raises(ExpressionError):
        parse("().__class__.__bases__")


def test_names_used() -> None:
    text = "max(wheels(slip_ratio)) + stopping_distance + friction_ekf.speed * pi - start(brake)"
    expected = {f"slip_ratio_{w}" for w in ("fl", "fr", "rl", "rr")} | {"stopping_distance", "friction_ekf.speed"}
    assert names_used(text) == expected


UNITS = {"speed": "m/s", "time": "s", "force": "N", "wheel_speed_fl": "rad/s", "torque": "N m"}


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("max(abs(speed))", "m/s"),
        ("integral(speed)", "m"),
        ("derivative(speed)", "m/s^2"),
        ("speed * force", "W"),
        ("torque / force", "m"),
        ("force * force", "m^2 kg^2 s^-4"),
        ("0.33 * wheel_speed_fl", None),
        ("first_time(speed < 5)", "s"),
        ("stopping_distance", "m"),
        ("share(speed > 1)", "1"),
        ("speed + 3", "m/s"),
        ("wheels(wheel_speed)", "rad/s"),
    ],
)
def test_units_follow_from_signals(text: str, unit: str | None) -> None:
    assert unit_of(text, UNITS) == unit


@pytest.mark.parametrize("text", ["speed + force", "max(speed, force)", "speed < force", "rmse(speed, time)"])
def test_mixed_units_are_refused(text: str) -> None:
    with pytest.raises(ExpressionError, match="allowed: one unit"):
        unit_of(text, UNITS)


def test_checking_needs_no_heavy_library() -> None:
    code = (
        "import sys; from bench.verdict.expression import check; import bench.verdict.criteria_file;"
        "assert not check('max(speed) + estimator_error(friction_ekf.speed)', {'speed', 'friction_ekf.speed'});"
        "found = {'numpy', 'scipy', 'numba', 'asammdf', 'can', 'matplotlib', 'cantools'} & set(sys.modules);"
        "sys.exit(', '.join(sorted(found)) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
