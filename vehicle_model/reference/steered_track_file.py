"""Section of a vehicle file that the four-state car of the force document needs beyond the other sections."""

from signals.quantities import FileModel, parameter


class SteeredTrackSection(FileModel):
    """Single track with linear tyres behind a steering actuator (force document, sections 2.1 and 5)."""

    cornering_stiffness_front: float | None = parameter(
        "N/rad",
        None,
        low=100.0,
        high=1e6,
        description="C_f of the front axle; left out: slope of its tyres at their static load",
        source="from the tyres",
    )
    cornering_stiffness_rear: float | None = parameter(
        "N/rad", None, low=100.0, high=1e6, description="C_r of the rear axle, likewise", source="from the tyres"
    )
    steering_time_constant: float = parameter(
        "s", 0.1, low=0.001, high=2.0, description="tau of the steering actuator", source="force document 5, assumed"
    )
