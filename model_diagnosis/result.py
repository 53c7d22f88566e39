"""What a diagnosis answers; ``diagnosis.json`` is this model written out."""

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

Subject = Literal["car", "wheel_on_rig"]

Verdict = Literal[
    "effect_found", "nothing_found", "data_fault", "indistinguishable", "insufficient_data", "wrong_vehicle"
]


class Part(BaseModel):
    """Base of the parts: no unknown fields."""

    model_config = ConfigDict(extra="forbid")


class DataFault(Part):
    """A fault of the data, named as such and repaired where possible."""

    kind: str
    channel: str
    value: float | None = None
    unit: str = ""
    evidence: float | None = Field(default=None, description="p-value or log-likelihood margin behind it")
    repaired: bool = False
    message: str


class ParameterEstimate(Part):
    """Physical value with its 90 % interval; ``nominal`` is the vehicle file's."""

    value: float
    low: float
    high: float
    unit: str
    nominal: float


class Cause(Part):
    """An effect with its probability and everything this data cannot tell from it."""

    effect: str
    probability: float
    parameters: dict[str, ParameterEstimate]
    group: list[str] = Field(description="effects not distinguishable on this data, itself included")
    group_probabilities: dict[str, float] = Field(default_factory=dict, description="probability of each of the group")
    equation: str
    evidence: float = Field(description="log Bayes factor against 'nothing'")
    remarks: list[str] = []


class DiscoveredTerm(Part):
    """A term that no catalogue effect explains."""

    formula: str
    target: str
    coefficients: list[float]
    low: list[float]
    high: list[float]
    units: list[str]
    inclusion: float


class SignalGain(Part):
    """Error of one signal on held-out manoeuvres before and after, with the 90 % interval of the error after."""

    before: float
    after: float
    low: float
    high: float
    unit: str
    noise_floor: float
    share: float | None = Field(default=None, description="(E0 - E1)/(E0 - N) of squared errors and noise variance")
    share_low: float | None = None
    share_high: float | None = None


class OverallGain(Part):
    """Error after divided by error before over all signals, with its 90 % interval."""

    ratio: float
    low: float
    high: float


class Gain(Part):
    """What the extension gains on data it never saw."""

    held_out: dict[str, SignalGain]
    overall: OverallGain
    against_refit: OverallGain | None = Field(
        default=None, description="the same relative to a refit of the nominal parameters within two of their scatters"
    )
    user_figures: dict[str, dict[str, float]] = Field(
        default_factory=dict, description="stopping distance, ABS cycles, … before and after"
    )
    cross_validated: bool = False


class NextManoeuvre(Part):
    """Manoeuvre that would separate what this data cannot, with the log evidence expected of it."""

    name: str
    description: str
    separates: list[str]
    expected_evidence: float


LIT_RATIO = 40.0
"""Likelihood ratio from which an equation counts as violated; the largest of eleven clean cars was 31."""


class ViolatedEquation(Part):
    """How much an equation needs an error of its own, and the root mean square of the likeliest one."""

    likelihood_ratio: float
    error: float
    unit: str


class Diagnosis(Part):
    """The whole answer."""

    verdict: Verdict
    subject: Subject = Field(default="car", description="what was replayed: a car, or one wheel whose slips a rig sets")
    data_faults: list[DataFault] = []
    causes: list[Cause] = []
    discovered_terms: list[DiscoveredTerm] = []
    gain: Gain | None = None
    next_manoeuvre: NextManoeuvre | None = None
    extension_file: str | None = None
    remarks: list[str] = []
    insufficient: list[str] = Field(default_factory=list, description="effects that this data does not excite")
    detection_limits: dict[str, float] = Field(
        default_factory=dict, description="effect.parameter -> smallest deviation that this data would show"
    )
    guilty_equations: dict[str, float] = Field(
        default_factory=dict, description="equation -> likelihood ratio by equation error"
    )
    guilty_by_innovations: dict[str, ViolatedEquation] = Field(
        default_factory=dict, description="equation -> likelihood ratio by innovations of the stochastic replay"
    )
    ratings: dict[str, dict[str, float]] = Field(
        default_factory=dict, description="manoeuvre -> signal -> ISO/TS 18571 rating of the free run"
    )
    ratings_restarted: dict[str, dict[str, float]] = Field(
        default_factory=dict, description="the same of the run that restarts each second"
    )
    probability_of_nothing: float | None = None
    threshold: float | None = Field(default=None, description="log Bayes factor needed, from the bootstrap")
    timing_s: dict[str, float] = {}
    versions: dict[str, Any] = {}
