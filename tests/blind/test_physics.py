"""The generator's simulator against closed forms: energy, stopping distance, steady circle, load transfer, pitch."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hidden_effects.brakes import released, wheel_pressure
from hidden_effects.car import GRAVITY_M_S2, Numbers, as_record, nominal_car
from hidden_effects.chassis import pitch_rates, roll_rates, sprung_inertias
from hidden_effects.manoeuvres import HELD_OUT, SIX, Script, nothing, ramps
from hidden_effects.outputs import INDEX
from hidden_effects.simulator import STEP_S, commanded, simulate
from hidden_effects.tyre import ARCTANGENT, EXPONENTIAL, exponential, steady_forces

WHEELS = ("fl", "fr", "rl", "rr")


def _columns(out: np.ndarray, name: str) -> np.ndarray:
    return np.stack([out[:, INDEX[f"{name}_{wheel}"]] for wheel in WHEELS], axis=1)


def _changed(**numbers: object) -> Numbers:
    return nominal_car() | {name: np.array(value, float) for name, value in numbers.items()}


@pytest.mark.parametrize("script", SIX + HELD_OUT, ids=lambda script: script.name)
def test_work_of_all_forces_is_the_change_of_kinetic_energy(script: Script) -> None:
    out = simulate(as_record(nominal_car()), script.drive())
    change = out[-1, INDEX["kinetic_energy"]] - out[0, INDEX["kinetic_energy"]]
    throughput = np.abs(np.diff(out[:, INDEX["kinetic_energy"]])).sum()
    assert out[-1, INDEX["work"]] == pytest.approx(change, abs=5e-4 * throughput)


def test_energy_goes_where_forces_take_it() -> None:
    """Brakes, rolling, slip and air, integrated from the recorded forces, take the whole kinetic energy of a stop."""
    script = SIX[2]
    car = nominal_car()
    out = simulate(as_record(car), script.drive())
    spin, speed = _columns(out, "wheel_speed"), out[:, 0]
    brakes = (_columns(out, "brake_torque") * np.abs(spin)).sum(axis=1)
    rolling = (float(car["rolling_resistance"][0]) * _columns(out, "load") * 0.278 * spin).sum(axis=1)
    slip = (_columns(out, "force_x") * (speed[:, None] - 0.278 * spin)).sum(axis=1)
    air = 0.5 * 1.2 * 0.8 * speed**3
    lost = np.sum(brakes + rolling - slip + air) * 1e-3
    change = out[0, INDEX["kinetic_energy"]] - out[-1, INDEX["kinetic_energy"]]
    assert lost == pytest.approx(change, rel=0.01)


def test_locked_stop_takes_v2_over_2_mu_g() -> None:
    """All wheels locked, one friction, no air: from 20 m/s to 5 m/s."""
    locked_share = math.sin(1.316 * math.atan(14.34))
    car = _changed(peak_x=[0.8] * 4, drag_area=0.0, abs_slip=2.0, rolling_resistance=[0.0] * 4)
    car["pad_gain"] = car["pad_gain"] * 5.0
    press = Script("locked", 27.0, 6.0, ramps((0, 500), (10, 500)), nothing, nothing)
    out = simulate(as_record(car), press.drive())
    fast, slow = int(np.argmax(out[:, 0] < 20.0)), int(np.argmax(out[:, 0] < 5.0))
    assert np.all(_columns(out, "wheel_speed")[fast:slow] == 0.0)
    distance = out[slow, INDEX["distance"]] - out[fast, INDEX["distance"]]
    expected = (out[fast, 0] ** 2 - out[slow, 0] ** 2) / (2.0 * 0.8 * locked_share * GRAVITY_M_S2)
    assert distance == pytest.approx(expected, rel=2e-3)


def test_steady_circle_has_the_yaw_gain_of_the_linear_single_track_car() -> None:
    """r = v delta / (L + K v^2), K = m/L ((b + n)/Cf - (a - n)/Cr) with side forces a trail n behind the wheels'
    centres; stiff steering, small angle; C = 2 Fz B C D per axle."""
    car = _changed(steering_stiffness=1e9, rolling_resistance=[0.0] * 4, drag_area=0.0, side_area=0.0)
    speed, wheel = 20.0, 0.08
    turn = Script("circle", speed, 6.0, nothing, ramps((0, 0), (1, wheel), (9, wheel)), nothing)
    out = simulate(as_record(car), turn.drive())
    a, wheelbase, mass, trail = 1.25, 2.57, 1296.0, 0.03
    b = wheelbase - a
    slope = 1.4 * 13.0
    front, rear = mass * GRAVITY_M_S2 * b / wheelbase * slope, mass * GRAVITY_M_S2 * a / wheelbase * slope
    gradient = mass / wheelbase * ((b + trail) / front - (a - trail) / rear)
    v = out[-1, 0]
    expected = v * wheel / 16.0 / (wheelbase + gradient * v * v)
    assert out[-1, 2] == pytest.approx(expected, rel=0.02)


def test_braking_moves_m_a_h_over_l_to_the_front() -> None:
    """Settled: the springs carry m a h / (L (1 - m g h / K)), the weight of the pitched body included."""
    press = Script("brake", 30.0, 4.0, ramps((0, 0), (0.5, 90), (9, 90)), nothing, nothing)
    car = nominal_car()
    car["drag_area"] = np.array(0.0)
    out = simulate(as_record(car), press.drive())
    load, force = _columns(out, "load")[-1], _columns(out, "force_x")[-1]
    stiffness, _ = pitch_rates(as_record(car))
    softness = 1.0 - 1296.0 * GRAVITY_M_S2 * 0.535 / stiffness
    front_at_rest = 1296.0 * GRAVITY_M_S2 * 1.32 / 2.57
    expected = -force.sum() * 0.535 / 2.57 / softness
    assert load[:2].sum() - front_at_rest == pytest.approx(expected, rel=0.01)
    assert load.sum() == pytest.approx(1296.0 * GRAVITY_M_S2, rel=1e-9)


@pytest.mark.parametrize("axle", [0, 1], ids=["front", "rear"])
def test_lift_over_an_axle_lightens_it_and_pitches_the_body(axle: int) -> None:
    """Rolling at constant speed: F = rho/2 A c v^2 lightens that axle, (K - m g h) theta = F times its arm; from the
    first instant on, as before it nothing else was."""
    coefficient = [0.0, 0.0]
    coefficient[axle] = 0.2
    car = _changed(drag_area=0.0, rolling_resistance=[0.0] * 4, lift_coefficient=coefficient)
    out = simulate(as_record(car), Script("roll", 30.0, 3.0, nothing, nothing, nothing).drive())
    lifted = 0.5 * 1.2 * 2.0 * 0.2 * 30.0**2
    stiffness, _ = pitch_rates(as_record(car))
    moment = lifted * (-1.25, 1.32)[axle]
    angle = moment / (stiffness - 1296.0 * GRAVITY_M_S2 * 0.535)
    assert out[[0, -1], INDEX["pitch_angle"]] == pytest.approx(angle, rel=1e-3)
    load, at_rest = _columns(out, "load")[-1], 0.5 * 1296.0 * GRAVITY_M_S2 * np.array([1.32, 1.32, 1.25, 1.25]) / 2.57
    # the weight of the pitched body moves to the side to which it leans
    shifted = 0.5 * 1296.0 * GRAVITY_M_S2 * 0.535 * angle / 2.57 * np.array([1.0, 1.0, -1.0, -1.0])
    lighter = np.zeros(4)
    lighter[2 * axle : 2 * axle + 2] = 0.5 * lifted
    assert load == pytest.approx(at_rest + shifted - lighter, rel=1e-6)


@pytest.mark.parametrize("axle", [0, 1], ids=["front", "rear"])
def test_support_of_an_axle_takes_its_own_moment_from_the_springs(axle: int) -> None:
    """Settled: (K - m g h) theta = -h sum F + tan(eps) F_axle times that axle's arm about the centre of gravity, with
    what the slowing wheels hand on to the body and less what rolling resistance turns it back."""
    press = Script("brake", 30.0, 4.0, ramps((0, 0), (0.5, 90), (9, 90)), nothing, nothing)
    angle = [0.0, 0.0]
    angle[axle] = math.atan(0.1)
    car = _changed(drag_area=0.0, support_angle=angle)
    out = simulate(as_record(car), press.drive())
    force = _columns(out, "force_x")[-1]
    stiffness, _ = pitch_rates(as_record(car))
    taken = 0.1 * force[2 * axle : 2 * axle + 2].sum() * (1.25, 1.32)[axle]
    expected = (-0.535 * force.sum() + taken + _about_wheels(out)) / (stiffness - 1296.0 * GRAVITY_M_S2 * 0.535)
    assert out[-1, INDEX["pitch_angle"]] == pytest.approx(expected, rel=0.003)


def test_raised_links_jack_an_axle_up_by_the_difference_of_its_side_forces() -> None:
    """Settled circle, the front roll centre up: (K - m g h) theta is less by 2 h_R/track (F_outer - F_inner) a."""
    turn = Script("circle", 20.0, 6.0, nothing, ramps((0, 0), (1, 0.6), (9, 0.6)), nothing)
    lifted, unlifted = [
        simulate(as_record(_changed(steering_stiffness=1e9, roll_centre=[height, 0.0])), turn.drive())
        for height in (0.1, 0.0)
    ]
    stiffness, _ = pitch_rates(as_record(nominal_car()))
    softened = stiffness - 1296.0 * GRAVITY_M_S2 * 0.535
    steer = np.array([0.6, 0.6, 0.0, 0.0]) / 16.0
    of_tyre, across = _columns(lifted, "force_x")[-1], _columns(lifted, "force_y")[-1]
    along = of_tyre * np.cos(steer) - across * np.sin(steer)
    side = across * np.cos(steer) + of_tyre * np.sin(steer)
    angle = -0.535 * along.sum() + _about_wheels(lifted)
    assert side[1] > 1.2 * side[0] > 0.0  # a left turn loads the right wheel
    angle -= 2.0 * 0.1 / 1.46 * (side[1] - side[0]) * 1.25
    assert lifted[-1, INDEX["pitch_angle"]] == pytest.approx(angle / softened, rel=0.02)
    assert lifted[-1, INDEX["pitch_angle"]] < unlifted[-1, INDEX["pitch_angle"]]


def _about_wheels(out: np.ndarray) -> float:
    """Moment on the body by the wheels' change of spin over the last 0.1 s and by rolling resistance [N m]."""
    spin = _columns(out, "wheel_speed")
    slowing = -0.8 * (spin[-1] - spin[-101]).sum() / 0.1
    return float(slowing - 0.015 * 0.278 * _columns(out, "load")[-1].sum())


