"""An effect of the catalogue: its equation, its parameters with prior widths, and where it shows.

A parameter's value 0 is neutral: it is the deviation from the vehicle file, relative (factor − 1) or in its unit.
"""

import math
from dataclasses import dataclass, field
from enum import StrEnum


class Group(StrEnum):
    """Part of the car or of the measuring chain that an effect belongs to."""

    TYRE = "tyre"
    BRAKE = "brake"
    HYDRAULICS = "hydraulics"
    SUSPENSION = "suspension"
    BODY = "body"
    AERODYNAMICS = "aerodynamics"
    ROAD = "road"
    DRIVELINE = "driveline"
    STEERING = "steering"
    SENSOR = "sensor"
    CLOCK = "clock"
    CAN = "can"
    CONTROLLER = "controller"


class Application(StrEnum):
    """Where an effect acts.

    The replay has columns for plant, input and sensor. Clock means transport, mapping and time, settled by the data
    checks before any replay; controller means the control unit's settings, which measured pressures make irrelevant.
    """

    PLANT = "plant"
    INPUT = "input"
    SENSOR = "sensor"
    CLOCK = "clock"
    CONTROLLER = "controller"


@dataclass(frozen=True)
class EffectParameter:
    """One number of an effect, as a deviation whose value 0 is neutral.

    Attributes
    ----------
    name : as in the equation, spelled out; its column is ``<effect>.<name>``
    unit : of the deviation; "1" for a relative one
    low, high : bounds of the deviation
    nuisance_std : how far an ordinary car is off its vehicle file (0: not at all)
    effect_std : width of the prior where the effect is present
    vehicle_path : dotted path of the vehicle file's parameter that it changes ("" where the file has none); ``*``
        stands for each wheel or axle
    relative : True where physical value = nominal · (1 + deviation), False where it is nominal + deviation
    never_negative : True where the physical value cannot fall below 0: an addition is bounded by the vehicle's value
    form_std : how far the replay's form may be off in the direction of this number, on top of what an ordinary car is
    trial_step : distance between values to try, in the deviation's unit, where it acts in pulses or is a place; else 0
    places : name of the effect's other deviation that begins at this one, a place; "" for all others
    least_named : size below which it is no cause however surely it is seen: any road or car has it
    common_path : path, a pattern, of the numbers that this one moves together and whose scatter it shares in
    """

    name: str
    unit: str
    low: float
    high: float
    nuisance_std: float
    effect_std: float
    vehicle_path: str = ""
    relative: bool = True
    never_negative: bool = False
    form_std: float = 0.0
    trial_step: float = 0.0
    places: str = ""
    least_named: float = 0.0
    common_path: str = ""

    @property
    def ordinary_std(self) -> float:
        """How far an ordinary car is off in the replay's eyes: its own scatter and what the form adds."""
        return math.hypot(self.nuisance_std, self.form_std)


@dataclass(frozen=True)
class Effect:
    """One effect of the catalogue (anchor: catalogue of effects, one row).

    Attributes
    ----------
    equation : readable, one line
    signals : channels that show it
    confounded_with : names of effects that look alike
    separating_manoeuvre : what tells them apart
    discrete : True where the parameters take separate values (a swap, a failed circuit) and are run as hypotheses
    one_at_a_time : True where no two of its deviations are present together
    needs_torque : True where it shows only in how wheels follow a torque, and so nowhere if each torque was taken from
        the acceleration
    needs_limit : True where it shows only where tyres use half of their friction or more
    """

    name: str
    group: Group
    application: Application
    equation: str
    parameters: tuple[EffectParameter, ...]
    signals: tuple[str, ...]
    separating_manoeuvre: str
    confounded_with: tuple[str, ...] = ()
    source: str = ""
    discrete: bool = False
    one_at_a_time: bool = False
    needs_torque: bool = False
    needs_limit: bool = False
    remarks: str = field(default="")

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of its parameters in a diagnosis, ``<effect>.<parameter>``."""
        return tuple(f"{self.name}.{parameter.name}" for parameter in self.parameters)
