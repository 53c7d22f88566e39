"""Sections of a vehicle file that describe body, axles, wheels, steering and aerodynamics."""

from typing import Literal

from pydantic import Field, model_validator

from signals.errors import FieldError
from signals.quantities import FileModel, parameter
from vehicle_model import inertias
from vehicle_model.steering_file import SteeringMap

_ASSUMED = "assumed: usual for a passenger car"


class Body(FileModel):
    """The whole car as one rigid body in its rest position."""

    mass: float = parameter("kg", low=100.0, high=10000.0, description="mass of the whole car with its load")
    wheelbase: float = parameter("m", low=0.5, high=10.0, description="distance of the axles")
    centre_of_gravity_to_front_axle: float = parameter(
        "m", low=0.05, high=10.0, description="distance of the centre of gravity behind the front axle"
    )
    centre_of_gravity_height: float = parameter("m", low=0.0, high=3.0, description="height over ground at rest")
    length: float = parameter("m", low=0.5, high=20.0, description="overall length, for the inertia estimates")
    width: float = parameter("m", low=0.3, high=4.0, description="overall width, for the inertia estimates")
    height: float = parameter("m", low=0.3, high=5.0, description="overall height, for the inertia estimates")
    yaw_inertia_rule: Literal["wheelbase_times_length", "wheelbase_squared"] = "wheelbase_times_length"
    roll_inertia: float | None = parameter(
        "kg m^2", None, low=1.0, high=1e5, description="of the whole car about its centre of gravity", source="eq. 116"
    )
    pitch_inertia: float | None = parameter(
        "kg m^2", None, low=1.0, high=1e5, description="of the whole car about its centre of gravity", source="eq. 116"
    )
    yaw_inertia: float | None = parameter(
        "kg m^2", None, low=1.0, high=1e5, description="of the whole car about its centre of gravity", source="eq. 116"
    )

    @model_validator(mode="after")
    def _estimate_inertias(self) -> "Body":
        """Inertias that the file leaves out (eq. 116; its printed L L is read as wheelbase times length)."""
        if self.centre_of_gravity_to_front_axle >= self.wheelbase:
            raise FieldError(
                "behind the rear axle",
                at=("centre_of_gravity_to_front_axle",),
                allowed=f"less than the wheelbase of {self.wheelbase} m",
            )
        estimated = {
            "roll_inertia": inertias.roll_inertia(self.mass, self.width, self.height),
            "pitch_inertia": inertias.pitch_inertia(self.mass, self.length, self.height),
            "yaw_inertia": inertias.yaw_inertia(self.mass, self.wheelbase, self.length, self.yaw_inertia_rule),
        }
        for name, value in estimated.items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)
        return self


class Axle(FileModel):
    """What the two wheels of an axle share."""

    track: float = parameter("m", low=0.3, high=4.0, description="distance of the wheel planes")


class Axles(FileModel):
    """Front and rear axle."""

    front: Axle
    rear: Axle


class Wheel(FileModel):
    """One wheel with its tyre's vertical spring and the unsprung mass."""

    radius: float = parameter(
        "m", low=0.05, high=1.0, description="static loaded radius, used for slip and for the tyre's moment"
    )
    unloaded_radius: float = parameter(
        "m", low=0.05, high=1.2, description="free radius; with the radius and the static load it gives the stiffness"
    )
    inertia: float = parameter("kg m^2", low=0.01, high=100.0, description="of one wheel with disc about its spin axis")
    unsprung_mass: float = parameter(
        "kg", 38.0, low=1.0, high=500.0, description="wheel, brake, carrier", source=_ASSUMED
    )
    vertical_stiffness: float | None = parameter(
        "N/m", None, low=1e4, high=5e6, description="of the tyre", source="static load / (unloaded radius - radius)"
    )
    vertical_damping: float = parameter("N s/m", 100.0, low=0.0, high=1e4, description="of the tyre", source=_ASSUMED)
    rolling_resistance: float = parameter(
        "1", 0.015, low=0.0, high=0.5, description="moment over load and radius", source=_ASSUMED
    )
    friction_factor: float = parameter(
        "1", 1.0, low=0.0, high=3.0, neutral=1.0, description="multiplies the friction of this tyre"
    )
    toe: float = parameter("rad", 0.0, low=-0.2, high=0.2, neutral=0.0, description="fixed angle, positive to the left")


class Wheels(FileModel):
    """The four wheels."""

    fl: Wheel
    fr: Wheel
    rl: Wheel
    rr: Wheel


class Steering(FileModel):
    """Steering of the front wheels."""

    ratio: float = parameter(
        "1", 16.0, low=1.0, high=50.0, description="steering-wheel angle over road-wheel angle", source=_ASSUMED
    )
    ackermann: float = parameter(
        "1", 0.0, low=-1.0, high=1.0, neutral=0.0, description="0 parallel wheels, 1 full Ackermann geometry"
    )
    offset: float = parameter(
        "rad", 0.0, low=-0.1, high=0.1, neutral=0.0, description="road-wheel angle with the steering wheel straight"
    )
    stiffness: float = parameter(
        "N m/rad", 2e4, low=1e3, high=2e5, description="of the linkage, per wheel about the kingpin", source=_ASSUMED
    )
    damping: float = parameter("N m s/rad", 150.0, low=0.0, high=1e3, description="as the stiffness", source=_ASSUMED)
    map: SteeringMap | None = Field(
        default=None, description="measured angles of both wheels; the planar car and the vehicle-state filters need it"
    )


class Aerodynamics(FileModel):
    """Air forces; wind belongs to the road file."""

    air_density: float = parameter(
        "kg/m^3", 1.2, low=0.0, high=2.0, description="", source="friction document 6.1.1 [DEF]"
    )
    drag_coefficient: float = parameter("1", low=0.0, high=3.0, description="c_d")
    frontal_area: float = parameter("m^2", low=0.0, high=20.0, description="A_f")
    drag_height: float | None = parameter(
        "m",
        None,
        low=0.0,
        high=5.0,
        description="height of the drag force",
        source="h_aero = h, friction document 6.1.1 [DEF]",
    )
    lift_coefficient_front: float = parameter(
        "1", 0.0, low=-3.0, high=3.0, neutral=0.0, description="lift at the front axle"
    )
    lift_coefficient_rear: float = parameter(
        "1", 0.0, low=-3.0, high=3.0, neutral=0.0, description="lift at the rear axle"
    )
    side_force_coefficient: float = parameter(
        "1",
        0.0,
        low=-5.0,
        high=5.0,
        neutral=0.0,
        description="side force over dynamic pressure and frontal area, per rad",
    )
    side_force_position: float = parameter(
        "m",
        0.0,
        low=-3.0,
        high=3.0,
        neutral=0.0,
        description="place of the side force ahead of the centre of gravity: its arm for the yaw moment",
    )