def test_spinning_wheels_lean_the_turning_car_outwards() -> None:
    """Steady circle: (K - m g h) phi = h sum F_y + r J sum(omega), the moment that turns the wheels' momentum."""
    car = _changed(steering_stiffness=1e9, drag_area=0.0, side_area=0.0)
    turn = Script("circle", 25.0, 6.0, nothing, ramps((0, 0), (1, 0.3), (9, 0.3)), nothing)
    out = simulate(as_record(car), turn.drive())
    record = as_record(car)
    stiffness = sum(roll_rates(record, axle)[0] for axle in range(2)) - 1296.0 * GRAVITY_M_S2 * 0.535
    yaw_rate, lateral = out[-1, INDEX["yaw_rate"]], _columns(out, "force_y")[-1].sum()
    turned = yaw_rate * 0.8 * _columns(out, "wheel_speed")[-1].sum()
    assert turned > 0.01 * 0.535 * lateral  # an effect that the tolerance below would not let pass
    assert out[-1, INDEX["roll_angle"]] == pytest.approx((0.535 * lateral + turned) / stiffness, rel=0.003)


def test_a_dumped_brake_gives_no_more_fluid_than_its_accumulator_takes() -> None:
    """With the pump at rest the pressure falls by capacity times stiffness, however long the outlet is open."""
    record = as_record(_changed(accumulator_volume=2e-7))
    volumes, pressure = np.zeros(2), 8e6
    for _ in range(400):
        lower = wheel_pressure(record, 0, pressure, 8e6, 0.0, 0.0, 1.0, 5e-4)
        pressure = released(record, 0, volumes, 0, pressure, lower)
    assert pressure == pytest.approx(8e6 - 2e-7 * 7e12, rel=1e-9)
    assert volumes[0] == pytest.approx(2e-7, rel=1e-9)


