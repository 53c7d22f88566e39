"""Generator of measured-like logs with a hidden effect: a program of its own that knows nothing of the bench.

It shares no code with the bench and imports none of its packages (nor do they import it): what it knows of the car are
the numbers of the car's data sheet, what it knows of effects are their published equations. ``python generate.py
--help`` runs it; ``FORM_DIFFERENCES`` lists in what its simulator differs in form from a usual 1 ms replay model.
"""

import hashlib
from pathlib import Path

import numba

VERSION = "10"

FORM_DIFFERENCES = (
    "step 0.5 ms; chassis by the two-step Adams-Bashforth rule, wheel spin and tyre force staggered (symplectic)",
    "tyre transient on the force, exponentially exact, instead of a lag of the slip",
    "pitch and roll of second order on springs and dampers; load transfer is what springs, dampers and links carry",
    "no heave: what links and air lift of the body is less weight on all its wheels at once",
    "wheels without travel of their own, dampers with one rate for both directions, wheels stand upright",
    "links take what braking and driving lift of an axle at both of its sides alike",
    "four-channel ABS logic of its own with a 10 ms cycle and a reference speed of its own",
    "brake discs warmed by the energy that they take, cooled by Newton's law",
    "booster with a lag of 20 ms, valves with 2 ms; the control unit decides half a cycle beside the sampled instants",
    "aligning moments on car and steering from a trail that falls as a cosine with the slip angle",
    "second generator: exponential (Burckhardt) tyre curves on a friction circle in place of the arctangent ones",
)
"""In what the hidden car differs in form from the model that diagnoses it."""


def _import_compiled() -> None:
    """Import what numba compiles with a cache folder per state of these sources: numba's own does not see a changed
    callee. The folder is fixed where a function is decorated, so what others compile stays where they want it."""
    here = Path(__file__).parent
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in sorted(here.glob("*.py")))).hexdigest()[:16]
    others = numba.config.CACHE_DIR
    base = Path(others) if others else Path.home() / ".cache" / "hidden_effects"
    numba.config.CACHE_DIR = str(base / f"hidden_effects_{digest}")
    try:
        from hidden_effects import brakes, chassis, controller, courses, simulator, tyre, unknown_terms  # noqa: F401
    finally:
        numba.config.CACHE_DIR = others


_import_compiled()
