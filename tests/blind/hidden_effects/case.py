"""One case of the challenge: hidden car, logs, map, vehicle file, and the sealed label."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hidden_effects import FORM_DIFFERENCES, VERSION
from hidden_effects.car import DATA_SHEET, Numbers, as_record, draw_car
from hidden_effects.courses import torque_course
from hidden_effects.effects import EFFECTS
from hidden_effects.families import Draw, Hidden, draw, family_of, place_name
from hidden_effects.isolability import EVIDENCE_NEEDED, Truth, separation, size_std, truth_of
from hidden_effects.logs import FORMATS, channel_map, database, write_logs
from hidden_effects.manoeuvres import HELD_OUT, SIX, Script
from hidden_effects.recording import Loggers, MessageLog, draw_loggers, record
from hidden_effects.sealing import seal
from hidden_effects.sensors import SENSOR_SHEET, draw_sensors
from hidden_effects.simulator import simulate
from hidden_effects.tyre import ARCTANGENT, EXPONENTIAL
from hidden_effects.vehicle_file import vehicle_file

FORMAT_SHARES = (0.7, 0.15, 0.15)
GENERATORS = {"first": ARCTANGENT, "second": EXPONENTIAL}


class Case:
    """A drawn case; ``manoeuvre_columns`` simulates it, ``write`` records it.

    Parameters
    ----------
    seed, index : the challenge and the case's number in it
    family : one family for all cases; None for the mixture
    generator : ``first`` or ``second`` (another tyre curve)
    """

    def __init__(self, seed: int, index: int, family: str | None, generator: str) -> None:
        self.index = index
        self.random = np.random.default_rng([seed, index, 20_917])
        self.family = family_of(index, family)
        self.car, self.deviations = draw_car(self.random)
        self.chain = draw_sensors(self.random)
        self.car["curve"] = np.array(GENERATORS[generator])
        self.generator = generator
        self.draw = self._drawn()
        self.format = str(self.random.choice(FORMATS, p=FORMAT_SHARES))
        plain = draw_loggers(self.random, one_raster=self.format == "csv")
        self.loggers = Loggers(plain.clock_offset_s, plain.phases_s, self.draw.missing, self.draw.fault)

    def _drawn(self) -> Draw:
        """What the case hides; several effects so that each shows beside the others."""
        while True:
            drawn = draw(self.family, self.random)
            if len(drawn.effects) < 2 or all(self.shown(drawn, hidden) > EVIDENCE_NEEDED for hidden in drawn.effects):
                return drawn

    def shown(self, drawn: Draw, hidden: Hidden) -> float:
        """Expected log evidence for one of the hidden effects beside the others, were all else known.

        A late valve does nothing where another effect keeps its wheel from locking.
        """
        car, chain = dict(self.car), dict(self.chain)
        for other in drawn.effects:
            if other is not hidden:
                other.applied(car, chain)
        change = truth_of((hidden.effect, hidden.deviation, hidden.place), car, chain, SIX, drawn.missing).secant
        return 0.5 * float(change @ change)

    def car_in(self, script: Script) -> tuple[Numbers, Numbers]:
        """Car and measuring chain as they are in a manoeuvre, hidden effects included."""
        car, chain = dict(self.car), dict(self.chain)
        for name, deviation in self.draw.wrong_car.items():
            car[name] = car[name] * (1.0 + deviation)
        if self.draw.unknown is not None:
            kind, size = self.draw.unknown
            car["unknown_kind"], car["unknown_size"] = np.array(kind.number), np.array(size)
        if self.draw.only_in in ("", script.name):
            for hidden in self.draw.effects:
                hidden.applied(car, chain)
        return car, chain

    def scripts(self) -> tuple[tuple[Script, ...], tuple[Script, ...]]:
        """Manoeuvres that the user has, and those held out."""
        if not self.draw.manoeuvres:
            return SIX, HELD_OUT
        return tuple(s for s in SIX if s.name in self.draw.manoeuvres), HELD_OUT[:1]

    def recorded(self, scripts: tuple[Script, ...]) -> dict[str, dict[str, MessageLog]]:
        """Simulated and recorded manoeuvres: name -> message -> frames."""
        result = {}
        for script in scripts:
            car, chain = self.car_in(script)
            drive = script.drive()
            columns = simulate(as_record(car), drive)
            result[script.name] = record(columns, drive, chain, self.loggers, self.random)
        return result

    def label(self) -> dict[str, Any]:
        """What is hidden, as the scorer will read it."""
        fault, unknown = self.draw.fault, self.draw.unknown
        return {
            "version": VERSION,
            "generator": self.generator,
            "family": self.family,
            "effects": [self._effect(hidden) for hidden in self.draw.effects],
            "data_fault": None
            if fault is None
            else {"kind": fault.kind, "channels": list(fault.channels), "value": fault.value, "unit": fault.unit},
            "unknown": None
            if unknown is None
            else {
                "kind": unknown[0].name,
                "formula": unknown[0].formula,
                "variables": list(unknown[0].variables),
                "size": unknown[1],
            },
            "wrong_car": self.draw.wrong_car,
            "only_in": self.draw.only_in,
            "missing": list(self.draw.missing),
            "clock_offset_s": self.loggers.clock_offset_s,
            "deviations": self.deviations,
            **self.draw.expected,
        }

    def _effect(self, hidden: Hidden) -> dict[str, Any]:
        return {
            "name": hidden.effect.name,
            "place": place_name(hidden),
            "units": hidden.units,
            "unit": hidden.effect.unit,
            "relative": hidden.effect.relative,
            "deviation": hidden.deviation,
            "value": self._physical(hidden),
        }

    def _physical(self, hidden: Hidden, *, is_there: bool = True) -> float:
        """Physical value: over the data sheet's where the effect is relative, else in its unit; scatter included.

        That of the car without any effect where ``is_there`` is false.
        """
        fields = hidden.effect.field.split(",")
        if fields == [""]:
            return is_there * hidden.deviation + (1.0 if hidden.effect.relative else 0.0)
        name = fields[hidden.place] if len(fields) > 1 else fields[0]
        car, chain = self.car, self.chain
        if is_there:
            car, chain = self.car_in(next(s for s in SIX + HELD_OUT if self.draw.only_in in ("", s.name)))
        store: Mapping[str, Any] = chain if name.startswith("chain:") else car
        name = name.removeprefix("chain:")
        nominal = np.atleast_1d((SENSOR_SHEET | DATA_SHEET)[name].nominal)
        # what acts on an axle changes both of its wheels
        place = hidden.place * len(nominal) // hidden.effect.places if hidden.effect.places > 1 else 0
        value = float(np.atleast_1d(store[name])[place])
        return value / float(nominal[place]) if hidden.effect.relative else value

    def separation(self, rivals: Sequence[str]) -> list[dict[str, float | None]]:
        """For each hidden effect: expected log evidence against each rival; None for a rival unknown here."""
        known = {effect.name: effect for effect in EFFECTS}
        wanted = [known[name] for name in rivals if name in known]
        result: list[dict[str, float | None]] = []
        for hidden in self.draw.effects:
            others = [effect for effect in wanted if effect.name != hidden.effect.name]
            found = separation(self._truth(hidden), others)
            result.append({name: found.get(name) for name in rivals if name != hidden.effect.name})
        return result

    def value_stds(self) -> list[float]:
        """For each hidden effect the smallest standard deviation of its physical value, over that value."""
        return [
            size_std(self._truth(hidden)) * abs(1.0 - self._physical(hidden, is_there=False) / self._physical(hidden))
            for hidden in self.draw.effects
        ]

    def _truth(self, hidden: Hidden) -> Truth:
        effect = (hidden.effect, hidden.deviation, hidden.place)
        return truth_of(effect, self.car, self.chain, self.scripts()[0], self.draw.missing)

    def torque_courses(self) -> dict[str, list[list[float]]]:
        """Manoeuvre -> (n, 4) as lists: relative change of the brake torques by the unknown term; none without one."""
        if self.draw.unknown is None:
            return {}
        kind, size = self.draw.unknown
        mine, held_out = self.scripts()
        result = {}
        for script in (*mine, *held_out):
            columns = simulate(as_record(self.car_in(script)[0]), script.drive())
            result[script.name] = torque_course(columns, kind.number, size).round(9).tolist()
        return result

    def write(self, folder: Path, sealed: Path) -> None:
        """Write ``folder`` (logs, held_out, map, vehicle file, seal) and, apart, ``sealed`` (salt and label)."""
        seal(self.label(), folder / "seal.sha256", sealed)
        self._write_data(folder, ())

    def write_further(self, folder: Path, scripts: Sequence[Script], channel: str) -> None:
        """The same case with more data: further manoeuvres, and a channel that nobody had recorded ("" for none)."""
        missing = tuple(name for name in self.loggers.missing if name != channel)
        self.loggers = replace(self.loggers, missing=missing)
        self._write_data(folder, scripts)

    def _write_data(self, folder: Path, further: Sequence[Script]) -> None:
        mine, held_out = self.scripts()
        logs = self.recorded((*mine, *further))
        write_logs(folder / "logs", self.format, logs)
        write_logs(folder / "held_out", self.format, self.recorded(held_out))
        messages = next(iter(logs.values()))
        _write_yaml(folder / "channels.yaml", channel_map(self.format, messages))
        _write_yaml(folder / "vehicle.yaml", vehicle_file())
        if self.format == "blf":
            (folder / "car.dbc").write_text(database(messages), encoding="ascii")


def _write_yaml(path: Path, content: Mapping[str, Any]) -> None:
    from ruamel.yaml import YAML

    with path.open("w", encoding="utf-8") as file:
        YAML().dump(dict(content), file)


def write_manifest(folder: Path, facts: Mapping[str, Any]) -> None:
    """What anybody may know of the set: seed, number of cases, generator, form differences."""
    content = dict(facts) | {"version": VERSION, "form_differences": list(FORM_DIFFERENCES)}
    (folder / "manifest.json").write_text(json.dumps(content, indent=1), encoding="utf-8")
