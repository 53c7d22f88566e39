"""Extended vehicle files: written, read, stacked, and run bit for bit as the parameters set by hand."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from model_diagnosis.effects.catalogue import EFFECTS, effect
from model_diagnosis.effects.effect import Effect
from model_diagnosis.extension.car_change import change_of, is_of_the_car
from model_diagnosis.extension.extended_vehicle import (
    FoundEffect,
    FoundTerm,
    Interval,
    extensions_of,
    hash_of_vehicle,
    hashes_of_logs,
    write_extended_vehicle,
)
from model_diagnosis.extension.tyre_shape import curve, reshaped
from signals.errors import InputError
from vehicle_model.extension_file import Provenance
from vehicle_model.extension_terms_file import Term
from vehicle_model.plant import Plant
from vehicle_model.tyres.tyre_file import CurveTyre, MagicFormulaCurve
from vehicle_model.vehicle_file import VehicleFile, load_vehicle, set_parameter

FloatArray = NDArray[np.float64]
NO_PLACE = {"brake_knock_back"}
"""What the plant does not have: its pads do not stand back, since its hydraulic unit knows no cornering."""
OF_THE_CAR = [one for one in EFFECTS if is_of_the_car(one) and one.name not in NO_PLACE]
NOT_THE_CARS = [one for one in EFFECTS if not is_of_the_car(one)]


def _found(name: str, **deviations: float) -> FoundEffect:
    return FoundEffect(
        effect(name),
        {key: Interval(value, 0.9 * value, 1.1 * value) for key, value in deviations.items()},
        probability=0.97,
        log_bayes_factor=31.5,
        group=(name,),
        evidence="two stops",
    )


def _deviations(one: Effect) -> dict[str, float]:
    return {
        parameter.name: float(np.clip(0.4 * parameter.effect_std, parameter.low, parameter.high))
        for parameter in one.parameters
    }


def _drive(vehicle: VehicleFile) -> FloatArray:
    """Brake while steering: (n, outputs)."""
    car = Plant(vehicle)
    car.reset(speed_m_s=25.0)
    rows = []
    for tick in range(600):
        on = 1.0 if tick > 100 else 0.0
        car.tick(on * np.array([700.0, 720.0, 300.0, 320.0]), np.full(4, 50.0), 0.5 * np.sin(4e-3 * tick), tick * 1e-3)
        rows.append(car.outputs.copy())
    return np.array(rows)


@pytest.mark.parametrize("one", OF_THE_CAR, ids=lambda one: one.name)
def test_every_effect_of_the_car_has_a_place_in_the_vehicle(one: Effect) -> None:
    """Every parameter of the effect moves at least one number of the file, and the file still stands."""
    vehicle = load_vehicle("ekf_car")
    for name, value in _deviations(one).items():
        changed = vehicle.model_copy(deep=True)
        change_of(vehicle, one, {name: value}).apply(changed)
        assert changed.numbers() != vehicle.numbers(), name


@pytest.mark.parametrize("one", NOT_THE_CARS, ids=lambda one: one.name)
def test_what_belongs_to_the_drive_changes_no_car(one: Effect) -> None:
    vehicle = load_vehicle("ekf_car")
    change = change_of(vehicle, one, _deviations(one))
    assert change.conditions
    assert not change.parameters
    assert not change.terms


@pytest.mark.parametrize("name", sorted(NO_PLACE))
def test_an_effect_without_a_place_in_the_plant_is_a_remark(name: str) -> None:
    one = effect(name)
    found = FoundEffect(one, {key: Interval(value, value, value) for key, value in _deviations(one).items()})
    extensions, remarks = extensions_of(load_vehicle("ekf_car"), [found])
    assert extensions == []
    assert name in remarks[0]


def test_neutral_deviations_change_nothing() -> None:
    vehicle = load_vehicle("ekf_car")
    for one in EFFECTS:
        change = change_of(vehicle, one, {parameter.name: 0.0 for parameter in one.parameters})
        assert not change.parameters, one.name
        assert not change.terms, one.name


def test_an_extended_file_drives_bit_for_bit_as_the_parameters_set_by_hand(tmp_path: Path) -> None:
    base = load_vehicle("ekf_car")
    found = [
        _found("mass_change", factor=0.137),
        _found("tyre_relaxation_length", length=0.21),
        _found("brake_pad_friction", factor=-0.2),
        _found("wheel_radius_change", fl=-0.0113),
    ]
    extensions, remarks = extensions_of(base, found)
    assert remarks == []
    file = write_extended_vehicle(tmp_path / "extended_vehicle.yaml", "ekf_car", base, extensions)
    by_hand = load_vehicle("ekf_car")
    for path, value in (
        ("body.mass", 1296.0 * 1.137),
        ("tyres.front.relaxation_length_longitudinal", 0.21),
        ("tyres.rear.relaxation_length_longitudinal", 0.21),
        ("tyres.front.relaxation_length_lateral", 0.21),
        ("tyres.rear.relaxation_length_lateral", 0.21),
        ("brakes.front.pad_friction", 0.4 * (1.0 - 0.2)),
        ("brakes.rear.pad_friction", 0.4 * (1.0 - 0.2)),
        ("wheels.fl.radius", 0.278 * (1.0 - 0.0113)),
    ):
        set_parameter(by_hand, path, value)
    extended = load_vehicle(file)
    assert extended.numbers() == by_hand.numbers()
    driven = _drive(extended)
    assert np.array_equal(driven, _drive(by_hand))
    assert not np.array_equal(driven, _drive(base))


def test_an_extended_file_carries_its_evidence(tmp_path: Path) -> None:
    log = tmp_path / "stop.csv"
    log.write_text("t,v\n0,1\n")
    base = load_vehicle("ekf_car")
    provenance = Provenance(data=hashes_of_logs([log]), versions={"bench": "0.1.0"})
    extensions, _ = extensions_of(base, [_found("brake_balance", shift=0.1)], provenance=provenance)
    file = write_extended_vehicle(tmp_path / "extended.yaml", "ekf_car", base, extensions)
    extension = load_vehicle(file).extensions[0]
    assert (extension.effect, extension.probability, extension.log_bayes_factor) == ("brake_balance", 0.97, 31.5)
    assert extension.provenance.vehicle == hash_of_vehicle(base)
    # sha256 of the text, by coreutils' sha256sum
    assert extension.provenance.data == {"stop.csv": "a15167f58d1c49ef5c6ef9a0cf6039452b738b2036e74cdf250557154af59383"}
    # the front brakes gain what the rear ones lose: half the torque per bar, so twice the share
    assert extension.parameters["brakes.front.pad_friction"] == pytest.approx(0.44)
    assert extension.parameters["brakes.rear.pad_friction"] == pytest.approx(0.4 * (1.0 - 0.2))
    low, high = extension.intervals["brakes.front.pad_friction"]
    assert (low, high) == (pytest.approx(0.4 * 1.09), pytest.approx(0.4 * 1.11))


def test_extensions_of_a_file_that_is_extended_stack(tmp_path: Path) -> None:
    base = load_vehicle("ekf_car")
    first, _ = extensions_of(base, [_found("brake_pad_friction", factor=-0.2), _found("driveline_drag", constant=20.0)])
    once = write_extended_vehicle(tmp_path / "once.yaml", "ekf_car", base, first)
    vehicle = load_vehicle(once)
    second, _ = extensions_of(
        vehicle, [_found("brake_pad_friction", factor=-0.1), _found("tyre_velocity_fade", slope=2e-3)]
    )
    twice = load_vehicle(write_extended_vehicle(tmp_path / "deeper" / "twice.yaml", str(once), vehicle, second))
    assert [extension.effect for extension in twice.extensions] == [
        "brake_pad_friction",
        "driveline_drag",
        "brake_pad_friction",
        "tyre_velocity_fade",
    ]
    assert twice.brakes.front.pad_friction == pytest.approx(0.4 * 0.8 * 0.9)
    assert [term.target for term in twice.terms.stack] == ["drive_torque", "tyre_friction_factor"]


def test_a_discovered_term_comes_back_as_written_and_runs(tmp_path: Path) -> None:
    term = Term.model_validate(
        {
            "target": "brake_torque_factor",
            "coefficient": -2.5e-4,
            "factors": [{"variable": "speed", "exponent": 2.0}],
            "description": "torque lost with the square of speed",
        }
    )
    base = load_vehicle("ekf_car")
    found = FoundTerm("brake torque · (1 - 2.5e-4 v²)", [term], [Interval(-2.5e-4, -3e-4, -2e-4)])
    extensions, _ = extensions_of(base, [], [found])
    file = write_extended_vehicle(tmp_path / "extended.yaml", "ekf_car", base, extensions)
    extended = load_vehicle(file)
    assert extended.terms.stack == [term]
    assert extended.extensions[0].intervals == {"terms.0.coefficient": [-3e-4, -2e-4]}
    # at 20 m/s the brake gives 1 - 2.5e-4 · 400 = 0.9 of its torque
    car = Plant(extended)
    car.reset(speed_m_s=20.0)
    car.step(1, brake_torque=500.0)
    assert car.state()["true_brake_torque_fl"] == pytest.approx(450.0, rel=1e-4)


def test_bad_extensions_are_named_with_their_place(tmp_path: Path) -> None:
    file = tmp_path / "car.yaml"
    file.write_text(
        "format: 1\nname: x\nextends: ekf_car\nextensions:\n"
        "  - effect: mass_change\n    parameters: {body.mass: 1 t, body.mas: 3}\n"
    )
    with pytest.raises(InputError) as caught:
        load_vehicle(file)
    assert "car.yaml:6" in str(caught.value)
    assert "body.mass" in str(caught.value)
    many = {"target": "yaw_moment", "coefficient": 1.0}
    file.write_text(f"format: 1\nname: x\nextends: ekf_car\nextensions:\n  - {{effect: x, terms: {[many] * 33}}}\n")
    with pytest.raises(InputError, match="at most 32"):
        load_vehicle(file)


def test_an_effect_that_this_car_cannot_have_is_a_remark() -> None:
    vehicle = load_vehicle("ekf_car")
    found = [_found("tyre_peak_shape", sliding_loss=5.0), _found("mass_change", factor=0.1)]
    extensions, remarks = extensions_of(vehicle, found)
    assert [extension.effect for extension in extensions] == ["mass_change"]
    assert len(remarks) == 1
    assert "no Magic Formula has this form" in remarks[0]


@pytest.mark.parametrize(("loss", "shift"), [(0.1, 0.0), (0.0, 0.4), (0.05, -0.2)])
def test_another_peak_keeps_stiffness_and_height(loss: float, shift: float) -> None:
    tyre = load_vehicle("ekf_car").tyre_pair.front
    assert isinstance(tyre, CurveTyre)
    assert isinstance(tyre.longitudinal, MagicFormulaCurve)
    old, slip = tyre.longitudinal, np.linspace(1e-4, 1.0, 200_001)
    new = reshaped(old, loss, shift)
    before, after = (curve(slip, one.shape, one.stiffness, one.curvature) for one in (old, new))
    assert after[0] == pytest.approx(before[0], rel=1e-3)
    assert after.max() == pytest.approx(before.max(), abs=1e-3)
    assert slip[after.argmax()] == pytest.approx((1.0 + shift) * slip[before.argmax()], rel=0.02)
    assert after[-1] == pytest.approx(before[-1] - loss, abs=0.02)


def test_all_valves_late_and_one_later_add_up() -> None:
    """Two deviations that act on one number of the file: 2 ms of all and 3 ms of one are 5 ms there, 2 ms elsewhere."""
    change = change_of(load_vehicle("ekf_car"), effect("inlet_valve_delay"), {"delay": 2e-3, "fl": 3e-3})
    found = {path.rsplit("_", 1)[1]: value for path, value in change.parameters.items()}
    assert found == pytest.approx({"fl": 5e-3, "fr": 2e-3, "rl": 2e-3, "rr": 2e-3})
