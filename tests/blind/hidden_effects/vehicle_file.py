"""The vehicle file that the user has: the nominal car with the scatter of its parameters."""

from typing import Any

import numpy as np

from hidden_effects.car import DATA_SHEET, scatter_table
from hidden_effects.sensors import CHANNELS, SENSOR_SHEET

BASE_CAR = "ekf_car"
SHORTEST_WINDOW_S = 0.001


def _tyre(rear: bool) -> dict[str, Any]:
    sheet = {name: number.nominal for name, number in DATA_SHEET.items()}
    peak = sheet["peak_x"]
    assert isinstance(peak, tuple)
    return {
        "longitudinal": {
            "peak_friction": peak[2 if rear else 0],
            "shape": sheet["shape_x"],
            "stiffness": _first(sheet["stiffness_x"]),
        },
        "lateral": {
            "peak_friction": 1.0,
            "shape": sheet["shape_y"],
            "stiffness": sheet["stiffness_y_rear" if rear else "stiffness_y_front"],
        },
        "nominal_load": sheet["nominal_load"],
        "pneumatic_trail": sheet["pneumatic_trail"],
        "relaxation_length_longitudinal": sheet["relaxation_x"],
        "relaxation_length_lateral": sheet["relaxation_y"],
    }


def _first(value: float | tuple[float, ...]) -> float:
    return value[0] if isinstance(value, tuple) else value


def _sensor_scatter() -> dict[str, tuple[float, str]]:
    paths = {
        "sensors.longitudinal_acceleration.offset": "ax_offset",
        "sensors.lateral_acceleration.offset": "ay_offset",
        "sensors.longitudinal_acceleration.scale": "ax_scale",
        "sensors.lateral_acceleration.scale": "ay_scale",
        "sensors.inertial.mounting_yaw": "misalignment",
        "sensors.yaw_rate.offset": "gyro_offset",
        "sensors.yaw_rate.scale": "gyro_scale",
        "sensors.brake_pressure.scale": "pressure_scale",
        "sensors.brake_pressure.offset": "pressure_offset",
    }
    return {
        path: (SENSOR_SHEET[name].scatter, "relative" if SENSOR_SHEET[name].relative else "absolute")
        for path, name in paths.items()
    }


def vehicle_file() -> dict[str, Any]:
    """Content of the user's vehicle file."""
    noisy = {
        "longitudinal_acceleration": "longitudinal_acceleration",
        "lateral_acceleration": "lateral_acceleration",
        "yaw_rate": "yaw_rate",
        "roll_rate": "roll_rate",
        "pitch_rate": "pitch_rate",
        "master_pressure": "master_pressure",
        "brake_pressure": "brake_pressure_fl",
        "pedal_force": "pedal_force",
        "steering_wheel_angle": "steering_wheel_angle",
    }
    sensors = {
        section: {"noise": CHANNELS[name].noise, "resolution": CHANNELS[name].resolution}
        for section, name in noisy.items()
    }
    sensors["wheel_speed"] = {"window": SHORTEST_WINDOW_S}  # the hidden car's wheel speeds are read at their instants
    area, drag, side = (
        float(np.array(DATA_SHEET[name].nominal)) for name in ("frontal_area", "drag_area", "side_area")
    )
    # air from the side meets the drag too
    air = {
        "frontal_area": area,
        "drag_coefficient": drag / area,
        "side_force_coefficient": (side - drag) / area,
    }
    scatter = scatter_table() | _sensor_scatter()
    return {
        "format": 1,
        "name": "car_under_test",
        "description": "nominal car of the data sheet; every parameter may be off within its scatter",
        "extends": BASE_CAR,
        "tyres": {"front": _tyre(False), "rear": _tyre(True)},
        "aerodynamics": air,
        "sensors": sensors,
        "scatter": {path: {"std": std, "kind": kind} for path, (std, kind) in scatter.items()},
    }
