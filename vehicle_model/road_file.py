"""Road files: friction by position and time, split and patches, surfaces, grade and bank, wind."""

from collections.abc import Mapping
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Literal

from pydantic import Field, model_validator

from signals.errors import FieldError, unknown_name
from signals.quantities import FileModel, parameter
from signals.yaml_files import load_yaml, validate
from vehicle_model import parameters
from vehicle_model.parameters import ParameterInfo
from vehicle_model.tyres.tyre_file import BurckhardtCurve, MagicFormulaCurve

ROADS = Path(__file__).parent / "roads"
OWN_CURVE = "own_curve"


class Surface(FileModel):
    """A named surface: a factor on the tyre's own curve (eq. 89), or a curve that replaces it."""

    description: str = ""
    source: str = ""
    factor: float | None = parameter(
        "1", None, low=0.0, high=3.0, description="on the friction of the tyre's own curve"
    )
    curve: MagicFormulaCurve | BurckhardtCurve | None = None

    @model_validator(mode="after")
    def _one_of(self) -> "Surface":
        if (self.factor is None) == (self.curve is None):
            raise FieldError("needs one of factor and curve", allowed="factor, or curve in its place")
        return self


class SurfaceFile(FileModel):
    """Surfaces by name."""

    format: Literal[1]
    surfaces: dict[str, Surface]


class Side(FileModel):
    """One side of a split road."""

    friction: float = parameter("1", 1.0, low=0.0, high=3.0, neutral=1.0, description="factor on this side")
    surface: str | None = None


class Jump(FileModel):
    """Change of the road's friction at a place or at a time; it holds until the next jump."""

    position: float | None = parameter("m", None, description="place along the road")
    time: float | None = parameter("s", None, low=0.0, description="time of the run")
    friction: float = parameter("1", 1.0, low=0.0, high=3.0, description="factor after the jump")
    surface: str | None = None
    transition_length: float | None = parameter(
        "m", None, low=0.0, high=1000.0, description="of a linear change, with position"
    )
    transition_time: float | None = parameter(
        "s", None, low=0.0, high=60.0, description="of a linear change, with time; friction document 6.4: 0.3 s"
    )

    @model_validator(mode="after")
    def _one_of(self) -> "Jump":
        if (self.position is None) == (self.time is None):
            raise FieldError("needs one of position and time", allowed="position or time")
        if self.position is None and self.transition_length is not None:
            raise FieldError("goes with position", at=("transition_length",), allowed="transition_time with time")
        if self.time is None and self.transition_time is not None:
            raise FieldError("goes with time", at=("transition_time",), allowed="transition_length with position")
        # the transition of the other kind stays None and is no parameter of this jump
        name = "transition_time" if self.position is None else "transition_length"
        if getattr(self, name) is None:
            object.__setattr__(self, name, 0.0)
        return self


class Patch(FileModel):
    """A rectangle with its own friction, in place of the jumps and the split; a later patch lies on top."""

    x_from: float = parameter("m", description="start along the road")
    x_to: float = parameter("m", description="end along the road")
    y_from: float = parameter("m", -1000.0, description="right edge")
    y_to: float = parameter("m", 1000.0, description="left edge")
    friction: float = parameter("1", 1.0, low=0.0, high=3.0, description="factor on the patch")
    surface: str | None = None

    @model_validator(mode="after")
    def _ordered(self) -> "Patch":
        if self.x_to <= self.x_from or self.y_to <= self.y_from:
            raise FieldError("an empty rectangle", allowed="x_from < x_to and y_from < y_to")
        return self


class ProfilePoint(FileModel):
    """Grade and bank at one place; between two points they change linearly, outside they hold."""

    position: float = parameter("m", description="place along the road")
    grade: float = parameter("1", 0.0, low=-0.5, high=0.5, description="rise over run, uphill positive: 10 %")
    bank: float = parameter("1", 0.0, low=-0.5, high=0.5, description="rise over run, left side higher is positive")


