"""Short run of the main benchmarks, for CI: python -m benchmarks.smoke. Prints figures and judges nothing."""

import tempfile
from pathlib import Path

from benchmarks import can_bits_speed, closed_loop_speed, plant_speed, real_time_lateness

PLANT_TICKS = 5000
SLICE_S = 3.0
CAN_FRAMES = 100_000


def main() -> None:
    """Plant, closed loop, real-time loop and CAN bits, a few seconds each."""
    seconds = plant_speed.best_time("ekf_car", PLANT_TICKS)
    print(f"plant alone: {PLANT_TICKS * 1e-3 / seconds:.0f} x real time (goal {plant_speed.GOAL:.0f})")
    factors = closed_loop_speed.real_time_factor("stops/dry", 3)
    print(f"closed loop: {max(factors):.1f} x real time (goal {closed_loop_speed.GOAL:.0f})")
    with tempfile.TemporaryDirectory() as folder:
        measured = real_time_lateness.alternate(Path(folder), 1, SLICE_S, fifo=True, dashboard=False)
    for name, parts in measured.items():
        real_time_lateness.show(name, real_time_lateness.joined(parts))
    can_bits_speed.show(CAN_FRAMES)


if __name__ == "__main__":
    main()
