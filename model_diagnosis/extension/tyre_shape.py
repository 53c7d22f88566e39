"""Tyre curves whose peak lies at another slip or whose sliding friction is less, at the same stiffness and peak."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from model_diagnosis.replay.tyre_table import fit_tyre
from signals.errors import InputError
from vehicle_model.extension_terms_file import Term
from vehicle_model.tyres.tyre_file import CurveTyre, MagicFormulaCurve
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]
_SLIPS = np.linspace(0.002, 1.0, 2000)
_LARGEST_MISFIT = 0.02


def curve(slip: FloatArray, shape: float, stiffness: float, curvature: float) -> FloatArray:
    """Magic Formula with peak factor 1 (eq. 7 of the friction document)."""
    scaled = stiffness * slip
    friction: FloatArray = np.sin(shape * np.arctan(scaled - curvature * (scaled - np.arctan(scaled))))
    return friction


def _peak(shape: float, stiffness: float, curvature: float) -> tuple[float, float]:
    """Slip at the peak, and friction at slip 1 over the peak's."""
    friction = curve(_SLIPS, shape, stiffness, curvature)
    best = int(np.argmax(friction))
    if 0 < best < len(_SLIPS) - 1:
        left, middle, right = friction[best - 1 : best + 2]
        shift = 0.5 * (left - right) / (left - 2.0 * middle + right)
    else:
        shift = 0.0
    slip = _SLIPS[best] + shift * (_SLIPS[1] - _SLIPS[0])
    return float(slip), float(friction[-1] / friction[best])


def reshaped(tyre: MagicFormulaCurve, sliding_loss: float, peak_slip: float) -> MagicFormulaCurve:
    """Curve of the same stiffness and peak whose friction at slip 1 is less by ``sliding_loss`` of the peak, and whose
    peak lies at a slip 1 + ``peak_slip`` times as large.

    Raises
    ------
    InputError
        If no Magic Formula has that form.
    """
    slip, slide = _peak(tyre.shape, tyre.stiffness, tyre.curvature)
    slope = tyre.shape * tyre.stiffness
    wanted = (slip * (1.0 + peak_slip), slide - sliding_loss)

    def misfit(values: FloatArray) -> FloatArray:
        shape, curvature = values
        at, left = _peak(shape, slope / shape, curvature)
        return np.array([at / wanted[0] - 1.0, left - wanted[1]])

    found = least_squares(
        misfit, [max(tyre.shape, 1.05), tyre.curvature], bounds=([1.0, -20.0], [2.6, 1.0]), diff_step=1e-3
    )
    if np.max(np.abs(found.fun)) > _LARGEST_MISFIT:
        raise InputError(
            "tyre_peak_shape: no Magic Formula has this form",
            found=f"peak at slip {wanted[0]:.3f}, {wanted[1]:.2f} of it at slip 1, same stiffness",
        )
    shape, curvature = (float(value) for value in found.x)
    # the peak stays what it was: the formula's own peak is the factor only if C exceeds 1
    return tyre.model_copy(update={"shape": shape, "stiffness": slope / shape, "curvature": curvature})


def _sliding_term(peak_slip: float, slide: float, loss: float, wheels: str) -> Term:
    """Friction that falls beyond the peak, in a straight line to the loss at slip 1."""
    return Term.model_validate(
        {
            "target": "tyre_friction_factor",
            "coefficient": -loss / slide / (1.0 - peak_slip),
            "wheels": wheels,
            "factors": [
                {"variable": "slip_ratio", "function": "above", "at": peak_slip, "symmetry": "even"},
            ],
            "description": "friction beyond the peak",
        }
    )


def peak_shape(vehicle: VehicleFile, deviation: Mapping[str, float]) -> tuple[dict[str, float], list[Term]]:
    """Law of ``tyre_peak_shape``: the parameters of a Magic Formula; else a falling branch as a term."""
    loss, shift = deviation.get("sliding_loss", 0.0), deviation.get("peak_slip", 0.0)
    values: dict[str, float] = {}
    terms: list[Term] = []
    pair = vehicle.tyre_pair
    for number, (axle, tyre) in enumerate((("front", pair.front), ("rear", pair.rear))):
        if isinstance(tyre, CurveTyre) and isinstance(tyre.longitudinal, MagicFormulaCurve):
            changed = reshaped(tyre.longitudinal, loss, shift)
            for name in ("shape", "stiffness", "curvature"):
                values[f"tyres.{axle}.longitudinal.{name}"] = getattr(changed, name)
        elif shift != 0.0:
            raise InputError(
                "tyre_peak_shape.peak_slip: this vehicle has no parameter for it",
                allowed="tyres of the Magic Formula",
                mend=f"tyres.{axle} follows another formula",
            )
        else:
            form = fit_tyre(tyre, vehicle.static_loads()[2 * number]).longitudinal
            terms.append(_sliding_term(form.peak_slip, float(form.table[-1, 0]), loss, axle))
    return values, terms
