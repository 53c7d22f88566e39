"""Extensions of a vehicle file: effects that measured data showed, with their evidence."""

from typing import Annotated

from pydantic import Field

from signals.quantities import FileModel
from vehicle_model.extension_terms_file import Term


class Provenance(FileModel):
    """What a value was found from.

    Attributes
    ----------
    vehicle : str
        SHA-256 of the parameters of the vehicle that was diagnosed.
    data : dict
        Name of each log to its SHA-256.
    versions : dict
        Of the programs that found it.
    """

    vehicle: str = ""
    data: dict[str, str] = Field(default_factory=dict)
    versions: dict[str, str] = Field(default_factory=dict)


class Extension(FileModel):
    """An effect, as parameters of the car by dotted path and as added terms.

    Attributes
    ----------
    parameters : dict
        Dotted path to the value that takes the place of the file's.
    terms : list
        Added to the car's stack of terms.
    intervals : dict
        Dotted path (``terms.0.coefficient`` for the first of these terms) to the ends of the 90 % interval, SI units.
    conditions : dict
        What belongs to the measured drive and not to the car (a grade, a wind, a clock's offset): told, not applied.
    probability, log_bayes_factor : float, optional
        Of the effect, against the car without it.
    group : list
        Effects that the data cannot tell from this one.
    """

    effect: str
    equation: str = ""
    parameters: dict[str, float | str] = Field(default_factory=dict)
    terms: list[Term] = Field(default_factory=list)
    intervals: dict[str, Annotated[list[float], Field(min_length=2, max_length=2)]] = Field(default_factory=dict)
    conditions: dict[str, str] = Field(default_factory=dict)
    probability: float | None = Field(default=None, ge=0.0, le=1.0)
    log_bayes_factor: float | None = None
    group: list[str] = Field(default_factory=list)
    evidence: str = ""
    provenance: Provenance = Provenance()
