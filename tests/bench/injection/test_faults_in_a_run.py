"""Faults in a scenario: in lock-step by seed, on the ECU's side of the tap, recorded; none changes nothing."""

import numpy as np
import pytest

from bench.links.frame import ERROR
from bench.loop.runs import run_in_memory
from bench.scenario.resolution import resolve

SHORT = """
vehicle: ekf_car
pacing: lockstep
ecu: {kind: inprocess}
road: {name: dry asphalt, surface: dry_asphalt}
initial_speed: 60 km/h
manoeuvre:
  steps:
    - name: hold
      hold_speed: {speed: 60 km/h}
      until: {time: 0.2 s}
    - name: brake
      brake: {pedal_force: 500 N, ramp: 4 kN/s}
      until: {time: 0.8 s}
time_limit: 1 s
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Run the short stop with some faults; equal texts are run once."""
    folder, known = tmp_path_factory.mktemp("runs"), {}

    def go(faults: str = "", seed: int = 1, again: int = 0):
        key = (faults, seed, again)
        if key not in known:
            path = folder / f"run_{len(known)}.yaml"
            path.write_text(SHORT + (f"faults:\n{faults}" if faults else ""))
            known[key] = run_in_memory(resolve(path, seed=seed))
        return known[key]

    return go


MOTION = ("speed", "wheel_speed_fl", "valve_inlet_fl", "yaw_rate", "brake_pressure_fl", "age_wheel_speed")
ARMED = "  - {trigger: {id: 0x7FF}, disturbance: {flip: {at: crc.1}}}\n"
FLIPPED = "  - {trigger: {id: 0x120, probability: 0.5}, disturbance: {flip: {at: data.12}}}\n"
LOST = """
  - name: lost
    trigger: {id: 0x120, direction: to_ecu, phase: brake}
    disturbance: {drop: {}}
    duration: 0.1 s
"""


def test_a_fault_that_never_acts_leaves_the_run_bit_identical(run) -> None:
    plain, armed = run(), run(ARMED)
    for name in plain.data.names:
        assert np.array_equal(plain.data.array(name), armed.data.array(name), equal_nan=True), name
    assert (plain.frames["data"] == armed.frames["data"]).all()


def test_the_seed_reproduces_the_run_bit_for_bit(run) -> None:
    first, second, other = run(FLIPPED), run(FLIPPED, again=1), run(FLIPPED, seed=2)
    for name in first.data.names:
        assert np.array_equal(first.data.array(name), second.data.array(name), equal_nan=True), name
    assert first.data.timing["injector"] == second.data.timing["injector"]
    assert first.data.timing["injector"] != other.data.timing["injector"]


def test_the_protocol_corrects_flipped_bits(run) -> None:
    """No frame is lost, some valve frames are a tick late by arbitration; error frames on both sides, counters move."""
    flipped, plain = run(FLIPPED), run()
    assert flipped.data.array("injector.frames_lost").max() == 0
    assert np.abs(flipped.data.array("speed") - plain.data.array("speed")).max() < 0.1
    # +8 for the error, then -1 for each of the three frames that the bench sends in such a tick
    assert flipped.data.array("injector.transmit_errors_bench").max() == 8 - 3
    errors = flipped.frames[(flipped.frames["flags"] & ERROR) != 0]
    assert {0, 1} == set(errors["channel"].tolist())
    counts = flipped.data.timing["injector"]["counts"]
    assert counts["error_frames"] == flipped.data.array("injector.error_frames").max() > 0


@pytest.mark.acceptance("F-37")
def test_the_tap_is_on_the_ecu_side_of_the_injector(run) -> None:
    """Frames that are lost on the way make the tap's signals old; the bench itself sent them."""
    lost, plain = run(LOST), run()
    age = lost.data.array("age_wheel_speed")
    acting = lost.data.array("injector.lost") > 0.5
    assert acting.sum() == pytest.approx(100, abs=1)
    assert age.max() == pytest.approx(0.1, abs=0.006)
    assert plain.data.array("age_wheel_speed").max() < 0.006
    sent = lost.frames[(lost.frames["identifier"] == 0x120) & (lost.frames["channel"] == 0)]
    assert len(sent) == np.count_nonzero(plain.frames["identifier"] == 0x120)
    summary = lost.data.timing["injector"]["faults"][0]
    assert (summary["kind"], summary["e2e"], summary["realised_as"]) == ("drop", "loss", "frame_gateway")
    assert summary["frames"] == 20
    assert summary["first_s"] == pytest.approx(0.2, abs=0.006)
    assert lost.data.array("faults_active").max() == 1


@pytest.mark.acceptance("F-36")
def test_a_missing_message_is_a_fault_of_the_ecu(run) -> None:
    """Friction document, acceptance 36: the ECU sees that its inputs are missing."""
    silent = run("  - {trigger: {phase: brake, direction: to_ecu}, disturbance: {drop: {}}}\n")
    assert silent.data.array("ecu_fault_code").max() >= 1
    assert run().data.array("ecu_fault_code").max() == 0


def test_the_documented_identifier_example_on_the_bench(run) -> None:
    """5.2.4: the ECU's 0x71D becomes 0x05D, which the bench does not know."""
    rewritten = run("  - {trigger: {id: 0x71D}, disturbance: {rewrite_id: {to: 0x05D}}}\n")
    bench_side = rewritten.frames[rewritten.frames["channel"] == 0]
    assert np.count_nonzero(bench_side["identifier"] == 0x71D) == 0
    assert np.count_nonzero(bench_side["identifier"] == 0x05D) > 70
    assert np.count_nonzero(rewritten.frames[rewritten.frames["channel"] == 1]["identifier"] == 0x71D) > 70
