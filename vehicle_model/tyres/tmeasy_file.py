"""Characteristic of a TMeasy tyre in a tyre file: forces and trail at nominal and at twice nominal load."""

from pydantic import model_validator

from signals.errors import FieldError
from signals.quantities import FileModel, parameter


class TMeasyPoint(FileModel):
    """Characteristic of one direction at one load."""

    slope: float = parameter("N", low=100.0, high=5e6, description="dF0, at zero slip")
    peak_force: float = parameter("N", low=1.0, high=1e6, description="F^M")
    peak_slip: float = parameter("1", low=0.005, high=2.0, description="s^M")
    sliding_force: float = parameter("N", low=1.0, high=1e6, description="F^G")
    sliding_slip: float = parameter("1", low=0.01, high=10.0, description="s^G, where full sliding begins")

    @model_validator(mode="after")
    def _ordered(self) -> "TMeasyPoint":
        if self.sliding_slip <= self.peak_slip:
            raise FieldError("not beyond the peak", at=("sliding_slip",), allowed=f"more than {self.peak_slip:g}")
        if self.sliding_force > self.peak_force:
            raise FieldError("larger than the peak", at=("sliding_force",), allowed=f"at most {self.peak_force:g} N")
        return self


class TMeasyDirection(FileModel):
    """Characteristic of one direction at nominal and at twice nominal load."""

    nominal: TMeasyPoint
    double: TMeasyPoint


class TMeasyTrail(FileModel):
    """Pneumatic trail over contact length at one load (eq. 22)."""

    at_zero_slip: float = parameter("1", low=0.0, high=0.5, description="(n/L)0")
    zero_slip: float = parameter("1", low=0.005, high=2.0, description="s_y^0, lateral slip of zero trail")
    sliding_slip: float = parameter("1", low=0.01, high=10.0, description="s_y^G, no trail beyond")

    @model_validator(mode="after")
    def _ordered(self) -> "TMeasyTrail":
        if self.sliding_slip <= self.zero_slip:
            raise FieldError("not beyond zero trail", at=("sliding_slip",), allowed=f"more than {self.zero_slip:g}")
        return self


class TMeasyAligning(FileModel):
    """Pneumatic trail at nominal and at twice nominal load."""

    contact_length: float = parameter(
        "m", 0.12, low=0.0, high=1.0, description="L", source="assumed: usual for a passenger car tyre"
    )
    nominal: TMeasyTrail
    double: TMeasyTrail
