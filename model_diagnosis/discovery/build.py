"""A discovered term as an added term of the car, and as it stands in the answer."""

import math
from typing import Any

from model_diagnosis.discovery.candidates import Shape
from model_diagnosis.discovery.term import DiscoveredTerm
from model_diagnosis.extension.extended_vehicle import FoundTerm, Interval
from model_diagnosis.result import DiscoveredTerm as TermOfAnswer
from vehicle_model.extension_terms_file import Term


def _factor(shape: Shape, phase: float) -> dict[str, Any]:
    factor: dict[str, Any] = {"variable": shape.variable, "function": shape.function, "symmetry": shape.symmetry}
    numbers = {
        "power": ("exponent",),
        "above": ("at", "exponent"),
        "below": ("at", "exponent"),
        "step": ("at",),
        "excess_share": ("at",),
        "limited": ("at", "width"),
        "direction": ("width",),
        "sine": ("wave_number",),
    }[shape.function]
    factor |= {name: getattr(shape, name) for name in numbers}
    return factor | ({"phase": phase} if shape.function == "sine" else {})


def term_of_the_car(target: str, term: DiscoveredTerm) -> FoundTerm:
    """The term for the car's stack; ``target`` is one of ``vehicle_model.extension_terms_file``."""
    candidate = term.candidate
    phase = math.atan2(term.coefficients[1], term.coefficients[0]) if len(term.coefficients) == 2 else 0.0
    built = Term.model_validate(
        {
            "target": target,
            "coefficient": term.amplitude,
            "wheels": "all",
            "factors": [_factor(shape, phase) for shape in candidate.shapes],
            "description": term.formula,
        }
    )
    evidence = (
        f"chosen in {term.inclusion:.0%} of half-samples, takes {term.explained:.0%} of the data's squared misfit"
    )
    return FoundTerm(term.formula, [built], [interval_of(term)], evidence)


def interval_of(term: DiscoveredTerm) -> Interval:
    """Coefficient with its 90 % interval; of a periodic term the amplitude, as far as its sine and cosine reach."""
    if len(term.coefficients) == 1:
        return Interval(term.amplitude, float(term.low[0]), float(term.high[0]))
    reach = math.hypot(*((high - low) / 2.0 for low, high in zip(term.low, term.high, strict=True))) / math.sqrt(2.0)
    return Interval(term.amplitude, max(term.amplitude - reach, 0.0), term.amplitude + reach)


def term_of_answer(term: DiscoveredTerm) -> TermOfAnswer:
    """The term as diagnosis.json has it."""
    interval = interval_of(term)
    return TermOfAnswer(
        formula=term.formula,
        target=term.target,
        coefficients=[interval.value],
        low=[interval.low],
        high=[interval.high],
        units=[term.unit],
        inclusion=float(term.inclusion),
    )
