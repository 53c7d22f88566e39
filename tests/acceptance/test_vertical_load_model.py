"""Model of the vertical load document (L-1 to L-6): parameters, matrices, discretisation, wheel loads."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.linalg import expm
from vertical_load_experiments import (
    KMH,
    SAMPLE_S,
    document_record,
    matrices,
)

from estimators.vertical_load_model import discretise, wheel_loads
from vehicle_model.vehicle_file import load_vehicle


@pytest.mark.acceptance("L-1")
def test_parameters_are_data_with_their_lines() -> None:
    vehicle = load_vehicle("e_class_suv")
    car = document_record()
    lines = {
        "two_track.cornering_stiffness_front": (car["stiffness"][0], 129487.0, "l. 432"),
        "two_track.cornering_stiffness_rear": (car["stiffness"][1], 129487.0, "l. 433"),
        "body.centre_of_gravity_to_front_axle": (car["to_front"], 1.18, "l. 434"),
        "body.wheelbase": (car["to_front"] + car["to_rear"], 2.95, "l. 434"),
        "body.yaw_inertia": (car["yaw_inertia"], 2488.0, "l. 436"),
        "body.mass": (car["mass"], 1862.0, "l. 437"),
        "planar.roll_stiffness": (car["roll_stiffness"], 135206.0, "l. 438"),
        "planar.roll_damping": (car["roll_damping"], 20651.0, "l. 439"),
        "two_track.sprung_mass": (car["sprung_mass"], 1592.0, "l. 440"),
        "two_track.roll_axis_inertia": (car["roll_inertia"], 614.0, "l. 442"),
        "axles.front.track": (car["track"], 1.575, "l. 443"),
        "two_track.roll_centre_height": (car["roll_centre"], 0.334, "l. 444"),
        "body.centre_of_gravity_height": (car["height"], 0.719, "l. 445"),
    }
    for path, (used, printed, line) in lines.items():
        assert used == pytest.approx(printed, rel=1e-12), path
        assert line in vehicle.sources[path]
    assert car["roll_arm"] == pytest.approx(0.385)


@pytest.mark.acceptance("L-2")
def test_matrices_of_the_model(record: Callable[..., None]) -> None:
    printed = {
        50.0: ((-20.0281, -7.9806), (4.42171, -33.9145), (-19.9928, 5.8979, -210.4125, -33.6336), 5.9083),
        70.0: ((-14.3058, -15.2242), (3.15837, -24.2247), (-14.2806, 4.2128, -210.4125, -33.6336), 4.2202),
    }
    worst = 0.0
    for kmh, (lateral, yaw, roll, c12) in printed.items():
        a, b, c, d = matrices(kmh * KMH)
        pairs = [*zip(a[0, :2], lateral, strict=True), *zip(a[1, :2], yaw, strict=True), *zip(a[3], roll, strict=True)]
        pairs += [(c[0, 0], lateral[0]), (c[0, 1], c12), (b[0], 139.0838), (b[1], 122.8253), (b[3], 138.8391)]
        pairs += [(d[0], 139.0838)]
        worst = max(worst, *(abs(found / wanted - 1.0) for found, wanted in pairs))
        lever = 1592.0 * 0.385 / 614.0
        assert a[3, 0] == pytest.approx(lever * a[0, 0], rel=1e-12)
        assert b[3] == pytest.approx(lever * b[0], rel=1e-12)
        assert c[0, 1] == pytest.approx(a[0, 1] + kmh * KMH, rel=1e-12)
    record("largest relative deviation of A, B, C, D", worst, "<= 1e-4 (4 digits)")
    assert worst <= 1e-4


@pytest.mark.acceptance("L-3", "L-4")
def test_roll_of_the_body(record: Callable[..., None]) -> None:
    a, _, _, _ = matrices(70.0 * KMH)
    lever = 1592.0 * 0.385 / 614.0
    angle = lever / -a[3, 2]  # rest of (10c) at a_y = 1 m/s^2
    record("roll angle per lateral acceleration", angle, "4.744e-3 rad per m/s^2", id="L-3")
    assert angle == pytest.approx(4.744e-3, abs=1e-6)
    loads = np.zeros(4)
    wheel_loads(document_record(), 0.0, 1.0, angle, 0.0, True, loads)
    assert loads[1] > 5480.0 > loads[0]
    assert loads[3] > 3653.0 > loads[2]
    poles = np.sort(np.linalg.eigvals(a[2:, 2:]).real)
    record("slow pole of the roll model", poles[1], "-8.308 1/s +- 0.01", id="L-4")
    record("fast pole of the roll model", poles[0], "-25.325 1/s +- 0.01", id="L-4")
    assert poles == pytest.approx([-25.325, -8.308], abs=0.01)


@pytest.mark.acceptance("L-5")
@pytest.mark.parametrize("speed", [1.0, 3.0, 70.0 * KMH, 80.0])
def test_zero_order_hold_is_exact(speed: float, record: Callable[..., None]) -> None:
    a, b, _, _ = matrices(speed)
    phi, gamma = np.zeros((4, 4)), np.zeros(4)
    discretise(a, b, SAMPLE_S, phi, gamma, np.zeros((4, 5, 5)))
    augmented = np.zeros((5, 5))
    augmented[:4, :4], augmented[:4, 4] = a, b
    exact = expm(augmented * SAMPLE_S)  # scipy: Pade approximation, another algorithm
    assert np.abs(phi - exact[:4, :4]).max() < 1e-12
    assert np.abs(gamma - exact[:4, 4]).max() < 1e-12
    if speed == 70.0 * KMH:
        printed = [
            [0.864688, -0.125516, 0, 0, 1.212658],
            [0.026039, 0.782912, 0, 0, 1.109293],
            [-0.000607, 0.000204, 0.990582, 0.008462, 0.006005],
            [-0.111521, 0.039947, -1.780578, 0.705964, 1.115555],
        ]
        deviation = float(np.abs(np.column_stack([phi, gamma]) - printed).max())
        record("largest deviation of Phi, Gamma", deviation, "<= 1e-5")
        assert deviation <= 1e-5


@pytest.mark.acceptance("L-6")
def test_wheel_loads(record: Callable[..., None]) -> None:
    car, loads = document_record(), np.zeros(4)
    random = np.random.default_rng(5)
    for _ in range(200):
        wheel_loads(car, *random.uniform([-4, -4, -0.02, -0.05], [4, 4, 0.02, 0.05]), True, loads)
        if loads.min() > 0.0:
            assert loads.sum() == pytest.approx(1862.0 * 9.81, abs=1e-9 * 1862.0 * 9.81)
    wheel_loads(car, 0.0, 1.0, 4.744e-3, 0.0, True, loads)
    total = loads[1] + loads[3] - loads[0] - loads[2]
    record("difference right minus left per lateral acceleration", total, "1604 N +- 2 N")
    assert total == pytest.approx(1604.0, abs=2.0)
    wheel_loads(car, -3.0, 0.0, 0.0, 0.0, True, loads)
    record("front wheel at -3 m/s^2", loads[0] - 5480.0, "+680.7 N")
    assert loads[:2] - 0.5 * car["static_load"][0] == pytest.approx(680.7, abs=0.1)
    assert loads[2:] - 0.5 * car["static_load"][1] == pytest.approx(-680.7, abs=0.1)
