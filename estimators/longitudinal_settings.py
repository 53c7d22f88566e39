"""Settings that the filters of longitudinal motion share: what they know of their sensors."""

from estimators.wheel_speed_settings import teeth_field, window_field
from signals.quantities import FileModel, parameter


class LongitudinalSettings(FileModel):
    """Pitch of the accelerometer, delay of the wheel speeds, age at which an input is lost."""

    pitch_gradient: float = parameter(
        "rad s^2/m",
        0.0,
        low=0.0,
        high=0.05,
        neutral=0.0,
        description="nose-down pitch per deceleration; a pitched accelerometer feels a part of gravity",
        source="assumed: a car that does not pitch, as in the document",
    )
    wheel_speed_teeth: float | None = teeth_field()
    wheel_speed_window: float | None = window_field()
    input_timeout: float = parameter(
        "s", 0.1, low=0.002, high=5.0, description="time without a good sample after which an input is lost"
    )
