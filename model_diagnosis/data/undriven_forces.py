"""Forces that were measured without what makes them: no replay of a car can predict them."""

from collections.abc import Sequence

from model_diagnosis.data.level_checks import without
from model_diagnosis.data.rig import is_on_rig
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.result import DataFault

_STEERING = ("steering_wheel_angle", "road_wheel_angle", "steering_command")
_BRAKES = ("brake_pressure_", "master_pressure", "drive_torque_", "engine_torque")


def check_undriven_forces(manoeuvres: Sequence[Manoeuvre]) -> tuple[list[DataFault], list[Manoeuvre]]:
    """Leave out wheel forces whose cause no channel tells, and name that channel as missing.

    A car's slips follow from steering, brakes and drive. Those of one wheel on a rig are set, and drive its forces.
    """
    if is_on_rig(manoeuvres):
        return [], list(manoeuvres)
    channels = {name for manoeuvre in manoeuvres for name in manoeuvre.channels}
    faults: list[DataFault] = []
    left_out: list[str] = []
    for start, causes, words in (
        ("lateral_force_", _STEERING, "a steering angle"),
        ("longitudinal_force_", _BRAKES, "brake pressures or drive torque"),
    ):
        forces = sorted(name for name in channels if name.startswith(start))
        if not forces or any(name.startswith(causes) for name in channels):
            continue
        left_out += forces
        message = f"{', '.join(forces)} cannot be replayed without {words}, and is not used"
        faults.append(DataFault(kind="missing_channel", channel=causes[0].rstrip("_"), message=message))
    return faults, [without(manoeuvre, left_out) for manoeuvre in manoeuvres]
