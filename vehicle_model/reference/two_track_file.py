"""Section of a vehicle file that the two-track car of the vertical-load document needs beyond the other sections."""

from signals.quantities import FileModel, parameter

_FROM_CAR = "from the body and the suspension"


class TwoTrackSection(FileModel):
    """Roll about a fixed axis and linear cornering stiffness (vertical-load document, sections 2 and 5).

    What is left out follows from the sections ``body``, ``wheels`` and ``suspension``; total roll stiffness and damping
    are ``planar.roll_stiffness`` and ``planar.roll_damping``.
    """

    cornering_stiffness_front: float | None = parameter(
        "N/rad",
        None,
        low=1e3,
        high=1e6,
        description="C_af of one front tyre; left out: slope of the tyre at its static load",
        source="from the tyre",
    )
    cornering_stiffness_rear: float | None = parameter(
        "N/rad", None, low=1e3, high=1e6, description="C_ar of one rear tyre, likewise", source="from the tyre"
    )
    sprung_mass: float | None = parameter(
        "kg", None, low=50.0, high=2e4, description="m_s; left out: without the wheels", source=_FROM_CAR
    )
    roll_centre_height: float | None = parameter(
        "m",
        None,
        low=0.0,
        high=2.0,
        description="h_r of the roll axis below the centre of gravity; left out: from suspension.*.roll_centre_height",
        source=_FROM_CAR,
    )
    roll_axis_inertia: float | None = parameter(
        "kg m^2",
        None,
        low=10.0,
        high=1e5,
        description="I_x about the roll axis; left out: body.roll_inertia moved to the axis",
        source=_FROM_CAR,
    )
    front_roll_share: float | None = parameter(
        "1",
        None,
        low=0.0,
        high=1.0,
        description="lambda_f of the roll moment that the front axle carries; left out: its share of the weight",
        source="vertical-load document 2.3, assumed",
    )
    road_roll_moment: float = parameter(
        "N m",
        0.0,
        low=-2e4,
        high=2e4,
        neutral=0.0,
        description="M_road: moment of the road on the body, positive lifts the left side (vertical-load document 4.1)",
    )
