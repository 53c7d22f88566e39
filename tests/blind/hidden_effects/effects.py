"""Effects that can be hidden and that the shipped set of manoeuvres excites.

Names and equations are those of the published catalogue; sizes are drawn in units of ``scatter``, the deviation that an
ordinary car may have.
"""

from hidden_effects.chassis_effects import HYDRAULICS_AND_CHASSIS
from hidden_effects.hidden_effect import SMALLEST_UNITS, HiddenEffect
from hidden_effects.road_sensor_effects import ROAD_TO_SENSOR
from hidden_effects.tyre_brake_effects import TYRE_AND_BRAKE

__all__ = ["EFFECTS", "SMALLEST_UNITS", "HiddenEffect"]

EFFECTS: tuple[HiddenEffect, ...] = (*TYRE_AND_BRAKE, *HYDRAULICS_AND_CHASSIS, *ROAD_TO_SENSOR)
