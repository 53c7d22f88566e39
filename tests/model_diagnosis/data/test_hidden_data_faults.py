"""Data faults hidden in logs of a car that shares no code with the checks: the right kind, channel and value."""

from dataclasses import replace

import kinematic_car as car
import numpy as np
import pytest

from model_diagnosis.data import check_data

WHEELS = tuple(f"wheel_speed_{w}" for w in ("fl", "fr", "rl", "rr"))
PRESSURES = tuple(f"brake_pressure_{w}" for w in ("fl", "fr", "rl", "rr"))
INERTIAL = ("longitudinal_acceleration", "lateral_acceleration", "yaw_rate")


def times(factor, *names):
    return {"after": lambda log, random: {n: (t, y * (factor if n in names else 1.0)) for n, (t, y) in log.items()}}


def late(delay_s, *names):
    return {
        "before": lambda time, signals: {
            n: np.interp(time - delay_s, time, y) if n in names else y for n, y in signals.items()
        }
    }


def filtered(time_constant_s, name):
    return {
        "before": lambda time, signals: {n: car.lag(y, time_constant_s) if n == name else y for n, y in signals.items()}
    }


def swapped(one, other):
    return {"after": lambda log, random: {**log, one: log[other], other: log[one]}}


def changed(name, change):
    return {"after": lambda log, random: {**log, name: (log[name][0], change(log[name][1].copy(), random))}}


def _held(share):
    def hold(values, random):
        for k in range(1, len(values)):
            if random.random() < share:
                values[k] = values[k - 1]
        return values

    return hold


def _stuck(values, random):
    values[300:380] = values[300]
    return values


def _marked(marker):
    def mark(values, random):
        values[random.random(len(values)) < 0.02] = marker
        return values

    return mark


def _blank(values, random):
    values[random.random(len(values)) < 0.2] = np.nan
    return values


def _with_gap(log, random):
    time = log["speed"][0]
    keep = (time < 3.0) | (time > 4.8)
    return {n: (t[keep], y[keep]) for n, (t, y) in log.items()}


def _with_duplicates(log, random):
    rows = np.sort(np.concatenate((np.arange(len(log["speed"][0])), random.integers(0, 800, 20))))
    return {n: (t[rows], y[rows]) for n, (t, y) in log.items()}


