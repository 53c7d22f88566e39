"""A fit from tables to files: the .tir file, two pictures, and every figure as JSON."""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from bench.tyre_bench.fitting import Fit, errors_of, fit_tyre
from bench.tyre_bench.rig_data import RigData, read_rig_data
from signals.errors import InputError, RunError
from vehicle_model.tyres.magic_formula_tyre import MagicFormulaTyre, read_tir
from vehicle_model.tyres.tir_writer import write_tir

Say = Callable[[str], None]
_UNITS = {"fx": "N", "fy": "N", "mx": "N m", "mz": "N m"}


def run_fit(
    paths: Sequence[Path],
    out: Path,
    name: str,
    *,
    compare: Path | None = None,
    units: Mapping[str, str] | None = None,
    slip: str | None = None,
    sae: bool = False,
    nominal_load: float | None = None,
    nominal_pressure: float | None = None,
    radius: float | None = None,
    say: Say = print,
) -> dict[str, Any]:
    """Fit, write and say; returns what ``fit.json`` holds.

    Raises
    ------
    InputError
        If the measurements or the file to compare with are bad, or the folder cannot be written.
    """
    other = read_tir(compare) if compare is not None else None
    data = read_rig_data(paths, units, slip, sae)
    for note in data.notes:
        say(f"note: {note}")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{out}: {(error.strerror or str(error)).lower()}") from None
    fit = fit_tyre(
        data, name, nominal_load=nominal_load, nominal_pressure=nominal_pressure, radius=radius, progress=say
    )
    file = write_tir(out / f"{name}.tir", fit.tyre, _remarks(paths, fit, data))
    _check_written(file, fit.tyre)
    result = _result(file, fit, data, other)
    from bench.tyre_bench.fit_pictures import draw_fit

    result["pictures"] = [str(picture) for picture in draw_fit(fit.tyre, data, out)]
    (out / "fit.json").write_text(json.dumps(result, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    _say_result(result, say)
    return result


def _remarks(paths: Sequence[Path], fit: Fit, data: RigData) -> list[str]:
    lines = [f"fitted to {', '.join(path.name for path in paths)}: {len(data.inputs)} rows", *data.notes]
    if fit.missing:
        lines.append(f"no measurements, usual values kept: {', '.join(fit.missing)}")
    lines.append("outside the ranges below the curves are extrapolated; rolling resistance (QSY) is not fitted")
    return lines


def _check_written(file: Path, tyre: MagicFormulaTyre) -> None:
    if read_tir(file, combined_slip="weights").record.tobytes() != tyre.record.tobytes():
        raise RunError(f"{file}: reads back as another tyre than was fitted")


def _result(file: Path, fit: Fit, data: RigData, other: MagicFormulaTyre | None) -> dict[str, Any]:
    errors = errors_of(fit.tyre, data)
    result: dict[str, Any] = {
        "tir": str(file),
        "rows": len(data.inputs),
        "notes": data.notes,
        "stages": fit.stages,
        "missing": fit.missing,
        "at_bounds": fit.at_bounds,
        "rms": errors,
    }
    if other is not None:
        theirs = errors_of(other, data)
        result["compared_with"] = other.name
        result["rms_compared"] = theirs
        result["ratio"] = {
            kind: {force: value / theirs[kind][force] for force, value in by_force.items() if theirs[kind][force] > 0.0}
            for kind, by_force in errors.items()
        }
    return result


def _say_result(result: Mapping[str, Any], say: Say) -> None:
    if result["missing"]:
        say(f"no measurements for: {', '.join(result['missing'])}")
    if result["at_bounds"]:
        say(f"at a bound: {', '.join(result['at_bounds'])}")
    for kind, by_force in result["rms"].items():
        for force, value in by_force.items():
            beside = ""
            if "ratio" in result:
                theirs, ratio = result["rms_compared"][kind][force], result["ratio"][kind].get(force)
                beside = f"   {result['compared_with']}: {theirs:8.2f}" + (f"   ratio {ratio:.3f}" if ratio else "")
            say(f"rms {kind:<10} {force} {value:8.2f} {_UNITS[force]:<4}{beside}")
    for file in (result["tir"], *result["pictures"]):
        say(file)
