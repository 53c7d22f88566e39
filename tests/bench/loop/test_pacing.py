"""Pacing: deadlines, catching up, and how late ticks are attributed."""

import time

import numpy as np

from bench.links.frame import EXTENDED, REMOTE, make_frame, new_frames
from bench.loop.bus_load import BusLoad
from bench.loop.pacing import CATCH_UP_TICKS, PERIOD_NS, LockstepPacer, RealtimePacer, TickTimes
from bench.loop.scheduling import plan_cores
from bench.loop.timing import summarise


def test_no_tick_begins_before_its_deadline() -> None:
    pacer = RealtimePacer(50)
    pacer.start()
    for n in range(50):
        pacer.wait(n)
        pacer.done(n)
    assert (pacer.times.lateness_ns >= 0).all()
    assert pacer.times.count == 50


def test_a_long_stall_is_skipped_and_counted() -> None:
    """20 ms in one tick: more than the five ticks that are caught up, so the time base moves by whole periods."""
    pacer = RealtimePacer(20)
    pacer.start()
    for n in range(20):
        pacer.wait(n)
        if n == 5:
            time.sleep(0.020)
        pacer.done(n)
    assert pacer.times.skipped >= 20 - CATCH_UP_TICKS
    assert pacer.times.lateness_ns[6] < PERIOD_NS


def test_lock_step_measures_no_lateness() -> None:
    pacer = LockstepPacer(10)
    pacer.start()
    pacer.wait(0)
    pacer.done(0)
    assert summarise(pacer.times)["late_ticks"] == 0


def test_late_ticks_are_ours_only_with_the_processor_time_to_show_for_it() -> None:
    us = 1000
    lateness = np.array([0, 0, 1500 * us, 0, 1500 * us, 0])
    cpu = np.array([100 * us, 2500 * us, 100 * us, 100 * us, 100 * us, 100 * us])
    times = TickTimes(lateness, cpu.copy(), cpu, 6)
    result = summarise(times)
    assert (result["late_ticks"], result["late_ticks_ours"], result["late_ticks_machine"]) == (2, 1, 1)


def test_a_delay_that_is_carried_over_stays_ours() -> None:
    """A tick of 3.6 ms of processor time makes the two after it late; the fourth is on time again."""
    us = 1000
    lateness = np.array([1200, 0, 2600, 1700, 800, 0, 1500]) * us
    cpu = np.array([100, 3600, 100, 100, 100, 100, 100]) * us
    result = summarise(TickTimes(lateness, cpu.copy(), cpu, 7))
    assert (result["late_ticks"], result["late_ticks_ours"], result["late_ticks_machine"]) == (4, 2, 2)


def test_the_loop_has_the_last_core_for_itself() -> None:
    plan = plan_cores({0, 1, 3})
    assert (plan.loop, plan.helpers, plan.shared) == ({3}, {0, 1}, False)
    assert plan_cores({2}).shared


def test_bus_load_of_one_frame_per_tick() -> None:
    """A standard frame of 8 bytes has 47 + 64 = 111 bits without stuff bits; 500 fit into 1 ms at 500 kbit/s."""
    load, none = BusLoad(), new_frames(1)
    frame = make_frame(0x120, bytes(8))
    values = [load.update(none, 0, frame, 1) for _ in range(150)]
    assert values[-1] == 111 / 500
    assert values[49] == 0.5 * 111 / 500  # half of the 100 ms window
    remote = make_frame(0x18FF0000, bytes(8), flags=EXTENDED | REMOTE)
    assert BusLoad().update(remote, 1, none, 0) == 67 / (500 * 100)
