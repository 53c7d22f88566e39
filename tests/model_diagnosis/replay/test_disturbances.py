"""Answers of the replay to errors of its equations against its answers to what such errors are."""

import numpy as np

from model_diagnosis.replay import Replay
from model_diagnosis.replay.disturbances import ALIKE, disturbance_answers
from signals.wheels import WHEELS

GENTLE = 0


def test_a_share_of_all_brake_torques_is_the_friction_of_the_pads(replay: Replay) -> None:
    """T_b = 2 mu r A p: so many percent of the pads' friction are as many of both axles' torques; more of it slows.

    What a torque lifts through the links of an axle is in the pads' answer only: loads differ, and wheels slip by it.
    Speed and acceleration are 2 and 3 % apart so, the speeds of front and rear wheels 16 and 4 %.
    """
    theta = np.zeros(len(replay.columns))
    pads = replay.columns.index("brake_pad_friction.factor")
    friction = replay.sensitivities(theta, [pads])[GENTLE][:, :, 0]
    found = disturbance_answers(replay, theta, GENTLE)[ALIKE]
    brakes = np.array([kind == "brake" for kind in found.kinds])
    torques = -np.sum(found.levels[brakes] * found.changes[:, :, brakes], axis=2)
    within = {"speed": 0.05, "longitudinal_acceleration": 0.05} | {f"wheel_speed_{wheel}": 0.2 for wheel in WHEELS}
    for name, share in within.items():
        k = replay.signals(GENTLE).index(name)
        difference = np.sqrt(np.mean((torques[:, k] - friction[:, k]) ** 2))
        assert difference < share * np.sqrt(np.mean(friction[:, k] ** 2)), name
