"""Structural isolability against faultdiagnosistoolbox, an independent implementation."""

import faultdiagnosistoolbox as fdt
import numpy as np
import pytest

from model_diagnosis.evidence.structure import (
    Equation,
    are_forced_together,
    is_isolable,
    separating_sensor,
    structural_model,
)
from signals.wheels import WHEELS

BASE = [
    *(f"wheel_speed_{wheel}" for wheel in WHEELS),
    *(f"brake_pressure_{wheel}" for wheel in WHEELS),
    "longitudinal_acceleration",
    "lateral_acceleration",
    "yaw_rate",
    "steering_wheel_angle",
    "drive_torque_f",
    "drive_torque_r",
]
EFFECTS = (
    "brake_pad_friction",
    "pressure_sensor_scale",
    "mass_change",
    "aero_drag",
    "road_grade",
    "accelerometer_offset",
    "wheel_radius_change",
    "tyre_friction",
    "tyre_cornering_stiffness",
    "steering_ratio",
    "gyro_scale",
    "yaw_inertia",
    "rolling_resistance",
)


def _toolbox_matrix(equations: list[Equation]) -> np.ndarray:
    """Isolability matrix of the toolbox: [i, j] = 1 where effect i cannot be isolated from effect j."""
    unknowns = sorted({name for equation in equations for name in equation.unknowns})
    model = fdt.DiagnosisModel(
        {
            "type": "VarStruc",
            "x": unknowns,
            "f": list(EFFECTS),
            "z": ["z"],
            "rels": [[*equation.unknowns, *(equation.effects & set(EFFECTS)), "z"] for equation in equations],
        }
    )
    # the toolbox returns 1 where the fault in the row cannot be told from that in the column
    return np.asarray(model.IsolabilityAnalysis(permute=False))


@pytest.mark.parametrize(
    "channels",
    [
        BASE,
        [*BASE, "speed"],
        [name for name in BASE if not name.startswith("drive_torque")],
        [name for name in BASE if name not in ("longitudinal_acceleration", "lateral_acceleration")],
        [*BASE, *(f"reference_pressure_{wheel}" for wheel in WHEELS)],
    ],
)
def test_isolability_equals_the_toolbox(channels: list[str]) -> None:
    equations = structural_model(channels)
    expected = _toolbox_matrix(equations)
    found = np.array([[not is_isolable(equations, one, other) for other in EFFECTS] for one in EFFECTS])
    np.testing.assert_array_equal(found, expected.astype(bool))


def test_pads_and_pressure_sensors_are_one_group_until_a_second_pressure_is_measured() -> None:
    assert are_forced_together(BASE, "brake_pad_friction", "pressure_sensor_scale")
    assert separating_sensor(BASE, "brake_pad_friction", "pressure_sensor_scale") == "reference_pressure"
    added = [*BASE, *(f"reference_pressure_{wheel}" for wheel in WHEELS)]
    assert not are_forced_together(added, "brake_pad_friction", "pressure_sensor_scale")


def test_effects_of_different_terms_are_never_forced_together() -> None:
    assert not are_forced_together(BASE, "brake_pad_friction", "mass_change")
