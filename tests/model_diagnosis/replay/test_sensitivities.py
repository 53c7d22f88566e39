"""Sensitivities against differences of the prediction, and what a drive does and does not excite."""

import numpy as np
import pytest

from model_diagnosis.replay import Replay
from signals.wheels import WHEELS

GENTLE, PULSED, SINE, TURN, COAST = range(5)


@pytest.mark.parametrize(
    ("m", "column"),
    [
        (GENTLE, "mass_change.factor"),
        (GENTLE, "brake_pad_friction.factor"),
        (GENTLE, "brake_balance.shift"),
        (PULSED, "wheel_inertia_reflected.inertia"),
        (SINE, "tyre_cornering_stiffness.front"),
        (SINE, "gyro_offset.yaw_rate"),
        (SINE, "accelerometer_misalignment.angle"),
        (TURN, "accelerometer_scale.lateral"),
        (TURN, "accelerometer_levelled.share"),
        (COAST, "road_grade.grade"),
    ],
)
def test_sensitivities_are_derivatives_of_the_prediction(replay: Replay, m: int, column: str) -> None:
    index = replay.columns.index(column)
    theta = np.zeros(len(replay.columns))
    found = replay.sensitivities(theta, [index])[m][:, :, 0]
    step = 0.005 * replay.parameters[index].effect_std
    moved = [theta.copy(), theta.copy()]
    moved[0][index], moved[1][index] = step, -step
    central = (replay.predict(moved[0], m) - replay.predict(moved[1], m)) / (2.0 * step)
    scale = np.abs(central).max(axis=0)
    noise = np.array([replay.sensor_std(signal) for signal in replay.signals(m)])
    shown = scale * replay.parameters[index].effect_std > 0.3 * noise
    assert shown.any()
    assert np.all(np.abs(found - central).max(axis=0)[shown] < 0.02 * scale[shown])


def test_a_pressure_sensor_that_only_drives_the_car_is_differentiated_finely(replay: Replay) -> None:
    """At the limit of friction 0.6 % of pressure is far beyond a slope: such a step is 28 % off in front.

    Steps of a hydraulic unit, which ask for such coarse differences, are in no replay that is driven by pressures.
    """
    index = replay.columns.index("pressure_sensor_scale.wheels")
    theta = np.zeros(len(replay.columns))
    step = 0.001 * replay.parameters[index].effect_std
    moved = [theta.copy(), theta.copy()]
    moved[0][index], moved[1][index] = step, -step
    central = (replay.predict(moved[0], PULSED) - replay.predict(moved[1], PULSED)) / (2.0 * step)
    found = replay.sensitivities(theta, [index])[PULSED][:, :, 0]
    wheels = [k for k, name in enumerate(replay.signals(PULSED)) if name.startswith("wheel_speed")]
    off = np.sqrt(np.mean((found - central)[:, wheels] ** 2, axis=0) / np.mean(central[:, wheels] ** 2, axis=0))
    assert np.all(off < 0.1)


def test_columns_at_a_bound_are_differentiated_inwards(replay: Replay) -> None:
    """A lag cannot be negative: at its bound the derivative is that of a growing one, and it is not zero."""
    index = replay.columns.index("caliper_lag.time_constant")
    theta = np.zeros(len(replay.columns))
    assert replay.parameters[index].low == 0.0
    found = replay.sensitivities(theta, [index])[PULSED][:, :, 0]
    k = replay.signals(PULSED).index("wheel_speed_fl")
    assert np.abs(found[:, k]).max() > 10.0  # 10 ms of lag then move the wheel by 0.1 rad/s at least


def test_a_sweep_is_the_same_in_parts_and_on_one_thread(replay: Replay) -> None:
    theta = np.zeros(len(replay.columns))
    chosen = [
        replay.columns.index(name) for name in ("mass_change.factor", "road_bank.bank", "caliper_lag.time_constant")
    ]
    single = Replay(replay.vehicle, replay.manoeuvres, threads=1)
    together = replay.sensitivities(theta, chosen)
    for place, column in enumerate(chosen):
        alone = single.sensitivities(theta, [column])
        for m in range(len(together)):
            assert np.array_equal(alone[m][:, :, 0], together[m][:, :, place])


def _shown(replay: Replay) -> dict[str, float]:
    """Change of all signals in their sensors' noise by one effect width, root of the sum of squares, by column."""
    total = np.zeros(len(replay.columns))
    for prepared, values in zip(replay.prepared, replay.sensitivities(np.zeros(len(total))), strict=True):
        noise = np.array([replay.sensor_std(signal) for signal in prepared.signals])
        shown = values / noise[None, :, None] * prepared.weights[:, :, None]
        total += np.einsum("ncp,ncp->p", shown, shown)
    widths = np.array([parameter.effect_std for parameter in replay.parameters])
    return dict(zip(replay.columns, np.sqrt(total) * widths, strict=True))


