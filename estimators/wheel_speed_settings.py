"""Keys by which an estimator knows how its wheel speeds are measured."""

from typing import Any

from signals.quantities import parameter


def teeth_field() -> Any:
    """Field of a settings model: teeth of the tone rings."""
    return parameter(
        "1",
        None,
        low=0.0,
        high=512.0,
        description="teeth of the tone rings, 0 where wheel speeds have no delay; left out: sensors.wheel_speed.teeth "
        "of the vehicle file, 0 if it has none",
    )


def window_field() -> Any:
    """Field of a settings model: time over which the edges of a tone ring make a speed [s]."""
    return parameter(
        "s",
        None,
        low=0.0,
        high=0.1,
        description="time over which edges make a speed; left out: sensors.wheel_speed.window of the vehicle file",
    )
