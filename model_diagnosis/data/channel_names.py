"""Which of our signals a column of a log is, by its name as other tools write it, English or German."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from signals.measured.channel_map import channel_units
from signals.measured.unit_texts import unit_in
from signals.units import parse_unit
from signals.wheels import WHEELS

_WHEEL_WORDS = {
    "fl": r"c?fl|lf|front_?left|left_?front|vl|vorne_?links",
    "fr": r"c?fr|rf|front_?right|right_?front|vr|vorne_?rechts",
    "rl": r"c?rl|lr|rear_?left|left_?rear|hl|hinten_?links",
    "rr": r"c?rr|rear_?right|right_?rear|hr|hinten_?rechts",
}
_AXLE_WORDS = {"f": r"f|front|va|fa", "r": r"r|rear|ha|ra"}

_NOTHING = r"(?!)"
_OF_A_WHEEL: dict[str, tuple[str, ...]] = {
    "wheel_speed": (
        r"(wheel|whl|rad).*(speed|spd|vel|drehz|geschw|rot|omega)|wss|rotv|raddrehzahl",
        r"(^|_)(wheel|whl|ws|omega|w|n|v|rad|speed|spd)$",
    ),
    "brake_pressure": (
        r"(brake|brk|brems|wheel|whl|rad|cal|caliper|zyl).*(press|druck)|(^|_)p_?(brk|brake|wb|cal|whl|rad)(_|$)",
        r"(^|_)(p|press|pressure|druck)$",
    ),
    "vertical_load": (r"(^|_)fz(_|$)|vert.*(force|load)|wheel_?load|radlast|frc_?c?_z$",),
    "lateral_force": (r"(^|_)fy(_|$)|lat.*force|seitenkraft|frc_?c?_y$",),
    "longitudinal_force": (r"(^|_)fx(_|$)|long.*force|frc_?c?_x$",),
    "valve_inlet": (r"(inlet|iv|valve_in|einlass)",),
    "valve_outlet": (r"(outlet|ov|valve_out|auslass)",),
    "road_wheel_angle": (_NOTHING, _NOTHING, r"steer.*ang|delta|road_?wheel"),  # rather that of both wheels
}
_OF_AN_AXLE: dict[str, tuple[str, ...]] = {"drive_torque": (r"(drive|axle|shaft|antrieb).*(tor|trq|moment)",)}
_OF_THE_CAR: dict[str, tuple[str, ...]] = {
    "speed": (
        r"(^|_)(vx|v_x)($|_)|long.*(speed|vel)|vel.*_x$",
        r"(veh|vehicle|car|gps|gnss|ground|pose)_?(speed|spd|vel|velocity|v)($|_)|v_?veh|geschw",
        r"(^|_)(speed|spd|velocity|v)$|^(speed|velocity)",
    ),
    "lateral_speed": (r"(^|_)(vy|v_y)($|_)|lat.*(speed|vel)|vel.*_y$",),
    "yaw_rate": (r"yaw.*(rate|vel|speed)|gierr|gyro.*z|(rate|omega|ang_?vel)_z$|psi_?(p|dot)$", r"^(omega|r|gz|wz)$"),
    "roll_rate": (r"roll.*(rate|vel)|gyro.*x|(rate|omega|ang_?vel)_x$|wankr",),
    "pitch_rate": (r"pitch.*(rate|vel)|gyro.*y|(rate|omega|ang_?vel)_y$|nickr",),
    "yaw_angle": (r"heading|yaw_?(angle|ang)?$|azimuth|gierwinkel", r"^(psi|phi)$"),
    "longitudinal_acceleration": (r"(^|_)(ax|a_x|acc(el(eration)?)?_?x|x_?acc(el)?)(_|$)|long.*acc|acc.*long|laengsb",),
    "lateral_acceleration": (r"(^|_)(ay|a_y|acc(el(eration)?)?_?y|y_?acc(el)?)(_|$)|lat.*acc|acc.*lat|querb",),
    "vertical_acceleration": (r"(^|_)(az|a_z|acc(el(eration)?)?_?z|z_?acc(el)?)(_|$)|vert.*acc|acc.*vert|vertikalb",),
    "steering_wheel_angle": (
        r"(steer|stw|swa|sas|hand).*(wheel|whl).*(ang|pos)|hand_?wheel|lenk.*wink|^swa$|(steer|sas|swa|lws|eps).*ang",
        r"^steer(ing)?$",
    ),
    "road_wheel_angle": (r"road_?wheel.*ang|(front|axle).*steer|radeinschlag", r"(^|_)delta(_f)?$"),
    "side_slip_angle": (r"side_?slip|body_?slip|schwimmwinkel|(^|_)beta(_|$)",),
    "master_pressure": (
        r"(master|mcp|tmc|hauptzyl|thz).*|p_?(mc|tmc|thz)($|_)",
        r"(brake|brk|brems).*(press|druck)|p_?(brake|brk)$",
        r"brake_?ped",
    ),
    "pedal_force": (r"pedal.*(force|kraft)|(brake|brk).*ped.*force",),
    "brake_switch": (r"(brake|brk).*(switch|light|lamp|pressed)|(^|_)bls(_|$)|bremslicht",),
    "engine_torque": (r"(eng|engine|mot|motor).*(tor|trq|tq|moment)",),
    "engine_speed": (r"(eng|engine|mot|motor).*(speed|rpm|spd|drehz)|^(rpm|n_?eng|n_?mot)$",),
    "gear": (r"(^|_)(gear|gang)$|^(gear|gang)|act.*gear",),
    "pump": (r"(^|_)(pump|pumpe)($|_(on|active|ein|cmd)$)",),
    "road_grade": (r"(road|long).*(grade|slope|incline)|steigung|^grade$",),
    "road_bank": (r"(road|cross).*(bank|slope)|^bank(ing)?$|querneigung",),
}
_OF_A_RIG: dict[str, tuple[str, ...]] = {
    "speed": (r"^(v|speed|belt_?speed|road_?speed)$",),
    "slip_ratio": (r"^(sl|kappa|slip_?ratio|long.*slip)$", r"^sr$"),
    "slip_angle": (r"^(sa|alpha|slip_?angle)$",),
    "vertical_load": (r"^(fz|.*vertical_?(force|load))$",),
    "longitudinal_force": (r"^(fx|.*longitudinal_?force)$",),
    "lateral_force": (r"^(fy|.*lateral_?force)$",),
}
_LEAST_OF_A_RIG = 4

_NEVER = r"valid|status|qual|flag|counter|checksum|alive|error|offset|limit|accelerator|(^|_)(cnt|crc|std|sigma|err)"
_NOT: dict[str, str] = {
    "wheel_speed": r"slip|tor|force|acc|ang|steer|count|puls|pos|temp|press",
    "brake_pressure": r"ty(re|ire)|tire|reifen|temp",
    "speed": r"wheel|whl|(^|_)wind|lat|eng|mot|yaw|gier|roll|pitch|steer|fan|pump|ang|vert|acc|rot|rad_|gear",
    "lateral_speed": r"(^|_)wind|acc|ang|yaw",
    "yaw_rate": r"acc",
    "yaw_angle": r"acc|rate|vel|speed|steer",
    "longitudinal_acceleration": r"ang|wheel|whl|yaw|ped",
    "lateral_acceleration": r"ang|wheel|whl|yaw|ped",
    "vertical_acceleration": r"ang|wheel|whl|yaw|ped",
    "steering_wheel_angle": r"rate|vel|speed|tor|trq|acc|road|mom",
    "road_wheel_angle": r"rate|vel|speed|tor|trq|acc",
    "master_pressure": r"ty(re|ire)|tire|reifen|vac|unterdr|temp|clutch|kuppl|switch|light",
    "gear": r"ratio|box|temp|target|rear",
    "side_slip_angle": r"rate",
    "pump": r"fuel|oil|water|cool|air",
    "valve_inlet": r"temp|press|manifold",
    "valve_outlet": r"temp|press",
}
_SECOND_HAND = r"filt|smooth|(^|_)(ref|est|calc|cmd|target|tgt|des|soll|set|req|sim|raw|mdl|model)(_|$)"
"""Words of what is computed or commanded: taken where nothing measured has the name."""
_SECOND_HAND_RANK = 10.0


@dataclass(frozen=True)
class NamedColumn:
    """A column, its unit where name or log tell one, and how well its name fits the signal (0 best)."""

    source: str
    unit: str | None
    rank: float


def signals_by_name(names: Sequence[str], units: Mapping[str, str]) -> dict[str, list[NamedColumn]]:
    """Signal -> the columns that its name fits, the best first; each column stands first for one signal at most.

    Parameters
    ----------
    units : column -> unit as the log writes it
    """
    fitting = [
        (column.rank, place, signal, column)
        for place, source in enumerate(names)
        for signal, column in _signals_of(source, units.get(source))
    ]
    rig = _of_a_rig(names, units)
    if rig:
        return rig
    found: dict[str, list[NamedColumn]] = {}
    taken: set[str] = set()
    for _, _, signal, column in sorted(fitting, key=lambda entry: entry[:2]):
        if signal not in found and column.source not in taken:
            found[signal] = [column]
            taken.add(column.source)
    for _, _, signal, column in sorted(fitting, key=lambda entry: entry[:2]):
        if column.source not in taken:
            found[signal].append(column)
    order = list(channel_units())
    return {signal: found[signal] for signal in sorted(found, key=order.index)}


def plain_name(source: str) -> tuple[str, str | None]:
    """Name in small letters with underscores, and what stands in brackets at its end."""
    match = re.fullmatch(r"(.*?)\s*[\[(]([^\])]*)[\])]\s*", source)
    text, unit = (match.group(1), match.group(2)) if match else (source, None)
    snake = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", text).lower()
    return re.sub(r"[^a-z0-9]+", "_", snake).strip("_"), unit


def _signals_of(source: str, told: str | None) -> Iterable[tuple[str, NamedColumn]]:
    plain, bracket = plain_name(source)
    if re.search(_NEVER, plain):
        return
    rest, wheel = _without(plain, _WHEEL_WORDS)
    if wheel:
        kinds = {f"{kind}_{wheel}": (kind, patterns) for kind, patterns in _OF_A_WHEEL.items()}
        if wheel == "fl":
            kinds["road_wheel_angle"] = kinds["road_wheel_angle_fl"]
    else:
        kinds = {kind: (kind, patterns) for kind, patterns in _OF_THE_CAR.items()}
        bare, axle = _without(plain, _AXLE_WORDS)
        if axle:
            kinds |= {f"{kind}_{axle}": (kind, patterns) for kind, patterns in _OF_AN_AXLE.items()}
        rest = bare if axle and re.search(_OF_AN_AXLE["drive_torque"][0], bare) else plain
    for signal, (kind, patterns) in kinds.items():
        if signal not in channel_units() or re.search(_NOT.get(kind, _NOTHING), rest):
            continue
        column = _column(source, signal, patterns, rest, bracket or told)
        if column is not None:
            yield signal, column


def _column(source: str, signal: str, patterns: Sequence[str], plain: str, unit: str | None) -> NamedColumn | None:
    """The column as this signal, with the first pattern that its name fits; None where unit or name do not."""
    rank = next((n for n, pattern in enumerate(patterns) if re.search(pattern, plain)), None)
    if rank is None:
        return None
    known = None if unit is None else unit_of(signal, unit)
    if unit and known is None and parse_unit(unit) is not None:
        return None
    penalty = _SECOND_HAND_RANK if re.search(_SECOND_HAND, plain) else 0.0
    return NamedColumn(source, known, rank + penalty + (0.0 if known else 0.5))


def unit_of(signal: str, text: str) -> str | None:
    """A unit text of a log as a channel map writes it for this signal; None where the signal has no such unit."""
    quantities = [channel_units()[signal], *(["m/s"] if signal.startswith("wheel_speed_") else [])]
    return next((unit for quantity in quantities if (unit := unit_in(text, quantity)) is not None), None)


def _without(plain: str, words: Mapping[str, str]) -> tuple[str, str]:
    """A name without its word for a wheel or an axle, and which one; "" where it has none."""
    for which, pattern in words.items():
        rest, count = re.subn(rf"(?:^|_)(?:{pattern})(?=_|$)", "", plain)
        if count:
            return rest.strip("_"), which
    return plain, ""


def _of_a_rig(names: Sequence[str], units: Mapping[str, str]) -> dict[str, list[NamedColumn]]:
    """Channels of one wheel on a rig, which stands for the front left one; nothing where too few are there."""
    found: dict[str, list[NamedColumn]] = {}
    for kind, patterns in _OF_A_RIG.items():
        signal = kind if kind == "speed" else f"{kind}_{WHEELS[0]}"
        for source in names:
            plain, bracket = plain_name(source)
            column = _column(source, signal, patterns, plain, bracket or units.get(source))
            if column is not None:
                found.setdefault(signal, []).append(column)
    if len(found.keys() - {"speed"}) < _LEAST_OF_A_RIG:
        return {}
    return {signal: sorted(columns, key=lambda column: column.rank) for signal, columns in found.items()}
