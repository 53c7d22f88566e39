"""Draws docs/images/diagnosis_worn_pads.png, worn pads diagnosed: python docs/diagnosis_picture.py (needs chromium)."""

import tempfile
from pathlib import Path

from generate_case_studies import ROOT, pictured

PICTURE = ROOT / "docs" / "images" / "diagnosis_worn_pads.png"
HEIGHT = 1760
"""Pixels of the page down to the lowest row of the house of equations."""


def main() -> None:
    """Drive, diagnose against the nominal car, and draw the upper part of the page: charts, house and cause."""
    import bench
    from bench.diagnosis.diagnosing import find, write

    with tempfile.TemporaryDirectory() as folder:
        drive, result = Path(folder) / "worn_pads", Path(folder) / "diagnosis"
        bench.run("diagnosis/worn_pads", pacing="lockstep", out=drive)
        write(find([str(drive)], "ekf_car"), result)
        pictured(result, PICTURE, HEIGHT)
    print(PICTURE.relative_to(ROOT))


if __name__ == "__main__":
    main()