FAULTS = {
    "yaw rate in degrees": (times(57.29578, "yaw_rate"), "channel_unit", ("yaw_rate",), 57.3, 0.01),
    "speed in km/h": (times(3.6, "speed"), "channel_unit", ("speed",), 3.6, 0.01),
    "acceleration in g": (times(1 / 9.80665, "longitudinal_acceleration"), "channel_unit", INERTIAL[:1], 0.102, 0.01),
    "steering in degrees": (
        times(57.29578, "steering_wheel_angle"), "channel_unit", ("steering_wheel_angle",), 57.3, 0.01,
    ),
    "wheels in rpm": (times(9.549297, *WHEELS), "channel_unit", WHEELS, 9.549, 0.01),
    "pressure in MPa": (times(0.1, *PRESSURES), "channel_unit", PRESSURES, 0.1, 0.01),
    "one pressure tenfold": (times(10.0, "brake_pressure_fl"), "channel_unit", ("brake_pressure_fl",), 10.0, 0.01),
    "yaw rate reversed": (times(-1.0, "yaw_rate"), "channel_sign", ("yaw_rate",), -1.0, 0.0),
    "lateral reversed": (times(-1.0, "lateral_acceleration"), "channel_sign", ("lateral_acceleration",), -1.0, 0.0),
    "steering reversed": (times(-1.0, "steering_wheel_angle"), "channel_sign", ("steering_wheel_angle",), -1.0, 0.0),
    "wheel reversed": (times(-1.0, "wheel_speed_rr"), "channel_sign", ("wheel_speed_rr",), -1.0, 0.0),
    "front wheels swapped": (swapped(WHEELS[0], WHEELS[1]), "channel_swap", WHEELS[:2], 2.0, 0.0),
    "rear wheels swapped": (swapped(WHEELS[2], WHEELS[3]), "channel_swap", WHEELS[2:], 2.0, 0.0),
    "left wheels swapped": (swapped(WHEELS[0], WHEELS[2]), "channel_swap", (WHEELS[0], WHEELS[2]), 2.0, 0.0),
    "axes swapped": (swapped(*INERTIAL[:2]), "channel_swap", INERTIAL[:2], 2.0, 0.0),
    "inertial unit late": (late(0.08, *INERTIAL), "can_latency", INERTIAL, 0.08, 0.15),
    "reference late": (late(0.3, "speed"), "clock_offset", ("speed",), 0.3, 0.05),
    "reference very late": (late(1.2, "speed"), "clock_offset", ("speed",), 1.2, 0.02),
    "yaw rate smoothed": (filtered(0.2, "yaw_rate"), "low_pass_channel", ("yaw_rate",), 0.2, 0.2),
    "held frames": (changed("yaw_rate", _held(0.25)), "frame_drop_hold", ("yaw_rate",), 0.25, 0.15),
    "held reference": (
        changed("speed", lambda y, random: y[np.arange(len(y)) // 10 * 10]), "gps_hold", ("speed",), 10.0, 0.0,
    ),
    "wrapped counter": (changed("speed", lambda y, random: y % 16.0), "counter_wrap", ("speed",), 16.0, 0.0),
    "wrapped at no round number": (
        changed("speed", lambda y, random: y % 10.24), "counter_wrap", ("speed",), 10.24, 0.0,
    ),
    "dead channel": (
        changed("yaw_rate", lambda y, random: 0.0 * y + 0.01), "constant_channel", ("yaw_rate",), 0.01, 0.0,
    ),
    "clipped": (
        changed("lateral_acceleration", lambda y, random: np.clip(y, -2.0, 2.0)),
        "saturated_channel", ("lateral_acceleration",), 2.0, 0.0,
    ),
    "stuck wheel": (changed("wheel_speed_fr", _stuck), "stuck_channel", ("wheel_speed_fr",), 0.8, 0.1),
    "blanks": (changed("yaw_rate", _blank), "not_a_number", ("yaw_rate",), 0.2, 0.15),
    "marker in the reference": (changed("speed", _marked(655.35)), "undefined_value", ("speed",), 655.35, 0.0),
    "marker of a wheel": (changed("wheel_speed_rl", _marked(-9999.0)), "undefined_value", WHEELS[2:3], 9999.0, 0.0),
    "zeros of a wheel": (changed("wheel_speed_fl", _marked(0.0)), "undefined_value", WHEELS[:1], 0.0, 0.0),
    "gap of 1.8 s": ({"after": _with_gap}, "gap", ("time",), 1.8, 0.02),
    "duplicates": ({"after": _with_duplicates}, "duplicate_samples", ("time",), 20.0, 0.0),
    "command": (
        {**late(-0.08, *PRESSURES), "quiet": PRESSURES}, "command_not_measurement", PRESSURES, 0.08, 0.5,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_hidden_fault_is_named_alone(name, recorded, vehicle):
    options, kind, channels, value, tolerance = FAULTS[name]
    faults, _ = check_data(recorded(seed=101, **options), vehicle)
    assert [(f.kind, f.channel) for f in faults] == [(kind, ", ".join(channels))]
    assert abs(faults[0].value) == pytest.approx(abs(value), rel=tolerance, abs=1e-9)


def test_repaired_units_bring_the_measured_motion_back(recorded, vehicle):
    clean = recorded(seed=102)
    _, repaired = check_data(recorded(seed=102, **times(57.29577951308232, "yaw_rate")), vehicle)
    for before, after in zip(clean, repaired, strict=True):
        np.testing.assert_allclose(after.channels["yaw_rate"], before.channels["yaw_rate"], atol=1e-6)


def test_wrapped_speed_is_back_at_the_wheels_level(recorded, vehicle):
    """Also in a manoeuvre that never crosses the wrap, which no jump betrays; one that is 0.02 off would be a grade."""
    clean = recorded(seed=103)
    _, repaired = check_data(recorded(seed=103, **changed("speed", lambda y, random: y % 16.0)), vehicle)
    for before, after in zip(clean, repaired, strict=True):
        np.testing.assert_allclose(after.channels["speed"], before.channels["speed"], atol=1e-5)


@pytest.mark.parametrize("seed", range(30))
def test_clean_data_have_no_fault(seed, recorded, vehicle):
    faults, repaired = check_data(recorded(seed=seed, off=0.03), vehicle)
    assert faults == []
    assert all(np.mean(m.weight(n)) > 0.98 for m in repaired for n in m.channels)


def test_forces_without_their_cause_are_not_compared(recorded, vehicle):
    manoeuvre = recorded(seed=105, kinds=("stop",))[0]
    force = 100.0 * np.sin(manoeuvre.time)
    added = dict.fromkeys(("longitudinal_force_fl", "lateral_force_fl"), force)
    weights = dict.fromkeys(added, np.ones(manoeuvre.samples))

    def checked(*kept):
        channels = {n: v for n, v in manoeuvre.channels.items() if n.startswith(kept)} | added
        return check_data([replace(manoeuvre, channels=channels, weights=dict(manoeuvre.weights) | weights)], vehicle)

    faults, repaired = checked("speed", "wheel_speed")
    assert [(f.kind, f.channel) for f in faults] == [
        ("missing_channel", "steering_wheel_angle"), ("missing_channel", "brake_pressure"),
    ]  # fmt: skip
    assert not set(added) & set(repaired[0].channels)
    faults, repaired = checked("speed", "wheel_speed", "brake_pressure", "steering")
    assert faults == []
    assert set(added) <= set(repaired[0].channels)


def test_a_slip_of_a_locked_wheel_that_rolls_is_no_measurement(recorded, vehicle):
    """A rig writes −1 where its slip is not defined; the force says that the wheel rolls. Locked, it stays."""
    manoeuvres = recorded(seed=104, kinds=("stop",))
    ones = np.ones(manoeuvres[0].samples)
    random = np.random.default_rng(1)
    rolling = np.arange(manoeuvres[0].samples) % 200 < 100
    for force, kinds in ((np.where(rolling, 20.0, -2000.0), {"undefined_value"}), (-2000.0 * ones, set())):
        slip = np.where(rolling, -1.0, -0.1) + 2e-4 * random.standard_normal(len(ones))
        added = {"slip_ratio_fl": slip, "longitudinal_force_fl": force, "vertical_load_fl": 3000.0 * ones}
        weights = dict.fromkeys(added, ones)
        rig = [replace(m, channels=dict(m.channels) | added, weights=dict(m.weights) | weights) for m in manoeuvres[:1]]
        faults, repaired = check_data(rig, vehicle)
        assert {fault.kind for fault in faults} == kinds
        masked = repaired[0].weight("slip_ratio_fl") == 0.0
        np.testing.assert_array_equal(masked, rolling if kinds else False)
