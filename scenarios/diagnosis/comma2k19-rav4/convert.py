"""Turns a segment of comma2k19 (one npz) into the logs that a user would have: a candump log and two tables.

python convert.py segment40.npz FOLDER
"""

import csv
import sys
from pathlib import Path

import numpy as np

KINEMATICS, WHEEL_SPEEDS = 0x24, 0xAA
RADIANS_PER_DEGREE = np.pi / 180.0


def write_can(archive: np.lib.npyio.NpzFile, path: Path) -> None:
    """Frames of the kinematics and the wheel speeds, as candump writes them."""
    wanted = np.isin(archive["can_id"], (KINEMATICS, WHEEL_SPEEDS))
    with path.open("w") as file:
        for time, identifier, data in zip(
            archive["can_t"][wanted], archive["can_id"][wanted], archive["can_data"][wanted], strict=True
        ):
            file.write(f"({time:.6f}) can0 {identifier:03X}#{bytes(data).hex().upper()}\n")


def write_table(path: Path, names: list[str], columns: list[np.ndarray]) -> None:
    """A table with one header line."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        writer.writerows([f"{value:.6f}" for value in row] for row in zip(*columns, strict=True))


def main(source: Path, folder: Path) -> None:
    """Write ``can.log``, ``steering.csv`` and ``pose.csv``; all clocks are the recorder's."""
    folder.mkdir(parents=True, exist_ok=True)
    archive = np.load(source, allow_pickle=False)
    write_can(archive, folder / "can.log")
    write_table(
        folder / "steering.csv",
        ["t", "steering_angle"],
        [archive["steering_angle_t"], archive["steering_angle_value"].ravel()],
    )
    speed = np.linalg.norm(archive["pose_frame_velocities"][:, :3], axis=1)
    write_table(folder / "pose.csv", ["t", "pose_speed"], [archive["pose_frame_times"], speed])


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
