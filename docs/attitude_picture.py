"""Draws docs/images/attitude_bank.png from a ride of the reference two-wheeler: python docs/attitude_picture.py."""

import sys
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

SEED, SECONDS, ONSET_S = 1, 120.0, 30.0
STEPPED = slice(24, None, 5)
"""Rows in which the filters step."""


def main() -> None:
    """Roll error, estimated offset and weights of form 2C with 100 mG on the lateral accelerometer."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    from bench.report.plot_style import plot_style
    from estimators import create
    from vehicle_model.reference.two_wheeler import MILLI_G, SAMPLE_S, measure, random_ride
    from vehicle_model.vehicle_file import load_vehicle

    vehicle = load_vehicle("motorcycle_230kg")
    ride = random_ride(vehicle, SEED, seconds=SECONDS, sloped=True)
    columns = measure(ride, SEED, offsets={"lateral_acceleration": 100 * MILLI_G}, onset_s=ONSET_S)
    columns["abs_active"] = np.zeros(len(ride.time))
    names = {"attitude_single": "one filter", "attitude_bank": "bank", "attitude_augmented": "extra state"}
    colours = dict(zip(names, ("#c2410c", "#0b62c4", "#0f7b4f"), strict=True))
    found: dict[str, Any] = {}
    for name in names:
        filter_ = create(name, vehicle.numbers(), {"form": "2C"}, SAMPLE_S)
        values = filter_.replay(columns)[STEPPED]
        found[name] = {signal.name.partition(".")[2]: values[:, k] for k, signal in enumerate(filter_.outputs)}
    time = ride.time[STEPPED]
    late = np.interp(time - found["attitude_bank"]["roll_angle_age"], ride.time, ride.roll_angle)
    with matplotlib.rc_context(plot_style()):
        figure, axes = pyplot.subplots(4, 1, figsize=(9.0, 8.2), layout="constrained", sharex=True)
        axes[0].plot(ride.time, np.rad2deg(ride.roll_angle), color="#14181f")
        axes[0].set_ylabel("roll angle, deg")
        for name, label in names.items():
            error = np.rad2deg(found[name]["roll_angle"] - late)
            axes[1].plot(time, error, color=colours[name], label=label)
        axes[1].set_ylabel("error of roll, deg")
        axes[1].set_ylim(-5.0, 5.0)
        axes[1].legend(ncols=3, loc="lower left")
        axes[2].plot(ride.time, 100.0 * (ride.time >= ONSET_S), color="#14181f", linestyle=":", label="truth")
        for name in ("attitude_bank", "attitude_augmented"):
            axes[2].plot(time, found[name]["virtual_offset"] / MILLI_G, color=colours[name], label=names[name])
        axes[2].set_ylabel("offset of G_y, mG")
        axes[2].legend(ncols=3, loc="upper left")
        bank = found["attitude_bank"]
        axes[3].plot(time, bank["zero_weight"], color="#515b6a", label="weight of the filter told 0 mG")
        axes[3].plot(time, bank["largest_weight"], color="#f0b23e", label="largest weight")
        axes[3].set(ylabel="weight", xlabel="time, s", ylim=(0.0, 1.0))
        axes[3].legend(ncols=2, loc="lower left")
        figure.savefig(ROOT / "docs" / "images" / "attitude_bank.png", dpi=110)
    print("docs/images/attitude_bank.png")


if __name__ == "__main__":
    main()
