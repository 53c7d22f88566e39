"""Which frame carries which signal of ours, and what has to be carried for a closed loop."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from bench.codec.database import DbcMessage, DbcSignal, load_database, shipped_database
from signals.errors import InputError
from signals.wheels import WHEELS

NEEDED_FROM_ECU: tuple[str, ...] = (
    *(f"valve_inlet_{wheel}" for wheel in WHEELS),
    *(f"valve_outlet_{wheel}" for wheel in WHEELS),
    "pump",
)
NEEDED_BY_ECU: tuple[str, ...] = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)
"""Without these there is no closed loop; everything else may be absent from an ECU's own database."""

AGE_GROUPS: dict[str, tuple[str, ...]] = {
    "age_wheel_speed": tuple(f"wheel_speed_{wheel}" for wheel in WHEELS),
    "age_wheel_edges": tuple(f"wheel_edge_{what}_{wheel}" for what in ("count", "time") for wheel in WHEELS),
    "age_inertial": tuple(
        [f"{axis}_acceleration" for axis in ("longitudinal", "lateral", "vertical")]
        + [f"{axis}_rate" for axis in ("yaw", "roll", "pitch")]
    ),
    "age_brake": ("pedal_force", "brake_switch", "master_pressure"),
    "age_wheel_pressure": tuple(f"brake_pressure_{wheel}" for wheel in WHEELS),
    "age_powertrain": ("engine_torque", "engine_speed", "gearbox_speed", "gear", "drive_torque_f", "drive_torque_r"),
    "age_vehicle_status": ("steering_wheel_angle", "steering_command", "road_wheel_angle", "ignition"),
    "age_valve_pump": NEEDED_FROM_ECU,
    "age_abs_status": ("abs_active", "abs_lamp", "ebd_active"),
}
"""Signals whose frames an age of block "bus_age" watches; the oldest of them counts."""


@dataclass(frozen=True)
class Carried:
    """A signal of ours in a message: ours = (raw × dbc.scale + dbc.offset) × scale + offset."""

    name: str
    signal: DbcSignal
    scale: float
    offset: float


@dataclass(frozen=True)
class Carrier:
    """A message on the bus, who sends it, and the signals of ours in it."""

    message: DbcMessage
    from_ecu: bool
    cycle_ms: int
    offset_ms: int
    data_ids: tuple[int, ...]
    carried: tuple[Carried, ...]


@dataclass(frozen=True)
class Layout:
    """All messages that the bench sends or understands, by ascending identifier."""

    path: str
    bit_rate: int
    carriers: tuple[Carrier, ...]

    def sent_by(self, role: str) -> tuple[Carrier, ...]:
        """Messages that the bench ("bench") or the ECU ("ecu") sends, or all of them ("all")."""
        if role == "all":
            return self.carriers
        return tuple(carrier for carrier in self.carriers if carrier.from_ecu == (role == "ecu"))

    def names(self, role: str) -> tuple[str, ...]:
        """Signals of ours in the messages of a role."""
        return tuple(carried.name for carrier in self.sent_by(role) for carried in carrier.carried)

    def require(self, role: str, names: Iterable[str], purpose: str) -> None:
        """Refuse the database if the messages of a role lack one of the signals.

        Raises
        ------
        InputError
            Listing every missing signal and, where the shipped database has it, its message there.
        """
        present = set(self.names(role))
        missing = [name for name in names if name not in present]
        if not missing:
            return
        sender = {"bench": "the bench", "ecu": "the ECU", "all": "anybody"}[role]
        raise InputError(
            f"{self.path}: no message sent by {sender} carries {', '.join(missing)} (needed {purpose})",
            allowed=_where_shipped(missing, self.path),
            mend="add the message to the database, or name its signals in a mapping file (docs/bus.md)",
        )


def _where_shipped(missing: Sequence[str], path: str) -> str:
    if Path(path) == shipped_database():
        return ""
    carriers = {s.name: m for m in load_database().messages for s in m.signals}
    found = {carriers[name].name: carriers[name].identifier for name in missing if name in carriers}
    return "as in brake_bus.dbc, message " + ", ".join(f"{name} (0x{number:X})" for name, number in found.items())
