"""Settings that the filters of longitudinal motion share: what they know of their sensors."""

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
    wheel_speed_teeth: float | None = parameter(
        "1",
        None,
        low=0.0,
        high=512.0,
        description="teeth of the tone rings, 0 where wheel speeds have no delay; left out: sensors.wheel_speed.teeth "
        "of the vehicle file, 0 if it has none",
    )
    wheel_speed_window: float | None = parameter(
        "s",
        None,
        low=0.0,
        high=0.1,
        description="time over which edges make a speed; left out: sensors.wheel_speed.window of the vehicle file",
    )
    input_timeout: float = parameter(
        "s", 0.1, low=0.002, high=5.0, description="time without a good sample after which an input is lost"
    )