@pytest.mark.parametrize("delay", [0.0, 1e-4, 0.00444, 0.0101])
def test_a_late_valve_is_late_by_its_delay_and_not_by_whole_steps(delay: float) -> None:
    """A command of 1 from the instant of cycle 3 on, 25 ms: the sum of what acts is the time since then."""
    cycles = np.zeros((20, 4))
    cycles[3:] = 1.0
    acting = sum(commanded(cycles, 0, n * STEP_S - delay) for n in range(200)) * STEP_S
    assert acting == pytest.approx(0.1 - 0.025 - delay, abs=1e-9)


def test_pitch_rings_with_its_own_frequency() -> None:
    """After release of the brake: damped natural frequency of the second-order body."""
    car = nominal_car()
    car["damper_rate"] = car["damper_rate"] * 0.2
    release = Script("ring", 30.0, 5.0, ramps((0, 120), (1.5, 120), (1.52, 0), (9, 0)), nothing, nothing)
    out = simulate(as_record(car), release.drive())
    pitch_rate = out[2200:, INDEX["pitch_rate"]]
    crossings = np.flatnonzero((pitch_rate[:-1] < 0.0) & (pitch_rate[1:] >= 0.0))
    period = float(np.mean(np.diff(crossings))) * 1e-3
    stiffness, damping = pitch_rates(as_record(car))
    _, inertia = sprung_inertias(as_record(car))
    assert inertia == pytest.approx(1520.0 - 38.0 * (2.0 * 1.25**2 + 2.0 * 1.32**2 + 4.0 * (0.535 - 0.278) ** 2))
    free = (stiffness - 1296.0 * GRAVITY_M_S2 * 0.535) / inertia
    expected = 2.0 * math.pi / math.sqrt(free - (damping / (2.0 * inertia)) ** 2)
    assert period == pytest.approx(expected, rel=0.01)


