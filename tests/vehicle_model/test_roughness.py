"""Roughness against ISO 8608 and the coherence of an isotropic surface, by Welch estimates; the car on a rough road."""

import numpy as np
import pytest
from scipy.signal import coherence as welch_coherence
from scipy.signal import welch

from signals.errors import InputError
from vehicle_model import Plant, load_vehicle
from vehicle_model.road import RoadTables, height_at
from vehicle_model.road_file import RoadFile, Roughness
from vehicle_model.roughness import POINTS, SPACING_M, coherence, spectrum, two_tracks
from vehicle_model.roughness_classes import CLASS_LEVELS

SEGMENT = 2048  # 102.4 m: lines 0.0098 cycles/m apart


def band_means(frequency: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Means in octave bands from 0.05 to 1.6 cycles/m."""
    edges = 0.05 * 2.0 ** np.arange(5)
    bands = [(frequency >= low) & (frequency < 2 * low) for low in edges]
    return np.array([values[band].mean() for band in bands])


def test_classes_are_those_of_iso_8608() -> None:
    # table C.1, geometric means in 1e-6 m^3 at 0.1 cycles/m
    assert {name: round(level * 1e6) for name, level in CLASS_LEVELS.items()} == {
        "A": 16, "B": 64, "C": 256, "D": 1024, "E": 4096, "F": 16384, "G": 65536, "H": 262144,
    }  # fmt: skip


@pytest.mark.parametrize(("name", "waviness"), [("A", 2.0), ("C", 2.0), ("C", 2.5)])
def test_both_tracks_have_the_spectrum_of_the_standard(name: str, waviness: float) -> None:
    level = CLASS_LEVELS[name]
    tracks = np.concatenate([two_tracks(level, waviness, 1.5, k) for k in range(6)], axis=0)
    for side in range(2):
        estimates = [welch(track, 1.0 / SPACING_M, nperseg=SEGMENT)[1] for track in tracks[side::2]]
        frequency = welch(tracks[side], 1.0 / SPACING_M, nperseg=SEGMENT)[0]
        found = band_means(frequency, np.mean(estimates, axis=0))
        wanted = band_means(frequency, np.concatenate(([0.0], spectrum(frequency[1:], level, waviness))))
        # 6 tracks of 15 half-overlapping segments and at least 5 lines per octave: standard error below 4 %
        assert found == pytest.approx(wanted, rel=0.12)


@pytest.mark.parametrize("track", [0.75, 1.5, 3.0])
def test_coherence_of_the_tracks_is_that_of_an_isotropic_surface(track: float) -> None:
    estimates = []
    for k in range(8):
        left, right = two_tracks(CLASS_LEVELS["B"], 2.0, track, 100 + k)
        frequency, squared = welch_coherence(left, right, 1.0 / SPACING_M, nperseg=SEGMENT // 2)
        estimates.append(squared)
    found = band_means(frequency, np.mean(estimates, axis=0))
    wanted = band_means(frequency, coherence(frequency, track) ** 2)
    # magnitude-squared coherence of 31 segments is biased by about (1 - γ²)/20 with half-overlapping Hann windows
    assert found == pytest.approx(wanted, abs=0.08)


def test_coherence_has_its_limits() -> None:
    n = np.array([0.0, 1e-4, 0.1, 10.0])
    assert coherence(n, 1.5)[:2] == pytest.approx([1.0, 1.0], abs=1e-4)
    assert coherence(n, 1.5)[3] < 1e-10
    # w = 2: x K_1(x) with x = 2 π b n; x = 1 gives K_1(1) = 0.60191 (Abramowitz and Stegun, table 9.8)
    assert coherence(np.array([1.0 / (2.0 * np.pi * 1.5)]), 1.5)[0] == pytest.approx(0.6019072302, rel=1e-9)


def test_interpolated_height_meets_the_points_and_has_the_slope_of_its_curve() -> None:
    heights = two_tracks(CLASS_LEVELS["C"], 2.0, 1.5, 7)
    for k in (0, 1, 777, POINTS - 1, POINTS + 3, -5):
        assert height_at(heights, 1, k * SPACING_M)[0] == pytest.approx(heights[1, k % POINTS], abs=1e-12)
    for x in (0.013, 12.34, 500.001, -3.31):
        difference = (height_at(heights, 0, x + 1e-6)[0] - height_at(heights, 0, x - 1e-6)[0]) / 2e-6
        assert height_at(heights, 0, x)[1] == pytest.approx(difference, rel=1e-5)


def test_same_realisation_is_the_same_road() -> None:
    assert np.array_equal(two_tracks(1e-4, 2.0, 1.5, 3), two_tracks(1e-4, 2.0, 1.5, 3))
    assert not np.allclose(two_tracks(1e-4, 2.0, 1.5, 3), two_tracks(1e-4, 2.0, 1.5, 4))


def test_class_gives_the_level_and_must_not_contradict_it() -> None:
    assert Roughness(iso_class="D").level == pytest.approx(1024e-6)
    assert Roughness.model_validate(Roughness(iso_class="D").model_dump()).level == pytest.approx(1024e-6)
    with pytest.raises(ValueError, match="not that of class D"):
        Roughness(iso_class="D", level=16e-6)
    road = RoadTables(RoadFile())
    with pytest.raises(InputError, match="out of range"):
        road.set("road.roughness.level", -1.0)


def drive(road: RoadFile, speed: float, seconds: float) -> tuple[Plant, np.ndarray]:
    """Outputs of a car that rolls freely, a row per 10 ms."""
    car = Plant(load_vehicle("ekf_car"), road)
    car.reset(speed_m_s=speed)
    rows = []
    for _ in range(round(seconds * 100)):
        car.step(10)
        rows.append(car.outputs.copy())
    return car, np.array(rows)


def test_wheel_loads_vary_with_the_class_and_keep_their_mean() -> None:
    from vehicle_model.interface import PLANT_OUTPUTS

    load = PLANT_OUTPUTS.index("vertical_load_fl")
    deviations = {}
    for name in ("A", "C"):
        _, rows = drive(RoadFile(roughness=Roughness(iso_class=name)), 25.0, 6.0)
        loads = rows[100:, load]
        smooth = 1296.0 * 9.81 * 0.5 * 0.5  # order of a wheel's static load
        assert loads.mean() == pytest.approx(smooth, rel=0.15)
        deviations[name] = loads.std()
    # the car is linear while no wheel lifts: four times the class is sixteen times the level, four times the load's rms
    assert deviations["C"] / deviations["A"] == pytest.approx(4.0, rel=0.1)


def test_rough_road_takes_its_work_from_the_cars_motion_and_creates_none() -> None:
    losses = {}
    for name in (None, "D"):
        car, rows = drive(RoadFile(roughness=Roughness(iso_class=name)), 20.0, 5.0)
        state = car.state()
        start = 0.5 * 1296.0 * 20.0**2
        assert state["speed"] < 20.0
        losses[name] = car.energy_account()["damper_energy"]
        drift = state["mechanical_energy"] + state["dissipated_energy"] - state["drive_energy"]
        first = rows[0]
        from vehicle_model.interface import PLANT_OUTPUTS

        begin = first[PLANT_OUTPUTS.index("mechanical_energy")] + first[PLANT_OUTPUTS.index("dissipated_energy")]
        assert abs(drift - begin) / start < 5e-4
    assert losses["D"] > 20.0 * max(losses[None], 1.0)


def test_roughness_switched_off_on_line_leaves_a_smooth_road() -> None:
    car = Plant(load_vehicle("ekf_car"), RoadFile())
    car.reset(speed_m_s=20.0)
    car.step(200)
    car.set("road.roughness.level", CLASS_LEVELS["D"])
    car.step(500)
    shaken = abs(car.state()["true_vertical_acceleration"])
    car.set("road.roughness.level", 0.0)
    car.step(4000)
    assert abs(car.state()["true_vertical_acceleration"]) < min(0.01, shaken)
