"""Time of a whole diagnosis: six manoeuvres of a car with a hidden effect, the whole catalogue.

    python -m benchmarks.diagnosis_speed [--seed 70] [--cases 3] [--family single]

Cases come from the generator of the challenge, with held-out manoeuvres as there. Prints the seconds of each step by
the clock, the whole by the clock and by the processors, and before that what its replays cost: one car, eight side by
side, all manoeuvres, sensitivities of all columns. The first case is diagnosed twice, and its first time, with what has
to be compiled and loaded, is not counted.
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from bench.challenge.answering import answer_case, logs_in
from bench.challenge.generator import generate
from model_diagnosis.data import check_data, read_manoeuvres
from model_diagnosis.replay import Replay
from signals.measured import load_channel_map
from vehicle_model import load_vehicle

GOAL_S, MOST_S = 60.0, 120.0
REPEATS = 5


def best_ms(function: Callable[[int], object]) -> float:
    """Shortest of some calls, each with another number so that nothing is known of it yet [ms]."""
    times = []
    for number in range(REPEATS + 1):
        began = time.perf_counter()
        function(number)
        times.append(time.perf_counter() - began)
    return 1e3 * min(times[1:])


def show_replays(case: Path) -> None:
    """What the parts of a diagnosis cost that it is made of."""
    car = load_vehicle(case / "vehicle.yaml")
    read = read_manoeuvres(logs_in(case / "logs"), load_channel_map(case / "channels.yaml"), car)
    _, manoeuvres = check_data(read, car, Replay)
    replay = Replay(car, manoeuvres, conditions=True)
    generator = np.random.default_rng(0)
    drawn = [
        np.clip(
            [0.3 * generator.normal() * one.effect_std for one in replay.parameters],
            [one.low for one in replay.parameters],
            [one.high for one in replay.parameters],
        )
        for _ in range(REPEATS + 1)
    ]
    longest = max(range(len(manoeuvres)), key=lambda m: manoeuvres[m].samples)
    samples = [one.samples for one in manoeuvres]
    print(f"replay of {len(replay.columns)} columns, manoeuvres of {samples} samples of 10 ms")
    print(
        f"  one prediction of {samples[longest]} samples: {best_ms(lambda k: replay.predict(drawn[k], longest)):.1f} ms"
    )
    print(f"  residuals of all manoeuvres: {best_ms(lambda k: replay.residuals(drawn[k])):.1f} ms")
    print(f"  sensitivities of all columns: {best_ms(lambda k: replay.sensitivities(drawn[k])):.0f} ms")


def show(case: Path) -> float:
    """Diagnose a case and print its seconds; returns those of the whole."""
    began, used = time.perf_counter(), time.process_time()
    answer = answer_case(case)
    wall, processors = time.perf_counter() - began, time.process_time() - used
    if "error" in answer:
        print(f"{case.name}: refused: {answer['error']}")
        return wall
    steps = ", ".join(f"{name} {seconds:.1f}" for name, seconds in answer["diagnosis"]["timing_s"].items())
    print(f"{case.name}: {wall:.1f} s, processors {processors:.1f} s ({steps}): {answer['diagnosis']['verdict']}")
    return wall


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=70)
    parser.add_argument("--cases", type=int, default=3)
    parser.add_argument("--family", default="single")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        cases = generate(
            Path(folder) / "cases",
            Path(folder) / "sealed",
            seed=given.seed,
            count=given.cases,
            family=given.family,
            generator="first",
        )
        answer_case(cases[0])
        show_replays(cases[0])
        times = [show(case) for case in cases]
    print(f"median {np.median(times):.1f} s, longest {max(times):.1f} s (goal {GOAL_S:.0f} s, at most {MOST_S:.0f} s)")


if __name__ == "__main__":
    main()
