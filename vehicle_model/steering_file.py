"""Measured steering map in a vehicle file."""

from itertools import pairwise

from pydantic import Field, model_validator

from signals.errors import FieldError
from signals.quantities import FileModel


class SteeringMap(FileModel):
    """Road-wheel angles of the front wheels over the steering-wheel angle, linear between the points."""

    steering_wheel_angle: list[float] = Field(
        min_length=2, description="rising angles, positive to the left", json_schema_extra={"unit": "rad"}
    )
    left: list[float] = Field(
        min_length=2, description="angle of the left wheel at these", json_schema_extra={"unit": "rad"}
    )
    right: list[float] = Field(
        min_length=2, description="angle of the right wheel at these", json_schema_extra={"unit": "rad"}
    )

    @model_validator(mode="after")
    def _rising(self) -> "SteeringMap":
        angles = self.steering_wheel_angle
        for name in ("left", "right"):
            if len(getattr(self, name)) != len(angles):
                raise FieldError("as many as steering_wheel_angle", at=(name,), allowed=f"{len(angles)} values")
        for number, (lower, higher) in enumerate(pairwise(angles), 1):
            if higher <= lower:
                raise FieldError("not rising", at=("steering_wheel_angle", number), allowed=f"more than {lower:g} rad")
        return self
