"""Families of cases and the drawing of what is hidden in each."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hidden_effects.car import DATA_SHEET, WHEELS, Number, Numbers
from hidden_effects.data_faults import FAULTS, Fault
from hidden_effects.effects import EFFECTS, HiddenEffect
from hidden_effects.manoeuvres import SIX
from hidden_effects.sensors import SENSOR_SHEET
from hidden_effects.special_effects import UNEXCITED, VISIBLE_IN_ONE
from hidden_effects.unknown_terms import KINDS, UnknownKind

FloatArray = NDArray[np.float64]

SHARES: dict[str, float] = {
    "single": 70,
    "pair": 25,
    "data_fault": 25,
    "confounded": 20,
    "unknown": 20,
    "clean": 20,
    "unexcited": 8,
    "wrong_vehicle": 6,
    "one_manoeuvre": 6,
}
"""Cases of each family in 200; ``detection`` (singles below the limit) is drawn on request only."""

FAMILIES = (*SHARES, "detection")


@dataclass(frozen=True)
class LookAlike:
    """A pair that some data cannot separate: true effect, its twin, and the channels or manoeuvres left out for it.

    ``smallest`` is the size in scatters from which these data show the effect; 0 where it is that of the shipped set.
    """

    effect: str
    twin: str
    missing: tuple[str, ...] = ()
    manoeuvres: tuple[str, ...] = ()
    smallest: float = 0.0


_NO_MASTER = ("master_pressure", "pedal_force")
_COAST = ("coast",)

CONFOUNDED: tuple[LookAlike, ...] = (
    LookAlike("brake_pad_friction", "pressure_sensor_scale", _NO_MASTER, smallest=4.2),
    LookAlike("pressure_sensor_scale", "brake_pad_friction", _NO_MASTER, smallest=25.0),
    LookAlike("brake_threshold", "pressure_sensor_offset", _NO_MASTER, smallest=6.0),
    LookAlike("pressure_sensor_offset", "brake_threshold", _NO_MASTER, smallest=6.0),
    LookAlike("aero_drag", "head_wind", (), _COAST, smallest=9.0),
    LookAlike("head_wind", "aero_drag", (), _COAST, smallest=15.0),
)

_OPTIONAL = (
    "speed",
    "pitch_rate",
    "roll_rate",
    "lateral_acceleration",
    "longitudinal_acceleration",
    "yaw_rate",
    "master_pressure",
    "pedal_force",
)
MISSING_SHARE = 0.2

_WRONG_CAR: dict[str, float] = {
    "mass": 0.4,
    "cg_height": 0.25,
    "cg_to_front": 0.14,
    "yaw_inertia": 0.5,
    "pad_gain": -0.25,
    "peak_x": -0.25,
    "stiffness_y_front": -0.3,
    "steering_ratio": 0.15,
    "drag_area": 0.6,
}
"""Relative deviations of another car; each case takes five of them."""


@dataclass(frozen=True)
class Hidden:
    """One hidden effect as drawn: ``deviation`` in its unit, at ``place`` (a wheel or axle)."""

    effect: HiddenEffect
    deviation: float
    place: int

    @property
    def units(self) -> float:
        """Size in nominal scatters."""
        return abs(self.deviation) / self.effect.scatter

    def applied(self, car: Numbers, chain: Numbers) -> None:
        """Put it into a car and its measuring chain, in place of what its numbers scatter by."""
        for name, entry in self.effect.numbers_at(self.place):
            store, sheet = (chain, SENSOR_SHEET) if name.startswith("chain:") else (car, DATA_SHEET)
            name = name.removeprefix("chain:")
            store[name] = _at_nominal(store[name], sheet[name], entry)
        self.effect.change(car, chain, self.deviation, self.place)


def _at_nominal(values: FloatArray, number: Number, entry: int | None) -> FloatArray:
    """Values of a number as on the data sheet; only ``entry``'s where it has one for each place."""
    nominal = np.array(number.nominal, float)
    if entry is None or nominal.ndim == 0:
        return nominal
    changed = values.copy()
    changed[entry] = nominal[entry]
    return changed


@dataclass(frozen=True)
class Draw:
    """Everything hidden in a case.

    Attributes
    ----------
    only_in : name of the one manoeuvre that has the effects; "" for all
    manoeuvres : names of those that the user has; empty for the whole shipped set
    expected : further facts for the label
    """

    family: str
    effects: tuple[Hidden, ...] = ()
    fault: Fault | None = None
    unknown: tuple[UnknownKind, float] | None = None
    wrong_car: dict[str, float] = field(default_factory=dict)
    only_in: str = ""
    manoeuvres: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    expected: dict[str, Any] = field(default_factory=dict)


def family_of(index: int, wanted: str | None) -> str:
    """Family of a case, so that any count holds the families in their shares."""
    if wanted is not None:
        return wanted
    names = list(SHARES)
    shares = np.array([SHARES[name] for name in names])
    given = np.zeros(len(names))
    for k in range(index + 1):
        owed = shares / shares.sum() * (k + 1) - given
        chosen = int(np.argmax(owed))
        given[chosen] += 1
    return names[chosen]


