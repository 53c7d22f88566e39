"""Names of what a fault can do to the car, from harmless to hazardous, and of what a campaign's limits may limit."""

from typing import Final, Literal

NO_EFFECT: Final = "no_effect"
CORRECTED: Final = "corrected"
DEGRADED: Final = "degraded_safely"
SILENT: Final = "silent_harmless"
HAZARDOUS: Final = "hazardous"
BENCH_ERROR: Final = "bench_error"

Outcome = Literal["no_effect", "corrected", "degraded_safely", "silent_harmless", "hazardous", "bench_error"]
OUTCOMES: tuple[Outcome, ...] = (NO_EFFECT, CORRECTED, DEGRADED, SILENT, HAZARDOUS, BENCH_ERROR)
OUTCOME_TEXTS: dict[str, str] = {
    NO_EFFECT: "no effect",
    CORRECTED: "corrected by the protocol",
    DEGRADED: "detected and degraded safely",
    SILENT: "silent but harmless",
    HAZARDOUS: "hazardous",
    BENCH_ERROR: "bench error",
}
SHORT_TEXTS: dict[str, str] = {
    NO_EFFECT: "no effect",
    CORRECTED: "corrected",
    DEGRADED: "degraded",
    SILENT: "silent",
    HAZARDOUS: "hazardous",
    BENCH_ERROR: "error",
}

LIMIT_QUANTITIES = (
    *(f"{outcome}_{what}" for outcome in OUTCOMES for what in ("runs", "share")),
    "detected_share",
    "undetected_share",
    "hazardous_undetected_runs",
    "largest_detection_latency",
)
