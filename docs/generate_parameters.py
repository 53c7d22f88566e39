"""docs/parameters.md, made from the models by ``python docs/generate.py``."""

import csv
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

HEAD = """# Parameters and corrections

Made from the models by `python docs/generate.py`. Three parts: what the source documents leave open and which
parameter stands for it, every parameter of the estimators and of the friction document's cars with its default and
where that comes from, and every place where the code departs from what is printed.

[DEF] marks a value that the source document does not give and that its reading here proposes; "assumed" one that this
project chose. `bench vehicle list NAME` prints the parameters of any car, [estimators.md](estimators.md) says what the
keys of the estimators mean.
"""


@dataclass(frozen=True)
class Default:
    """A [DEF] of a document: where it stands, what it is about, the parameter and its value there."""

    line: str
    about: str
    owner: str
    path: str


FRICTION_DEFAULTS = (
    Default("360", "tyre curve set A, k2", "tyre reduced_set_a", "tyres.front.longitudinal.stiffness"),
    Default("403", "pad area that gives 26 N m/bar, front axle", "ekf_car", "brakes.front.pad_area"),
    Default("403", "pad area that gives 13 N m/bar, rear axle", "ekf_car", "brakes.rear.pad_area"),
    Default("404", "time constant of the first-order brake", "ekf_car", "brakes.first_order_time_constant"),
    Default("404", "delay of the first-order brake", "ekf_car", "brakes.hydraulic_delay"),
    Default("444", "accumulator pressure", "ekf_car", "hydraulics.accumulator_pressure"),
    Default("488", "time constant of INCREASE", "ekf_car", "hydraulics.increase_time_constant"),
    Default("488", "time constant of HOLD", "ekf_car", "hydraulics.hold_time_constant"),
    Default("488", "time constant of DECREASE", "ekf_car", "hydraulics.decrease_time_constant"),
    Default("488", "threshold of the main pressure", "ekf_car", "hydraulics.pressure_change_threshold"),
    Default("569", "table of slip slopes", "slip_slope_rls", "slopes"),
    Default("569", "table of limits", "slip_slope_rls", "limits"),
    Default("736", "minimum speed (1.5 with torques, 3 without)", "friction_ekf", "minimum_speed"),
    Default("741", "floor of the speed inside f and h", "friction_ekf", "speed_floor"),
    Default("743", "share of the limit that has to be used", "friction_ekf", "confidence_ratio"),
    Default("743", "for this time", "friction_ekf", "confidence_time"),
    Default("745", "post-filter, time constant", "friction_ekf", "post_filter_time_constant"),
    Default("745", "post-filter, window", "friction_ekf", "post_filter_window"),
    Default("755", "reference tuning, P0 of the speed", "friction_ekf", "initial_deviation.speed"),
    Default("755", "reference tuning, P0 of the wheel speeds", "friction_ekf", "initial_deviation.wheel_speed"),
    Default("755", "reference tuning, P0 of the slips", "friction_ekf", "initial_deviation.slip"),
    Default("755", "reference tuning, P0 of the limits", "friction_ekf", "initial_deviation.friction_limit"),
    Default("755", "reference tuning, P0 of the rates", "friction_ekf", "initial_deviation.friction_limit_rate"),
    Default("755", "reference tuning, Q (by torque mode)", "friction_ekf", "process_noise.*"),
    Default("755", "reference tuning, R (by torque mode)", "friction_ekf", "measurement_noise.*"),
    Default("1158", "air density", "ekf_car", "aerodynamics.air_density"),
    Default("1158", "height of the drag", "ekf_car", "aerodynamics.drag_height"),
    Default("1161", "height of the centre of gravity, read over ground", "ekf_car", "body.centre_of_gravity_height"),
    Default("1187", "L_f of the asphalt car", "asphalt_car", "body.centre_of_gravity_to_front_axle"),
    Default("1187", "h of the asphalt car", "asphalt_car", "body.centre_of_gravity_height"),
    Default("1187", "wheel inertia of the asphalt car", "asphalt_car", "wheels.fl.inertia"),
    Default("1187", "loaded radius of the asphalt car", "asphalt_car", "wheels.fl.radius"),
    Default("1209", "epsilon of the slip slope", "slip_slope_rls", "stiffness_ratio"),
    Default("1209", "span of slip angles", "cornering_stiffness_rls", "slip_angle_span"),
)
CARS = ("ekf_car", "baseline_car", "asphalt_car")
_CHOICES = (
    ("193", "wheel-speed signal: a train of pulses", "tone rings, `sensors.wheel_speed`"),
    ("195, 436, 448", "valves to increase, hold, decrease; active build-up", "`hydraulic_unit.selection_logic`"),
    ("207", "periods after which a missing message is a fault", "`monitoring.timeout_periods` of the calibration"),
    ("602", "Joseph form of the update", "every filter of `estimators/kalman`"),
    ("739", "start speed from the wheels that slip least", "`estimators/longitudinal_start.py`"),
    ("755", "noise without torques", "`torque_mode` z1, z2"),
    ("966", "limits of the acceptance targets", "`at_least`, `at_most` of the criteria in `scenarios/friction`"),
    ("1035", "classes of CAN errors", "`bench inject`, `faults:` in a scenario"),
    ("1087", "faults of the hydraulic unit", "`hydraulics.*`, neutral by default"),
    ("1097", "scenario file, batch runner, verdict file, report", "`bench run`, `bench batch`, `bench report`"),
    ("1223", "gravity 9.81 m/s²", "a constant"),
    ("1246", "grip jump by position, or over a time", "`road.jumps`, or a stimulus on `road.friction`"),
)
_CAR_NOTES = (
    "Parameters that no document gives, where they are not those of ekf_car.",
    "Parameters that no document gives: [DEF] of the friction document, or assumed.",
)