def draw_hidden(effect: HiddenEffect, random: np.random.Generator, low: float, high: float) -> Hidden:
    """An effect with a size log-uniform between ``low`` and ``high`` scatters, in a random direction."""
    units = float(np.exp(random.uniform(np.log(low), np.log(high))))
    sign = int(random.choice(effect.signs))
    place = int(random.integers(effect.places)) if effect.places else 0
    return Hidden(effect, sign * units * effect.scatter, place)


def _usual(effect: HiddenEffect, random: np.random.Generator) -> Hidden:
    return draw_hidden(effect, random, effect.smallest, effect.largest)


def named(name: str) -> HiddenEffect:
    """The effect of a name."""
    return next(effect for effect in EFFECTS + UNEXCITED + VISIBLE_IN_ONE if effect.name == name)


def draw(family: str, random: np.random.Generator) -> Draw:
    """What a case of a family hides."""
    result = _DRAWS[family](random)
    needs = {name for hidden in result.effects for name in hidden.effect.needs}
    touched = set(result.fault.channels) if result.fault is not None else set()
    may_miss = [name for name in _OPTIONAL if name not in needs | touched | set(result.missing)]
    if family not in ("confounded", "data_fault") and random.random() < MISSING_SHARE:
        result = Draw(**{**result.__dict__, "missing": (*result.missing, str(random.choice(may_miss)))})
    return result


def _clean(random: np.random.Generator) -> Draw:
    return Draw("clean")


def _single(random: np.random.Generator) -> Draw:
    return Draw("single", (_usual(EFFECTS[int(random.integers(len(EFFECTS)))], random),))


def _detection(random: np.random.Generator) -> Draw:
    effect = EFFECTS[int(random.integers(len(EFFECTS)))]
    return Draw("detection", (draw_hidden(effect, random, 0.5, effect.smallest),))


def _pair(random: np.random.Generator) -> Draw:
    while True:
        first, second = random.choice(len(EFFECTS), 2, replace=False)
        one, other = EFFECTS[int(first)], EFFECTS[int(second)]
        if {one.name, other.name} not in [{pair.effect, pair.twin} for pair in CONFOUNDED]:
            return Draw("pair", (_usual(one, random), _usual(other, random)))


def _data_fault(random: np.random.Generator) -> Draw:
    return Draw("data_fault", fault=FAULTS[int(random.integers(len(FAULTS)))].draw(random))


def _confounded(random: np.random.Generator) -> Draw:
    pair = CONFOUNDED[int(random.integers(len(CONFOUNDED)))]
    effect = named(pair.effect)
    hidden = draw_hidden(effect, random, max(pair.smallest, effect.smallest), effect.largest)
    if pair.effect == "pressure_sensor_offset":  # a threshold cannot be negative
        hidden = Hidden(hidden.effect, abs(hidden.deviation), hidden.place)
    return Draw("confounded", (hidden,), manoeuvres=pair.manoeuvres, missing=pair.missing, expected={"twin": pair.twin})


def _unknown(random: np.random.Generator) -> Draw:
    kind = KINDS[int(random.integers(len(KINDS)))]
    return Draw("unknown", unknown=(kind, float(random.uniform(kind.low, kind.high))))


def _unexcited(random: np.random.Generator) -> Draw:
    effect = UNEXCITED[int(random.integers(len(UNEXCITED)))]
    return Draw("unexcited", (_usual(effect, random),))


def _wrong_vehicle(random: np.random.Generator) -> Draw:
    chosen = random.choice(list(_WRONG_CAR), 5, replace=False)
    return Draw("wrong_vehicle", wrong_car={str(name): _WRONG_CAR[str(name)] for name in chosen})


def _one_manoeuvre(random: np.random.Generator) -> Draw:
    effect = VISIBLE_IN_ONE[int(random.integers(len(VISIBLE_IN_ONE)))]
    where = {"mu_step": ("abs_stop",), "road_grade": tuple(s.name for s in SIX), "head_wind": ("coast", "gentle_stops")}
    only = str(random.choice(where[effect.name]))
    return Draw("one_manoeuvre", (_usual(effect, random),), only_in=only)


_DRAWS = {
    "single": _single,
    "pair": _pair,
    "data_fault": _data_fault,
    "confounded": _confounded,
    "unknown": _unknown,
    "clean": _clean,
    "unexcited": _unexcited,
    "wrong_vehicle": _wrong_vehicle,
    "one_manoeuvre": _one_manoeuvre,
    "detection": _detection,
}


def place_name(hidden: Hidden) -> str:
    """Wheel or axle of a hidden effect; "" for the whole car."""
    if hidden.effect.places == len(WHEELS):
        return WHEELS[hidden.place]
    return ("front", "rear")[hidden.place] if hidden.effect.places == 2 else ""