def test_discs_take_the_heat_of_the_brakes() -> None:
    """Without cooling: 0.9 of the work of each brake over the heat capacity."""
    car = _changed(disc_cooling=0.0, disc_cooling_speed=0.0)
    out = simulate(as_record(car), SIX[1].drive())
    work = (_columns(out, "brake_torque") * _columns(out, "wheel_speed")).sum(axis=0) * 1e-3
    warmer = _columns(out, "disc")[-1] - 20.0
    assert warmer == pytest.approx(0.9 * work / 4000.0, rel=5e-3)


def test_friction_rises_within_a_stop_and_begins_anew_with_the_next() -> None:
    """mu (1 + a E/E0), E what the brakes took since they were last released, in two gentle stops."""
    rise = 0.2
    out, usual = (simulate(as_record(_changed(in_stop_rise=a)), SIX[1].drive()) for a in (rise, 0.0))
    torque, usual_torque = _columns(out, "brake_torque"), _columns(usual, "brake_torque")
    power = (torque * _columns(out, "wheel_speed")).sum(axis=1)
    for begin, at in ((0.8, 2.8), (4.5, 4.8), (4.5, 7.0)):
        energy = power[round(1e3 * begin) : round(1e3 * at)].sum() * 1e-3
        share = torque[round(1e3 * at), 0] / usual_torque[round(1e3 * at), 0]
        assert share == pytest.approx(1.0 + rise * energy / 5e5, abs=1e-3)


