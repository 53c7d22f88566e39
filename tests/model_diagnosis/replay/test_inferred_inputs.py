"""Forces that nobody measured are inferred from the accelerometer: its errors show, nothing else is blamed for them.

The log is the MuJoCo car's, which coasts, drives and brakes lightly, without brake pressures and drive torques.
"""

from dataclasses import replace

import numpy as np
import pytest
from plant_log import coast_and_drive, drive

from model_diagnosis.effects.form import FORM_NAMES, REPLAYED
from model_diagnosis.evidence.base import fit_base
from model_diagnosis.evidence.excitation import excitation, excited_columns
from model_diagnosis.evidence.hypotheses import hypotheses_of
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.search import Search
from model_diagnosis.evidence.selection import Selection, Selector
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

MEASURED = (*(f"wheel_speed_{wheel}" for wheel in WHEELS), "speed", "longitudinal_acceleration")
LONGITUDINAL = (
    "accelerometer_offset",
    "accelerometer_scale",
    "aero_drag",
    "brake_pad_friction",
    "engine_braking",
    "head_wind",
    "mass_change",
    "road_grade",
    "rolling_resistance",
    "tyre_longitudinal_stiffness",
    "wheel_radius_change",
)
_INERTIA = ("mass_change", "wheel_inertia_reflected", "tyre_longitudinal_stiffness", "wheel_radius_change")
_WITHOUT_TORQUE = (*MEASURED, "steering_wheel_angle")
NEEDED = 5.0
"""Log evidence of a cause, about the threshold of six manoeuvres."""


@pytest.fixture(scope="module")
def driven(car: VehicleFile) -> Manoeuvre:
    return drive(car, coast_and_drive, 8.0, 25.0, name="coast")


@pytest.fixture(scope="module")
def log(car: VehicleFile, driven: Manoeuvre) -> Manoeuvre:
    return with_noise(car, driven, 5)


def with_noise(car: VehicleFile, driven: Manoeuvre, seed: int) -> Manoeuvre:
    """With the noise that the vehicle file's sensors have."""
    random, sensors = np.random.default_rng(seed), Replay(car, [driven], [])
    kept = {"steering_wheel_angle": driven.channels["steering_wheel_angle"]}
    for name in MEASURED:
        noise = sensors.sensor_std(name) * random.standard_normal(len(driven.time))
        kept[name] = driven.channels[name] + noise
    return replace(driven, channels=kept, weights={name: driven.weights[name] for name in kept})


def with_offset(log: Manoeuvre, offset: float) -> Manoeuvre:
    channels = {**log.channels, "longitudinal_acceleration": log.channels["longitudinal_acceleration"] + offset}
    return replace(log, channels=channels)


def found(car: VehicleFile, log: Manoeuvre) -> tuple[Replay, Selection]:
    """What the search names among the effects of the longitudinal balance."""
    replay = Replay(car, [log], [effect for effect in REPLAYED if effect.name in {*LONGITUDINAL, *FORM_NAMES}])
    base = fit_base(replay, Priors.of(replay.parameters))
    search = Search(base.problem, hypotheses_of(replay), NEEDED)
    return replay, Selector(search, NEEDED).run(base.nothing, base.at_nothing, base.at_saturated)


def test_an_accelerometer_without_an_error_gives_no_cause(car: VehicleFile, log: Manoeuvre) -> None:
    assert found(car, log)[1].accepted == []


def test_an_offset_of_the_accelerometer_is_named_with_its_size(car: VehicleFile, driven: Manoeuvre) -> None:
    """In each of four draws of the noise, one of which moves the size by 0.016 m/s^2; the limit is on their mean."""
    sizes = []
    for seed in range(5, 9):
        replay, selection = found(car, with_offset(with_noise(car, driven, seed), 0.25))
        (cause,) = selection.accepted
        assert [replay.columns[column] for column in cause.hypothesis.columns] == ["accelerometer_offset.longitudinal"]
        sizes.append(selection.fit.theta[cause.hypothesis.columns[0]])
    assert np.mean(sizes) == pytest.approx(0.25, abs=0.05)


@pytest.mark.parametrize(
    "column",
    [
        "mass_change.factor",
        "aero_drag.factor",
        "rolling_resistance.constant",
        "driveline_drag.constant",
        "brake_pad_friction.factor",
    ],
)
def test_what_the_inference_takes_from_the_measurement_changes_no_acceleration(
    column: str, car: VehicleFile, log: Manoeuvre
) -> None:
    """The car is turned round with its own deviations: by an effect's whole width less than a tenth of the noise."""
    replay = Replay(car, [log])
    index = replay.columns.index(column)
    change = replay.sensitivities(np.zeros(len(replay.columns)), [index])[0][:, :, 0]
    place = replay.signals(0).index("longitudinal_acceleration")
    moved = float(np.std(change[:, place])) * replay.parameters[index].effect_std
    assert moved < 0.1 * replay.sensor_std("longitudinal_acceleration")


def test_inertia_of_the_wheels_shows_only_where_a_torque_was_measured(car: VehicleFile, driven: Manoeuvre) -> None:
    """The same drive with the torques that moved its wheels, and without."""
    column = "wheel_inertia_reflected.inertia"
    for channels, is_shown in ((driven.channels, True), ({n: driven.channels[n] for n in _WITHOUT_TORQUE}, False)):
        log = replace(driven, channels=channels, weights={n: driven.weights[n] for n in channels})
        replay = Replay(car, [log], [effect for effect in REPLAYED if effect.name in {*_INERTIA, *FORM_NAMES}])
        base = fit_base(replay, Priors.of(replay.parameters))
        assert excited_columns(base.problem, base.at_nothing.informations)[replay.columns.index(column)] == is_shown
        shown = excitation(base.problem, base.at_nothing.information, NEEDED)
        assert ("wheel_inertia_reflected" in shown.insufficient) != is_shown