class RoadFile(FileModel):
    """A road. Friction at a place is ``friction`` times the patch there, or times jump and side where no patch lies."""

    format: Literal[1] = 1
    name: str = "level"
    description: str = ""
    friction: float = parameter("1", 1.0, low=0.0, high=3.0, neutral=1.0, description="factor on the whole road")
    surface: str = OWN_CURVE
    split_position: float = parameter("m", 0.0, description="y at which left and right meet")
    left: Side = Side()
    right: Side = Side()
    jumps: list[Jump] = Field(default_factory=list)
    patches: list[Patch] = Field(default_factory=list)
    grade: float = parameter(
        "1", 0.0, low=-0.5, high=0.5, neutral=0.0, description="rise over run, uphill positive: 10 %"
    )
    bank: float = parameter(
        "1", 0.0, low=-0.5, high=0.5, neutral=0.0, description="rise over run, left side higher is positive"
    )
    profile: list[ProfilePoint] = Field(default_factory=list)
    surfaces: dict[str, Surface] = Field(default_factory=dict)
    wind_speed_x: float = parameter(
        "m/s", 0.0, low=-60.0, high=60.0, neutral=0.0, description="of the air along the road"
    )
    wind_speed_y: float = parameter("m/s", 0.0, low=-60.0, high=60.0, neutral=0.0, description="of the air to the left")
    gravity: float = parameter("m/s^2", 9.81, low=0.0, high=30.0, description="", source="friction document")

    @model_validator(mode="after")
    def _ordered(self) -> "RoadFile":
        places = [point.position for point in self.profile]
        if any(later <= earlier for earlier, later in pairwise(places)):
            raise FieldError("places that do not rise", at=("profile",), allowed="strictly rising positions")
        return self

    def surface_names(self) -> list[str]:
        """Names of the surfaces that the road uses, its own first."""
        used = [self.surface, self.left.surface, self.right.surface]
        used += [jump.surface for jump in self.jumps] + [patch.surface for patch in self.patches]
        return list(dict.fromkeys(name for name in used if name is not None))

    def used_surfaces(self) -> dict[str, Surface]:
        """The surfaces that the road uses, its own definitions before the shipped ones.

        Raises
        ------
        InputError
            If a name is unknown.
        """
        known = {**load_surfaces(), **self.surfaces}
        for name in self.surface_names():
            if name not in known:
                raise unknown_name("surface", name, tuple(known))
        return {name: known[name] for name in self.surface_names()}

    def numbers(self) -> dict[str, float]:
        """Dotted path (``road.friction``, ``road.patches.0.friction``) → SI value."""
        return parameters.numbers(self, "road.")


def road_parameter_table(road: RoadFile) -> list[ParameterInfo]:
    """Every parameter of a road that can be changed on-line."""
    return parameters.parameter_infos(road, "road.")


def road_names() -> tuple[str, ...]:
    """Names of the roads that ship with the bench."""
    return tuple(sorted(path.stem for path in ROADS.glob("*.yaml") if path.stem != "surfaces"))


def load_road(name_or_path: str | Path) -> RoadFile:
    """Read a road file, given by the name of a shipped one or by its path.

    Raises
    ------
    InputError
        If there is no such road or file, the file has faults, or it names an unknown surface.
    """
    path = Path(name_or_path)
    if path.suffix not in (".yaml", ".yml"):
        path = ROADS / f"{name_or_path}.yaml"
        if not path.exists():
            raise unknown_name("road", str(name_or_path), road_names(), mend="or give the path of a .yaml file")
    road = validate(load_yaml(path), RoadFile)
    road.used_surfaces()
    return road


@cache
def load_surfaces() -> Mapping[str, Surface]:
    """The surfaces that ship with the bench, by name (read once)."""
    return MappingProxyType(validate(load_yaml(ROADS / "surfaces.yaml"), SurfaceFile).surfaces)
