"""Road files: friction by position and time, split and patches, surfaces, water, grade and bank, roughness, wind."""

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
from vehicle_model.roughness_classes import CLASS_LEVELS
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

    def peak_friction(self) -> float:
        """Largest friction of the surface at walking pace, for a tyre whose own curve peaks at 1."""
        if self.curve is None:
            return 1.0 if self.factor is None else self.factor
        if isinstance(self.curve, MagicFormulaCurve):
            return self.curve.peak_friction
        from vehicle_model.tyres.coefficients import burckhardt_peak_slip
        from vehicle_model.tyres.curves import burckhardt

        curve = self.curve
        return float(burckhardt(burckhardt_peak_slip(curve), curve.c1, curve.c2, curve.c3, curve.c4, 0.0)[0])


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
    water_film: float | None = parameter(
        "m", None, low=0.0, high=0.1, description="depth of the water here; without it the road's"
    )

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


class Roughness(FileModel):
    """Unevenness of two wheel tracks after ISO 8608; a smooth road by default."""

    iso_class: Literal["A", "B", "C", "D", "E", "F", "G", "H"] | None = Field(
        default=None, description="class of ISO 8608, gives the level in the middle of the class"
    )
    level: float = parameter(
        "m^3", 0.0, low=0.0, high=1.0, neutral=0.0, description="displacement spectrum at 0.1 cycles/m, 0 is smooth"
    )
    waviness: float = parameter("1", 2.0, low=1.2, high=3.5, description="exponent of the spectrum", source="ISO 8608")
    track: float = parameter("m", 1.5, low=0.1, high=5.0, description="distance of the left from the right track")
    realisation: int = Field(default=1, ge=0, le=2**32 - 1, description="which stretch of road with these statistics")

    @model_validator(mode="after")
    def _class_level(self) -> "Roughness":
        if self.iso_class is None:
            return self
        level = CLASS_LEVELS[self.iso_class]
        if self.level == 0.0:
            object.__setattr__(self, "level", level)
        elif self.level != level:
            raise FieldError(
                f"not that of class {self.iso_class}", at=("level",), allowed=f"{level:g} m^3, or no iso_class"
            )
        return self


class Water(FileModel):
    """Water on the road and friction that falls with speed (Table 1 of the friction document); dry by default."""

    film: float = parameter("m", 0.0, low=0.0, high=0.1, neutral=0.0, description="depth of the water: 1 mm")
    tread_wear: float = parameter(
        "1", 0.0, low=0.0, high=1.0, description="0 new tyres, 1 used ones with at least 1.6 mm"
    )
    speed_dependence: float = parameter(
        "1",
        0.0,
        low=0.0,
        high=1.0,
        neutral=0.0,
        description="share of the table's fall of dry friction with speed that is applied",
    )


class Gust(FileModel):
    """A gust on top of the steady wind: it rises to its peak and falls again as (1 - cos)/2."""

    speed_x: float = parameter(
        "m/s", 0.0, low=-60.0, high=60.0, neutral=0.0, description="peak along the road, beyond the steady wind"
    )
    speed_y: float = parameter(
        "m/s", 0.0, low=-60.0, high=60.0, neutral=0.0, description="peak to the left, beyond the steady wind"
    )
    start: float = parameter("s", 0.0, low=0.0, high=3600.0, description="time of the run at which it rises")
    duration: float = parameter(
        "s", 2.0, low=0.05, high=600.0, description="from calm to calm", source="assumed: usual beside a gap in a wood"
    )
    period: float = parameter("s", 0.0, low=0.0, high=3600.0, neutral=0.0, description="between gusts; 0 for one alone")


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
    roughness: Roughness = Field(default_factory=Roughness)
    water: Water = Field(default_factory=Water)
    wind_speed_x: float = parameter(
        "m/s", 0.0, low=-60.0, high=60.0, neutral=0.0, description="of the air along the road"
    )
    wind_speed_y: float = parameter("m/s", 0.0, low=-60.0, high=60.0, neutral=0.0, description="of the air to the left")
    gust: Gust = Field(default_factory=Gust)
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
