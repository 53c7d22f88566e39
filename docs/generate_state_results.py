"""Write docs/estimators_state_results.md from docs/traceability.csv: ``python docs/generate_state_results.py``."""

import csv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "estimators_state_results.md"

HEAD = """# The vehicle-state observers over 20 runs

Made by `python docs/generate_state_results.py` from [traceability.csv](traceability.csv), whose values the tests of
`tests/acceptance/test_state_document*.py` wrote: means over the seeds 9000–9019 of the sensors' noise, on the
document's planar car, in tables of the form of its sections 4.2 to 4.4. Behind the stroke is the document's own figure,
of its road tests. Percentages are root mean squared errors over the mean magnitude; for the slaloms those over the mean
of the signal itself, as the document prints the formula, stand beside: a slalom's mean is nearly zero. How the runs are
made, and what the fits lack: [vehicle state](models/vehicle_state.md).
"""

# printed rows: a_y, yaw rate, slip angle front, rear (the worse wheel), least R^2 (4.2)
SLALOMS = {
    "wet_basalt": ("wet basalt", (11.1, 2.8, 9.6, 14.0), 0.90, "45–66 %"),
    "ice": ("ice", (16.4, 5.1, 15.6, 18.0), 0.91, "50–63 %"),
    "dry_asphalt": ("dry asphalt", (11.2, 2.1, 11.1, 14.1), 0.96, "55–76.5 %"),
}
LAUNCHES = {"V-43": ("ice", 14.1, 0.95, "80 %"), "V-44": ("icy_snow", 9.3, 2.1, "71.2 %"), "V-45": ("", 11.8, 5.1, "–")}
HILLS = {4: (5.5, 1), 6: (5.16, 3), 8: (6.2, 5), 10: (0.8, 10)}
QUANTITIES = ("a_y", "yaw_rate", "front", "rear")


def measured() -> dict[tuple[str, str], float]:
    """Values of the state document's rows by id and quantity; of several cases the largest."""
    found = {}
    with (ROOT / "docs" / "traceability.csv").open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            for entry in filter(None, row["measured"].split("; ")) if row["id"].startswith("V-") else ():
                quantity, _, value = entry.rpartition(" = ")
                found[row["id"], quantity] = float(value.partition(" (")[0].rpartition("... ")[2])
    return found


def _table(head: str, rows: list[str]) -> str:
    return "\n".join([head, "|---" * (head.count("|") - 1) + "|", *rows]) + "\n"


def _slaloms(found: dict[tuple[str, str], float]) -> str:
    rows, fits = [], []
    for key, (surface, printed, quality, share) in SLALOMS.items():
        own = [found["V-25", f"{key}: {name} %"] for name in QUANTITIES]
        plain = [found["V-54", f"{key}: {name} % of mean x"] for name in QUANTITIES]
        cells = [f"{a:.1f} / {b:g} ({c:.0f})" for a, b, c in zip(own, printed, plain, strict=True)]
        rows.append(f"| {surface} | " + " | ".join(cells) + " |")
        median, largest, r_squared, error = (
            found["V-34", f"{key}: {name}"]
            for name in ("share of the true peak, median", "share of the true peak, largest", "R^2, smallest",
                         "median error of D %")
        )  # fmt: skip
        shares = f"{100 * median:.0f} %, at most {100 * largest:.1f} %"
        fits.append(f"| {surface} | {shares} / {share} | {r_squared:.2f} / {quality:.2f} | {error:.1f} % |")
    lateral = _table("| Slalom | a_y % | yaw rate % | slip angle front % | slip angle rear % |", rows)
    early = _table("| Slalom | Share of the peak at early fits | Least R² | Median error of D |", fits)
    return f"## Lateral (4.2)\n\nIn brackets: over the mean of the signal.\n\n{lateral}\n{early}"


def _launches(found: dict[tuple[str, str], float]) -> str:
    rows = []
    for identifier, (key, a_x, v_x, share) in LAUNCHES.items():
        cells = [f"{found[identifier, 'a_x %']:.1f} / {a_x:g}", f"{found[identifier, 'v_x %']:.2f} / {v_x:g}"]
        if key:
            reached = 100 * found["V-35", f"{key}: share of the true peak, median"]
            cells += [f"{reached:.0f} % / {share}", f"{found['V-35', f'{key}: R^2, smallest']:.2f}"]
            cells.append(f"{found['V-35', f'{key}: median error of D %']:.1f} %")
        else:
            cells += ["no fit / no fit", "–", "–"]
        rows.append(f"| {key.replace('_', ' ') or 'dry asphalt'} | " + " | ".join(cells) + " |")
    head = "| Launch | a_x % | v_x % | Share of the peak at the fits, median | Least R² | Median error of D |"
    return "## Longitudinal (4.3)\n\n" + _table(head, rows)


def _hills(found: dict[tuple[str, str], float]) -> str:
    rows = []
    for grade, (error, length) in HILLS.items():
        errors = [found["V-50", f"{grade} % {way}: error of the mean %"] for way in ("up", "down")]
        lengths = [found["V-51", f"{grade} % {way}: error of the length m"] for way in ("up", "down")]
        cells = [f"{errors[0]:.2f}, {errors[1]:.2f} / {error:g}", f"{lengths[0]:.1f}, {lengths[1]:.1f} / {length}"]
        rows.append(f"| {grade} | " + " | ".join(cells) + " |")
    return "## Grade (4.4)\n\n" + _table("| Hill % | Error of the mean %, up, down | Error of the length m |", rows)


def page() -> str:
    """Text of the page."""
    found = measured()
    return "\n".join((HEAD, _slaloms(found), _launches(found), _hills(found)))


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE.relative_to(ROOT))
