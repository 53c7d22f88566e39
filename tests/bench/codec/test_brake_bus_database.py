"""The shipped database against the bench's catalogue and the bus it has to fit on."""

import pytest

from bench.codec.database import DbcMessage, load_database
from bench.codec.mapping_file import BUS_NAMES
from signals.catalogue import catalogue

# identifier: (name, cycle in ms), the plan of the bus in docs/bus.md
PLAN = {
    0x120: ("WHEEL_SPEED_FRONT", 5),
    0x121: ("WHEEL_SPEED_REAR", 5),
    0x122: ("WHEEL_EDGES_FL", 5),
    0x123: ("WHEEL_EDGES_FR", 5),
    0x124: ("WHEEL_EDGES_RL", 5),
    0x125: ("WHEEL_EDGES_RR", 5),
    0x130: ("INERTIAL", 5),
    0x131: ("INERTIAL_BODY", 5),
    0x140: ("BRAKE", 10),
    0x141: ("WHEEL_PRESSURE", 10),
    0x150: ("POWERTRAIN", 10),
    0x151: ("ENGINE", 10),
    0x160: ("VEHICLE_STATUS", 20),
    0x161: ("STEERING", 10),
    0x210: ("VALVE_PUMP", 5),
    0x220: ("ABS_STATUS", 20),
    0x71D: ("ECU_DIAGNOSTICS", 10),
}
MESSAGES = load_database().messages


def longest_frame_bits(message: DbcMessage) -> int:
    """Bits of a standard frame with the most stuff bits it can have, and the 3 bits between frames.

    34 + 8 n bits from start of frame to the end of the CRC can be stuffed, at most one in four after the first
    (ISO 11898-1, 10.5; Davis et al. 2007, eq. 1).
    """
    stuffable = 34 + 8 * message.length
    return 47 + 8 * message.length + (stuffable - 1) // 4


def test_messages_and_cycles_are_the_plan_of_the_bus() -> None:
    assert {m.identifier: (m.name, m.cycle_ms) for m in MESSAGES} == PLAN


def test_every_signal_of_the_bus_block_is_carried_once_in_its_unit() -> None:
    units = {signal.name: signal.unit for signal in catalogue()}
    carried = [signal for message in MESSAGES for signal in message.signals if signal.name in units]
    assert sorted(signal.name for signal in carried) == sorted(BUS_NAMES)
    assert {s.name: s.unit or "1" for s in carried} == {s.name: units[s.name] for s in carried}


def test_worst_case_load_is_below_60_percent_of_500_kbit_s() -> None:
    load = sum(longest_frame_bits(message) * 1000 / message.cycle_ms for message in MESSAGES) / load_database().bit_rate
    assert load_database().bit_rate == 500_000
    assert load == pytest.approx(0.581, abs=0.001)
    assert load < 0.60


def test_no_tick_sends_more_than_three_frames_and_they_fit_into_it() -> None:
    for tick in range(20):
        due = [m for m in MESSAGES if (tick - m.offset_ms) % m.cycle_ms == 0]
        assert len(due) <= 3
        assert sum(longest_frame_bits(message) for message in due) < 500


def test_safety_frames_are_protected_with_data_ids_of_their_own() -> None:
    protected = [message for message in MESSAGES if message.data_ids]
    assert {message.name for message in MESSAGES} - {message.name for message in protected} == {"ECU_DIAGNOSTICS"}
    assert len({message.data_ids for message in protected}) == len(protected)
    for message in protected:
        crc, counter = message.signal("crc"), message.signal("alive_counter")
        assert crc is not None
        assert (crc.start, crc.length) == (0, 8)
        assert counter is not None
        assert (counter.start, counter.length) == (8, 4)


@pytest.mark.parametrize(
    ("name", "resolution", "low", "high"),
    [
        ("wheel_speed_fl", 0.0025, -300.0, 300.0),
        ("wheel_edge_time_rr", 1e-6, 0.0, 1.048575),
        ("longitudinal_acceleration", 1e-3, -30.0, 30.0),
        ("yaw_rate", 1e-4, -3.0, 3.0),
        ("master_pressure", 500.0, -1e6, 300e5),
        ("brake_pressure_fl", 4000.0, -1e6, 300e5),
        ("drive_torque_f", 0.25, -8000.0, 8000.0),
        ("ecu_reference_speed", 0.002, 0.0, 130.0),
    ],
)
def test_resolution_and_range(name: str, resolution: float, low: float, high: float) -> None:
    signal = next(s for message in MESSAGES for s in message.signals if s.name == name)
    assert signal.scale == resolution
    assert signal.raw_low * signal.scale + signal.offset <= low
    assert signal.raw_high * signal.scale + signal.offset >= high


def test_start_values_are_physically_zero() -> None:
    for message in MESSAGES:
        for signal in message.signals:
            assert signal.raw_start * signal.scale + signal.offset == 0.0, signal.name


def test_parsed_records_are_kept_and_equal(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    parsed = load_database()
    assert list((tmp_path / "brake-control-bench" / "databases").glob("*.json"))
    monkeypatch.setattr("bench.codec.database._parse", lambda file: pytest.fail("parsed again"))
    assert load_database() == parsed