def test_sensitivities_tell_what_the_drives_show(replay: Replay) -> None:
    excited = _shown(replay)
    # no disc came near its fade temperature, no valve command and no step of friction is in these logs
    for column in ("brake_pad_fade.temperature", "inlet_valve_delay.delay", "mu_step.place", "pump_rate.factor"):
        assert excited[column] < 1e-9
    for column in ("mass_change.factor", "brake_pad_friction.factor", "tyre_cornering_stiffness.rear"):
        assert excited[column] > 100.0


COMMON = {
    "form_axles_alike.friction_factor": ("tyre_friction.front", "tyre_friction.rear"),
    "form_axles_alike.spring_rate": ("spring_rate.front", "spring_rate.rear"),
    "form_axles_alike.support_angle": ("anti_dive_anti_lift.front", "anti_dive_anti_lift.rear"),
}


@pytest.mark.parametrize("common", COMMON)
def test_what_both_axles_have_in_common_is_the_sum_of_theirs(replay: Replay, common: str) -> None:
    """As predictions and as slopes: in a stop about the limit three differences of their own are 2 to 6 % apart, which
    kept a lack of friction in the column that no cause may have."""
    theta = np.zeros(len(replay.columns))
    together, front, rear = (replay.columns.index(name) for name in (common, *COMMON[common]))
    theta[[together, front]] = -0.08, 0.03
    by_axle = np.zeros_like(theta)
    by_axle[[front, rear]] = -0.05, -0.08
    np.testing.assert_allclose(replay.predict(by_axle, PULSED), replay.predict(theta, PULSED), rtol=1e-12, atol=1e-12)
    # in any order, and without the axles' own
    of_front, of_common, of_rear = np.moveaxis(replay.sensitivities(theta, [front, together, rear])[PULSED], 2, 0)
    np.testing.assert_allclose(of_common, of_front + of_rear, rtol=1e-12)
    np.testing.assert_array_equal(replay.sensitivities(theta, [together])[PULSED][:, :, 0], of_common)


def test_an_inertia_that_spins_with_the_wheels_adds_to_their_own(replay: Replay) -> None:
    """J of the data sheet, (1 + deviation) of it, and what a driveline adds: no difference of its own can then tell the
    added inertia from that of the driven wheels."""
    names = ("form_wheel_inertia.front", "form_wheel_inertia.rear", "wheel_inertia_reflected.inertia")
    front, rear, reflected = (replay.columns.index(name) for name in names)
    inertia, driven = (replay.car.record[0][name] for name in ("spin_inertia", "drive_share"))
    axle = front if driven[0] > 0.0 else rear
    own, added, theta = 0.04, 0.2, np.zeros(len(replay.columns))
    theta[[axle, reflected]] = own, added
    as_own = np.zeros_like(theta)
    as_own[axle] = own + added / inertia[0 if axle == front else 2]
    np.testing.assert_allclose(replay.predict(theta, PULSED), replay.predict(as_own, PULSED), rtol=1e-9, atol=1e-9)
    of_axle, of_added = np.moveaxis(replay.sensitivities(theta, [axle, reflected])[PULSED], 2, 0)
    np.testing.assert_allclose(of_added, of_axle / inertia[0 if axle == front else 2], rtol=1e-12)


@pytest.mark.parametrize(("common", "size"), [("brake_pad_friction.factor", 0.05), ("brake_balance.shift", 0.03)])
def test_what_all_brakes_have_in_common_is_the_product_with_their_own(replay: Replay, common: str, size: float) -> None:
    """(1 + pads) (1 + own) of a wheel: what one gains and the other loses leaves the torque, and no slope may tell it.

    Differences of their own are a percent apart in a pulsed stop, where a tenth of that is worth a log evidence of 100.
    """
    theta = np.zeros(len(replay.columns))
    together, *own = (replay.columns.index(name) for name in (common, *(f"wheel_brake_weak.{w}" for w in WHEELS)))
    theta[own] = -0.2, 0.1, 0.02, -0.03
    torque = replay.car.record[0]["torque_per_pressure"]
    rear = size if common.startswith("brake_pad") else -size * torque[0] / torque[2]
    by_wheel, factors = theta.copy(), 1.0 + np.array([size, size, rear, rear])
    theta[together] = size
    by_wheel[own] = (1.0 + theta[own]) * factors - 1.0
    np.testing.assert_allclose(replay.predict(by_wheel, PULSED), replay.predict(theta, PULSED), rtol=1e-9, atol=1e-9)
    of_common, *of_own = np.moveaxis(replay.sensitivities(theta, [together, *own])[PULSED], 2, 0)
    shares = (1.0 + theta[own]) * (factors - 1.0) / size / factors
    np.testing.assert_allclose(of_common, np.tensordot(shares, of_own, 1), rtol=1e-9, atol=1e-9)