def test_left_and_right_mirror_each_other() -> None:
    """Left and right mirror each other in a straight ABS stop."""
    out = simulate(as_record(nominal_car()), SIX[2].drive())
    spin = _columns(out, "wheel_speed")
    assert np.array_equal(spin[:, 0], spin[:, 1])
    assert np.array_equal(spin[:, 2], spin[:, 3])


def test_abs_keeps_the_wheels_turning_and_uses_the_friction() -> None:
    out = simulate(as_record(nominal_car()), SIX[2].drive())
    fast = out[:, 0] > 8.0
    assert _columns(out, "wheel_speed")[fast].min() > 0.0
    begin, end = int(np.argmax(out[:, 0] < 28.0)), int(np.argmax(out[:, 0] < 10.0))
    deceleration = (out[begin, 0] - out[end, 0]) / (1e-3 * (end - begin))
    mean_friction = (1.12 + 0.98) / 2.0
    assert 0.75 * mean_friction * GRAVITY_M_S2 < deceleration < 1.05 * mean_friction * GRAVITY_M_S2


def test_both_curves_share_slope_peak_and_locked_value_and_differ_between() -> None:
    load, shape, stiffness = 4000.0, 1.316, 14.34

    def force(curve: float, slip: float) -> float:
        return steady_forces(curve, slip, 0.0, 1.0, 1.0, shape, 1.4, stiffness, 13.0, load)[0] / load

    for curve in (ARCTANGENT, EXPONENTIAL):
        assert force(curve, 1e-5) / 1e-5 == pytest.approx(shape * stiffness, rel=2e-3)
        assert max(force(curve, s) for s in np.linspace(0.01, 1.0, 500)) == pytest.approx(1.0, abs=2e-3)
        assert force(curve, 1.0) == pytest.approx(math.sin(shape * math.atan(stiffness)), rel=1e-3)
    largest = max(abs(force(ARCTANGENT, s) - force(EXPONENTIAL, s)) for s in np.linspace(0.0, 1.0, 200))
    assert 0.02 < largest < 0.2
    assert exponential(-0.1, shape, stiffness) == -exponential(0.1, shape, stiffness)


def test_replay_of_its_own_record_stays_on_it() -> None:
    drive = SIX[2].drive()
    out = simulate(as_record(nominal_car()), drive)
    again = simulate(as_record(nominal_car()), drive, recorded=out)
    rows = min(len(out), len(again))
    assert np.abs(_columns(again, "wheel_speed")[:rows] - _columns(out, "wheel_speed")[:rows]).max() < 0.4
    assert np.abs(again[:rows, 0] - out[:rows, 0]).max() < 0.02


def test_uphill_gravity_slows_the_car_and_its_accelerometer_does_not_see_it() -> None:
    """The wheels' spin is slowed too: g sin over mass plus 4 J / R^2."""
    coast = replace(SIX[0], steering_wheel_rad=nothing)
    flat = simulate(as_record(_changed(drag_area=0.0)), coast.drive())
    uphill = simulate(as_record(_changed(drag_area=0.0, grade=0.05)), coast.drive())
    rows = 2000
    change = (uphill[rows, 0] - flat[rows, 0]) / (rows * 1e-3)
    moved = 1296.0 + 4.0 * 0.8 / 0.278**2
    assert change == pytest.approx(-0.05 * GRAVITY_M_S2 * 1296.0 / moved, rel=0.01)
    sensed = uphill[:rows, INDEX["specific_force_x"]] - flat[:rows, INDEX["specific_force_x"]]
    assert np.abs(sensed).max() < 0.02
