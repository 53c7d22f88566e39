"""Conditions: what files may say and what it means inside the tick."""

import pytest
from pydantic import ValidationError

from signals.catalogue import Signal
from signals.conditions import Condition
from signals.errors import FieldErrors, FileFaults
from signals.vector import SignalVector
from signals.yaml_files import parse_yaml, validate

PHASES = ("accelerate", "release", "brake")
ESTIMATE = Signal("friction_ekf.speed", "m/s", "vehicle speed", "estimators", "km/h", 3.6)


def holds(condition: dict[str, object], *, armed_s: float = 0.0, **signals: float) -> bool:
    vector = SignalVector([ESTIMATE])
    for name, value in signals.items():
        vector.values[vector.index(name.replace("__", "."))] = value
    return Condition.model_validate(condition).compile(vector, PHASES)(armed_s)


@pytest.mark.parametrize(
    ("condition", "signals", "expected"),
    [
        ({"signal": "speed", "below": "5 km/h"}, {"speed": 1.38}, True),  # 5 km/h = 1.389 m/s
        ({"signal": "speed", "below": "5 km/h"}, {"speed": 1.39}, False),
        ({"signal": "speed", "above": "110 km/h"}, {"speed": 30.56}, True),  # 110 km/h = 30.556 m/s
        ({"signal": "speed", "above": 3, "below": 5}, {"speed": 4.0}, True),
        ({"signal": "speed", "above": 3, "below": 5}, {"speed": 5.0}, False),
        ({"signal": "abs_active", "equals": 1}, {"abs_active": 1.0}, True),
        ({"signal": "true_master_pressure", "above": "120 bar"}, {"true_master_pressure": 1.21e7}, True),
        ({"signal": "friction_ekf.speed", "below": "36 km/h"}, {"friction_ekf__speed": 9.99}, True),
        ({"time": "2 s"}, {"time": 1.999}, False),
        ({"time": "2 s"}, {"time": 2.0}, True),
        ({"distance": "50 m"}, {"distance": 50.0}, True),
        ({"phase": "brake"}, {"manoeuvre_phase": 2.0}, True),
        ({"phase": "brake"}, {"manoeuvre_phase": 1.0}, False),
        ({"not": {"phase": "brake"}}, {"manoeuvre_phase": 1.0}, True),
        ({"all": [{"phase": "brake"}, {"time": 1}]}, {"manoeuvre_phase": 2.0, "time": 0.5}, False),
        ({"any": [{"phase": "brake"}, {"time": 1}]}, {"manoeuvre_phase": 2.0, "time": 0.5}, True),
    ],
)
def test_kinds(condition: dict[str, object], signals: dict[str, float], expected: bool) -> None:
    assert holds(condition, **signals) is expected


def test_after_counts_whole_ticks_since_its_owner_was_armed() -> None:
    # 1.2 − 0.7 is 0.49999999999999994 in floating point
    assert holds({"after": "0.5 s"}, armed_s=0.7, time=1.2)
    assert not holds({"after": "0.5 s"}, armed_s=0.7, time=1.199)


def test_lasting_starts_again_after_a_break() -> None:
    vector = SignalVector()
    condition = Condition.model_validate({"signal": "speed", "below": 1, "lasting": "3 ms"})
    check = condition.compile(vector, ())
    seen = []
    for tick, speed in enumerate((0.5, 0.5, 2.0, 0.5, 0.5, 0.5, 0.5, 0.5)):
        vector.values[vector.index("time")] = tick * 1e-3
        vector.values[vector.index("speed")] = speed
        seen.append(check(0.0))
    assert seen == [False, False, False, False, False, False, True, True]


def test_lasting_below_any_sees_every_tick() -> None:
    vector = SignalVector()
    check = Condition.model_validate(
        {"any": [{"signal": "speed", "above": 10}, {"signal": "speed", "above": 1, "lasting": "2 ms"}]}
    ).compile(vector, ())
    seen = []
    for tick, speed in enumerate((20.0, 20.0, 5.0)):
        vector.values[vector.index("time")] = tick * 1e-3
        vector.values[vector.index("speed")] = speed
        seen.append(check(0.0))
    assert seen == [True, True, True]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("signal: sped\nbelow: 1", "x.yaml:1:9  signal: unknown signal\n  found 'sped'; did you mean speed?"),
        ("signal: speed\nbelow: 5 bar", "x.yaml:2:8  below: wrong dimension, a quantity in Pa"),
        ("signal: speed", "x.yaml:1:9  signal: a signal needs a threshold"),
        ("below: 3", "x.yaml:1:1  a condition has exactly one kind\n  found none of them"),
        ("time: 1\nafter: 2", "found 2 kinds (time, after)"),
        ("time: 1\nbelow: 2", "x.yaml:2:8  below: a threshold needs a signal"),
        ("time: -1", "x.yaml:1:7  time: out of range\n  found -1; allowed: at least 0 s"),
        ("any: []", "x.yaml:1:6  any: too short: at least 1 needed"),
        ("all:\n- phase: brake\n- sinal: speed", "x.yaml:3:3  all[1].sinal: unknown field"),
        ("not: {time: 1 kg}", "x.yaml:1:13  not.time: wrong dimension"),
    ],
)
def test_faults_of_a_file(text: str, expected: str) -> None:
    with pytest.raises(FileFaults) as caught:
        validate(parse_yaml(text, "x.yaml"), Condition)
    assert expected in caught.value.message


def test_what_does_not_fit_the_run() -> None:
    condition = Condition.model_validate(
        {"all": [{"phase": "brak"}, {"signal": "friction_ekf.sped", "below": 1}, {"time": 1}]}
    )
    faults = condition.faults({"speed": "m/s", "friction_ekf.speed": "m/s"}, PHASES)
    assert [(fault.at, fault.nearest) for fault in faults] == [
        (("all", 0, "phase"), "brake"),
        (("all", 1, "signal"), "friction_ekf.speed"),
    ]
    with pytest.raises(FieldErrors):
        condition.compile(SignalVector(), PHASES)


def test_dumped_conditions_read_back_the_same() -> None:
    condition = Condition.model_validate({"not": {"any": [{"signal": "speed", "below": "5 km/h"}, {"after": "20 ms"}]}})
    dumped = condition.model_dump(exclude_none=True)
    assert dumped == {"not": {"any": [{"signal": "speed", "below": pytest.approx(5 / 3.6)}, {"after": 0.02}]}}
    assert Condition.model_validate(dumped) == condition


def test_an_estimators_threshold_of_the_wrong_dimension_is_found_with_its_unit() -> None:
    condition = Condition.model_validate({"signal": "friction_ekf.speed", "below": "5 bar"})
    (fault,) = condition.faults({"friction_ekf.speed": "m/s"}, ())
    assert fault.at == ("below",)


def test_a_plain_signal_has_to_be_in_the_catalogue() -> None:
    with pytest.raises(ValidationError):
        Condition.model_validate({"signal": "nothing", "below": 1})
