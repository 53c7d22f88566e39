"""Statistics of the generator's logs: noise and its colour, quantisation, jitter, losses, clocks, faults, scatter."""

import numpy as np
import pytest
from hidden_effects.car import DATA_SHEET, MOST_SCATTERS, as_record, draw_car, nominal_car
from hidden_effects.data_faults import FAULTS, Fault
from hidden_effects.manoeuvres import SIX
from hidden_effects.recording import CYCLE_S, Loggers, MessageLog, record
from hidden_effects.sensors import CHANNELS, MESSAGES, SENSOR_SHEET, noise, quantised
from hidden_effects.simulator import Drive, simulate

_PHASES = dict.fromkeys(MESSAGES, 0.0)
_IDEAL = {name: np.array(number.nominal, float) for name, number in SENSOR_SHEET.items()}


@pytest.fixture(scope="module")
def coast() -> tuple[np.ndarray, Drive]:
    drive = SIX[0].drive()
    return simulate(as_record(nominal_car()), drive), drive


@pytest.fixture(scope="module")
def stop() -> tuple[np.ndarray, Drive]:
    drive = SIX[2].drive()
    return simulate(as_record(nominal_car()), drive), drive


def _recorded(
    run: tuple[np.ndarray, Drive], *, fault: Fault | None = None, offset: float = 0.0
) -> dict[str, MessageLog]:
    loggers = Loggers(offset, _PHASES, (), fault)
    return record(run[0], run[1], _IDEAL, loggers, np.random.default_rng(5))


def test_noise_has_its_standard_deviation_and_colour() -> None:
    channel = CHANNELS["longitudinal_acceleration"]
    drawn = noise(channel, 200_000, np.random.default_rng(1))
    # 3.3 standard errors of N_eff = N (1 - a^2) / (1 + a^2) independent samples
    assert np.std(drawn) == pytest.approx(channel.noise, rel=0.015)
    assert np.corrcoef(drawn[:-1], drawn[1:])[0, 1] == pytest.approx(channel.colour, abs=0.01)
    white = noise(CHANNELS["yaw_rate"], 200_000, np.random.default_rng(2))
    assert abs(np.corrcoef(white[:-1], white[1:])[0, 1]) < 0.01


def test_values_lie_on_the_grid_of_their_resolution(coast: tuple[np.ndarray, Drive]) -> None:
    logs = _recorded(coast)
    for log in logs.values():
        for name, values in log.channels.items():
            step = CHANNELS[name].resolution
            assert np.abs(values / step - np.round(values / step)).max() < 1e-6
    assert quantised(np.array([0.13]), 0.08) == pytest.approx(0.16)


def test_stamps_jitter_and_frames_are_lost(coast: tuple[np.ndarray, Drive]) -> None:
    loggers = Loggers(0.0, _PHASES)
    random = np.random.default_rng(3)
    logs = [record(coast[0], coast[1], _IDEAL, loggers, random) for _ in range(20)]
    stamps = [log.time for run in logs for log in run.values()]
    expected = int((len(coast[0]) - 1) / 1000.0 / CYCLE_S)
    lost = 1.0 - sum(len(time) for time in stamps) / (len(stamps) * expected)
    assert lost == pytest.approx(1e-3, abs=3.3 * np.sqrt(1e-3 / (len(stamps) * expected)))
    steps = np.concatenate([np.diff(time) for time in stamps])
    usual = steps[steps < 1.5 * CYCLE_S]
    assert np.std(usual) == pytest.approx(np.sqrt(2.0) * 3e-4, rel=0.05)
    assert usual.min() > 0.0


def test_the_second_loggers_channel_is_late(stop: tuple[np.ndarray, Drive]) -> None:
    log = _recorded(stop, offset=0.2)["REFERENCE"]
    truth = np.interp(log.time - 0.2, np.arange(len(stop[0])) / 1000.0, stop[0][:, 0])
    late = log.time > 0.25
    assert np.std((log.channels["speed"] - truth)[late]) < 0.05
    assert (
        np.std((log.channels["speed"] - np.interp(log.time, np.arange(len(stop[0])) / 1000.0, stop[0][:, 0]))[late])
        > 0.5
    )


@pytest.mark.parametrize("kind", FAULTS, ids=lambda kind: kind.name)
def test_every_fault_changes_its_channels_and_no_other(kind: object, stop: tuple[np.ndarray, Drive]) -> None:
    fault = kind.draw(np.random.default_rng(7))  # type: ignore[attr-defined]
    healthy, faulty = _recorded(stop), _recorded(stop, fault=fault)
    changed = set()
    for message, log in faulty.items():
        for name, values in log.channels.items():
            if not np.array_equal(log.time, healthy[message].time) or not np.allclose(
                values, healthy[message].channels[name], atol=8.0 * CHANNELS[name].noise + CHANNELS[name].resolution
            ):
                changed.add(name)
    assert changed <= set(fault.channels) or fault.kind in ("frame_drop_hold", "command_not_measurement")
    if fault.kind not in ("low_pass_channel", "frame_drop_hold", "can_latency", "channel_sign", "channel_unit"):
        assert changed  # a straight stop excites these for certain


def test_cars_scatter_as_stated() -> None:
    """300 cars: each number's deviation in units of its scatter is normal, none of 13800 beyond three (37 would be)."""
    random = np.random.default_rng(11)
    draws = [draw_car(random)[1] for _ in range(300)]
    for name in draws[0]:
        values = np.array([draw[name] for draw in draws])
        assert abs(values.mean()) < 4.0 / np.sqrt(300), name
        assert np.std(values) == pytest.approx(1.0, abs=4.0 / np.sqrt(600)), name
        assert np.abs(values).max() <= MOST_SCATTERS


def test_a_drawn_car_differs_from_the_data_sheet_where_it_may_and_only_there() -> None:
    car, _ = draw_car(np.random.default_rng(1))
    for name, number in DATA_SHEET.items():
        same = np.array_equal(car[name], np.array(number.nominal, float))
        assert same == (number.scatter == 0.0 and name != "balance"), name