def parameters_page() -> str:
    """Text of ``docs/parameters.md``."""
    from estimators import names

    parts = [HEAD, "## What the friction document leaves open\n"]
    parts += ["| Line | About | Parameter | Value |", "|---|---|---|---|"]
    parts += [_default_row(entry) for entry in FRICTION_DEFAULTS]
    parts += ["\n| Line | Choice that is no number | Here |", "|---|---|---|"]
    parts += [f"| l. {line} | {choice} | {here} |" for line, choice, here in _CHOICES]
    parts.append("\nStep times (l. 221-227): tick and hydraulic unit 1 ms, ECU task 5 ms, frames 5, 10 and 20 ms.")
    for name in names():
        parts += [f"\n## {name}\n", "| Parameter | Unit | Default | Allowed | Source |", "|---|---|---|---|---|"]
        parts += list(_estimator_rows(name))
    for car in CARS:
        parts += [
            f"\n## {car}\n",
            f"{_CAR_NOTES[car == CARS[0]]}\n",
            "| Parameter | Unit | Value | Source |",
            "|---|---|---|---|",
        ]
        parts += list(_car_rows(car))
    parts += _corrections()
    return "\n".join(parts) + "\n"


def _default_row(entry: Default) -> str:
    return f"| l. {entry.line} | {entry.about} | `{entry.path}` of {entry.owner} | {_value(entry)} |"


def _value(entry: Default) -> str:
    from estimators import describe, names
    from vehicle_model.vehicle_file import load_vehicle

    if entry.path.endswith(".*"):
        return "table of 3.6.8"
    if entry.owner in names():
        found: Any = describe(entry.owner).settings()
        for part in entry.path.split("."):
            found = getattr(found, part)
        return "by torque mode" if found is None else _text(found)
    if entry.owner.startswith("tyre "):
        from vehicle_model.vehicle_file import load_tyres

        return _text(load_tyres(entry.owner.removeprefix("tyre ")).front.longitudinal.stiffness)
    return _text(load_vehicle(entry.owner).numbers()[entry.path])


def _text(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(f"{item:g}" for item in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _estimator_rows(name: str) -> Iterator[str]:
    from estimators import describe
    from estimators.documentation import allowed_text, default_text, settings_fields
    from signals.quantities import unit_of

    for path, field in settings_fields(describe(name).settings):
        extra = field.json_schema_extra
        source = str(extra.get("source", "")) if isinstance(extra, dict) else ""
        unit = unit_of(field) or ""
        yield f"| `{path}` | {unit} | {default_text(field)} | {allowed_text(field)} | {source} |"


def _car_rows(car: str) -> Iterator[str]:
    from vehicle_model.vehicle_file import load_vehicle, parameter_table

    shown = {info.path: info.value for info in parameter_table(load_vehicle(CARS[0]))} if car != CARS[0] else {}
    for info in parameter_table(load_vehicle(car)):
        chosen = "DEF" in info.source or "assumed" in info.source
        if chosen and shown.get(info.path) != info.value:
            yield f"| `{info.path}` | {info.unit} | {info.value:.6g} | {info.source} |"


def _item(row: dict[str, str]) -> tuple[str, str, str]:
    """What makes a correction one: an item may depart in several places, and a place be kept by switch and test."""
    return row["item"], row["place"], row["printed"]


def _corrections() -> list[str]:
    with (ROOT / "docs" / "corrections.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    lines = ["\n## Corrections of what is printed\n", "| Document | Items | with a switch | with a test | text only |"]
    lines.append("|---|---:|---:|---:|---:|")
    for spec in dict.fromkeys(row["spec"] for row in rows):
        of_spec = [row for row in rows if row["spec"] == spec]
        items = {_item(row) for row in of_spec}
        counts = [len({_item(row) for row in of_spec if row["kept_by"] == kind}) for kind in ("switch", "test", "text")]
        lines.append(f"| {spec} | {len(items)} | " + " | ".join(map(str, counts)) + " |")
    lines += ["\nAn item of text only (a caption, a reference, a name) computes nothing.\n"]
    lines += ["| Document | Item | Place | Printed | Here | Kept by |", "|---|---|---|---|---|---|"]
    for row in rows:
        kept = f"{row['kept_by']} `{row['name']}`" if row["name"] else "text"
        lines.append(f"| {row['spec']} | {row['item']} | {row['place']} | {row['printed']} | {row['here']} | {kept} |")
    return lines
