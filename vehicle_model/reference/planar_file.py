"""Section of a vehicle file that the planar car of the vehicle-state document needs beyond the other sections."""

from signals.quantities import FileModel, parameter


class Planar(FileModel):
    """Body motion and rolling resistance of the planar car (vehicle-state document 2.5 to 2.7).

    What is left out follows from the section ``suspension``.
    """

    pitch_stiffness: float | None = parameter(
        "N m/rad",
        None,
        low=1e3,
        high=1e7,
        description="of both sides; left out: from springs and wheelbase",
        source="from the suspension",
    )
    pitch_damping: float | None = parameter(
        "N m s/rad",
        None,
        low=0.0,
        high=1e6,
        description="of both sides; left out: from dampers and wheelbase",
        source="from the suspension",
    )
    roll_stiffness: float | None = parameter(
        "N m/rad",
        None,
        low=1e3,
        high=1e7,
        description="of both axles; left out: from springs, anti-roll bars and tracks",
        source="from the suspension",
    )
    roll_damping: float | None = parameter(
        "N m s/rad",
        None,
        low=0.0,
        high=1e6,
        description="of both axles; left out: from dampers and tracks",
        source="from the suspension",
    )
    rolling_resistance_speed_factor: float = parameter(
        "s^2/m^2",
        0.0,
        low=0.0,
        high=1e-3,
        neutral=0.0,
        description="k_fv in f = f_0 + k_fv v^2; f_0 is wheels.*.rolling_resistance",
    )
