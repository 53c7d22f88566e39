"""The peak of a tyre's curve is a cause only where a drive comes near it.

The logs are the MuJoCo car's, on dry asphalt but for one on ice.
"""

import pytest
from plant_log import Course, coast_and_drive, drive, gentle_stop, pulsed_stop

from model_diagnosis.effects.form import FORM_NAMES, REPLAYED
from model_diagnosis.evidence.base import fit_base
from model_diagnosis.evidence.excitation import excitation, excited_columns
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.replay import Replay
from model_diagnosis.replay.limit import NEAR_SHARE
from vehicle_model.road_file import RoadFile
from vehicle_model.vehicle_file import VehicleFile

NEEDED = 5.0
"""Log evidence of a cause, about the threshold of six manoeuvres."""
OF_THE_PEAK = ("tyre_friction", "tyre_peak_shape", "tyre_load_sensitivity", "tyre_velocity_fade", "mu_step", "mu_split")


@pytest.mark.parametrize(
    ("course", "seconds", "road", "approached"),
    [
        pytest.param(coast_and_drive, 8.0, RoadFile(), False, id="1.5 m/s^2 along"),
        pytest.param(gentle_stop, 3.0, RoadFile(), False, id="a stop at 3 m/s^2"),
        pytest.param(pulsed_stop, 3.0, RoadFile(), True, id="pressure pulses about the limit"),
        pytest.param(gentle_stop, 3.0, RoadFile(friction=0.2), True, id="wheels that lock on ice, at 2 m/s^2"),
    ],
)
def test_a_drive_comes_near_the_limit_by_acceleration_or_slip(
    car: VehicleFile, course: Course, seconds: float, road: RoadFile, approached: bool
) -> None:
    replay = Replay(car, [drive(car, course, seconds, 25.0, road)], [])
    assert replay.limit_approached is approached


@pytest.mark.parametrize(("course", "shown"), [(coast_and_drive, False), (pulsed_stop, True)])
def test_the_peak_is_a_cause_only_near_the_limit(car: VehicleFile, course: Course, shown: bool) -> None:
    chosen = {*OF_THE_PEAK, "tyre_longitudinal_stiffness", *FORM_NAMES}
    effects = [effect for effect in REPLAYED if effect.name in chosen]
    replay = Replay(car, [drive(car, course, 4.0, 30.0)], effects)
    base = fit_base(replay, Priors.of(replay.parameters))
    columns = excited_columns(base.problem, base.at_nothing.informations)
    reached = {name.split(".")[0] for name, excited in zip(replay.columns, columns, strict=True) if excited}
    assert "tyre_longitudinal_stiffness" in reached
    assert ("tyre_friction" in reached) is shown
    assert shown or not reached.intersection(OF_THE_PEAK)
    insufficient = excitation(base.problem, base.at_nothing.information, NEEDED).insufficient
    assert ("tyre_friction" in insufficient) is not shown


@pytest.mark.parametrize(("used", "more_slip"), [(NEAR_SHARE, 0.08), (0.2, 0.02)])
def test_what_less_friction_does_to_the_slip_below_the_limit(used: float, more_slip: float) -> None:
    """Brush tyre (Pacejka, 3.2): F / (mu Fz) = 1 - (1 - C s / (3 mu Fz))^3, here with a fifth less friction."""

    def slip(friction: float) -> float:
        return friction * (1.0 - (1.0 - used / friction) ** (1.0 / 3.0))

    assert slip(0.8) / slip(1.0) - 1.0 == pytest.approx(more_slip, abs=0.005)
