"""Which equation is violated, on logs of a generator that shares no code with the diagnosis."""

import sys
from pathlib import Path

import pytest
from threadpoolctl import threadpool_limits

sys.path.insert(0, str(Path(__file__).parent / "data"))

from hidden_car import hidden_logs

from model_diagnosis.effects.catalogue import EFFECTS, effect
from model_diagnosis.evidence.base import fit_base
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.localisation import acts_on, lit, localise, place_remarks
from model_diagnosis.replay import Replay
from model_diagnosis.replay.disturbances import ALIKE
from model_diagnosis.result import ViolatedEquation

SIX = ("abs_stop", "accelerate_and_brake", "brake_in_turn", "coast", "gentle_stops", "sine_steer")
"""With fewer manoeuvres, or without effects that are off in every car, neighbours of the guilty equation are lit."""


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("seed", "hidden", "guilty"),
    [
        (101, ("wheel_brake_weak", -0.25, 2), "wheel torque rl"),
        (110, ("brake_pad_friction", -0.25, 0), ALIKE),
        (102, ("road_grade", 0.02, 0), "longitudinal force"),
        (103, ("gyro_offset", 0.008, 0), "sensor yaw_rate"),
        (105, None, None),
    ],
    ids=["brake of one wheel", "all pads", "grade", "offset of the gyroscope", "clean"],
)
def test_the_violated_equation_is_lit(
    seed: int, hidden: tuple[str, float, int] | None, guilty: str | None, tmp_path: Path
) -> None:
    vehicle, manoeuvres = hidden_logs(tmp_path, seed, SIX, hidden)
    replay = Replay(vehicle, manoeuvres, conditions=True)
    with threadpool_limits(1, user_api="blas"):  # as in a diagnosis
        base = fit_base(replay, Priors.of(replay.parameters))
        found = localise(replay, base, base.nothing.theta)
    violated = lit(found.by_innovations)
    assert violated[:1] == ([] if guilty is None else [guilty])
    assert set(found.by_equation_error) >= {"longitudinal force", "yaw moment", "wheel torque rl"}


def test_a_cause_that_stands_in_no_violated_equation_is_told() -> None:
    violations = {
        "sensor yaw_rate": ViolatedEquation(likelihood_ratio=80.0, error=0.005, unit="rad/s"),
        "wheel torque fl": ViolatedEquation(likelihood_ratio=5.0, error=3.0, unit="N m"),
    }
    assert place_remarks([effect("gyro_offset")], violations) == []
    (remark,) = place_remarks([effect("brake_pad_friction"), effect("gyro_scale")], violations)
    assert remark.startswith("brake_pad_friction acts on no equation")
    assert "sensor yaw_rate" in remark
    assert place_remarks([effect("brake_pad_friction")], {}) == []


def test_every_effect_stands_in_some_equation() -> None:
    rooms = (
        "longitudinal force",
        "lateral force",
        "yaw moment",
        "load transfer",
        "wheel torque fl",
        "hydraulics fl",
        ALIKE,
    )
    for one in EFFECTS:
        assert any(acts_on(one, room) for room in (*rooms, "sensor yaw_rate"))
    assert acts_on(effect("pressure_sensor_scale"), "wheel torque rr")
    assert acts_on(effect("brake_pad_friction"), ALIKE)
