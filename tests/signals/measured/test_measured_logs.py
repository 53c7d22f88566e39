"""Foreign logs of every kind: the same channels, units, signs and delays come out of each."""

import gzip
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import can
import cantools
import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
import pytest
from asammdf import MDF, Signal

from signals.errors import FileFaults, InputError
from signals.measured.channel_map import ChannelMap, channel_units, load_channel_map
from signals.measured.measured_log import detect_format, read_log

TIME = np.arange(200) * 0.01
SPEED_KMH = 90.0 - 20.0 * TIME
YAW_DEG_S = 3.0 * np.sin(TIME)
PRESSURE_BAR = 40.0 * TIME
WHEEL_KMH = SPEED_KMH * 0.9
GEAR = np.where(TIME < 1.0, 3, 2)
RADIUS = 0.3

DBC = """VERSION ""
NS_ :
BS_:
BU_: A
BO_ 256 MOTION: 8 A
 SG_ SPEED : 0|16@1+ (0.01,0) [0|600] "km/h" A
 SG_ YAW : 16|16@1- (0.01,0) [-300|300] "deg/s" A
 SG_ GEAR : 32|4@1+ (1,0) [0|15] "" A
BO_ 512 BRAKE: 4 A
 SG_ PRESSURE : 0|16@1+ (0.01,0) [0|600] "bar" A
 SG_ WHEEL : 16|16@1+ (0.01,0) [0|600] "km/h" A
"""

COLUMNS = {"t": TIME, "v": SPEED_KMH, "r": YAW_DEG_S, "p": PRESSURE_BAR, "w": WHEEL_KMH, "g": GEAR}
SOURCES = {"speed": "v", "yaw_rate": "r", "master_pressure": "p", "wheel_speed_fl": "w", "gear": "g"}
SIGNALS = {
    "speed": "MOTION.SPEED", "yaw_rate": "MOTION.YAW", "master_pressure": "BRAKE.PRESSURE",
    "wheel_speed_fl": "BRAKE.WHEEL", "gear": "MOTION.GEAR",
}  # fmt: skip
UNITS = {"speed": "km/h", "yaw_rate": "deg/s", "master_pressure": "bar", "wheel_speed_fl": "km/h"}


def channel_map(sources: dict[str, str] = SOURCES, **fields) -> ChannelMap:
    channels = {name: {"source": source} for name, source in sources.items()}
    for name, unit in UNITS.items():
        channels[name]["unit"] = unit
    return ChannelMap.model_validate({"channels": channels} | fields)


def write_csv(path: Path, separator: str = ",", before: str = "", units: str = "", decimal: str = ".") -> None:
    lines = [before + separator.join(COLUMNS), *([units] if units else [])]
    for row in zip(*COLUMNS.values(), strict=True):
        lines.append(separator.join(f"{value:.6f}".replace(".", decimal) for value in row))
    data = "\n".join(lines).encode()
    path.write_bytes(gzip.compress(data) if path.suffix == ".gz" else data)


def write_mf4(path: Path) -> None:
    with MDF() as mdf:
        mdf.append([Signal(COLUMNS[name], TIME + 5.0, name=name) for name in ("v", "r", "g")])
        mdf.append([Signal(COLUMNS[name], TIME + 5.0, name=name) for name in ("p", "w")])
        mdf.save(path)


def write_can(path: Path) -> None:
    database = cantools.database.load_string(DBC)
    with can.Logger(path) as log:
        for t, v, r, p, w, g in zip(*COLUMNS.values(), strict=True):
            for name, values in (
                ("MOTION", {"SPEED": v, "YAW": r, "GEAR": int(g)}),
                ("BRAKE", {"PRESSURE": p, "WHEEL": w}),
            ):
                message = database.get_message_by_name(name)
                data = message.encode(values)
                log(can.Message(timestamp=1.79e9 + t, arbitration_id=message.frame_id, data=data, is_extended_id=False))
            log(can.Message(timestamp=1.79e9 + t, arbitration_id=0x256, data=b"\x01", is_extended_id=False))


def write_packed(path: Path, write: Callable[[Path], None]) -> None:
    plain = path.with_suffix("")
    write(plain)
    path.write_bytes(gzip.compress(plain.read_bytes()))


WRITERS = {
    "plain.csv": write_csv,
    "packed.csv.gz": write_csv,
    "semicolon.csv": lambda path: write_csv(path, ";", decimal=","),
    "tab.txt": lambda path: write_csv(path, "\t"),
    "remarks.csv": lambda path: write_csv(
        path, ",", before="# made, by, hand\n# ", units='# "s","km/h"\n"s","x","x","x","x","1"'
    ),
    "table.parquet": lambda path: parquet.write_table(pa.table(COLUMNS), path),
    "log.mf4": write_mf4,
    "log.blf": write_can,
    "log.asc": write_can,
    "log.log": write_can,
    "packed.asc.gz": lambda path: write_packed(path, write_can),
    "bus.mf4": write_can,
}


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_gives_the_same_signals(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    WRITERS[name](path)
    is_can = WRITERS[name] is write_can or name == "packed.asc.gz"
    (tmp_path / "car.dbc").write_text(DBC)
    chosen = channel_map(SIGNALS, dbc=str(tmp_path / "car.dbc")) if is_can else channel_map()
    log = read_log(path, chosen, wheel_radius_m=RADIUS)
    time, columns = log.resample()
    assert time == pytest.approx(TIME, abs=2e-6)
    # the CAN signals are quantised to 0.01 of their unit
    step = 0.006 if is_can else 1e-5
    assert columns["speed"] * 3.6 == pytest.approx(SPEED_KMH, abs=step)
    assert np.degrees(columns["yaw_rate"]) == pytest.approx(YAW_DEG_S, abs=step)
    assert columns["master_pressure"] / 1e5 == pytest.approx(PRESSURE_BAR, abs=step)
    assert columns["wheel_speed_fl"] * RADIUS * 3.6 == pytest.approx(WHEEL_KMH, abs=step)
    assert np.array_equal(columns["gear"], GEAR)
    assert log.units() == {name: channel_units()[name] for name in SOURCES}


def test_sign_scale_and_delay(tmp_path: Path) -> None:
    write_csv(tmp_path / "a.csv")
    chosen = ChannelMap.model_validate(
        {"channels": {"yaw_rate": {"source": "r", "unit": "deg/s", "sign": -1, "scale": 2, "delay_s": "50 ms"}}}
    )
    channel = read_log(tmp_path / "a.csv", chosen).channels["yaw_rate"]
    assert channel.time == pytest.approx(TIME - 0.05)
    assert np.degrees(channel.values) == pytest.approx(-2 * YAW_DEG_S, abs=1e-5)


def test_clock_in_another_unit_and_column(tmp_path: Path) -> None:
    table = {"v": SPEED_KMH, "stamp_ms": 1_790_000_000_000 + TIME * 1e3}
    parquet.write_table(pa.table(table), tmp_path / "a.parquet")
    chosen = ChannelMap.model_validate(
        {"clock": {"column": "stamp_ms", "unit": "ms"}, "channels": {"speed": {"source": "v", "unit": "km/h"}}}
    )
    log = read_log(tmp_path / "a.parquet", chosen)
    assert log.start_time_s == pytest.approx(1_790_000_000)
    assert log.channels["speed"].time == pytest.approx(TIME, abs=1e-6)


def test_channels_of_different_rates_meet_on_the_finest(tmp_path: Path) -> None:
    fast = np.arange(0.0, 2.0, 0.002)
    with MDF() as mdf:
        mdf.append([Signal(10 + fast, fast, name="v")])
        mdf.append([Signal(np.array([1.0, 5.0, 2.0]), np.array([0.5, 0.9, 1.7]), name="p")])
        mdf.append([Signal(np.array([1, 2]), np.array([0.7, 1.1]), name="g")])
        mdf.save(tmp_path / "a.mf4")
    chosen = ChannelMap.model_validate(
        {"channels": {"speed": {"source": "v"}, "master_pressure": {"source": "p"}, "gear": {"source": "g"}}}
    )
    time, columns = read_log(tmp_path / "a.mf4", chosen).resample()
    assert np.diff(time) == pytest.approx(0.002)
    # continuous channels limit the time, a switch or gear does not
    assert (time[0], time[-1]) == (pytest.approx(0.5), pytest.approx(1.7))
    assert columns["speed"] == pytest.approx(10 + time)
    assert np.interp(1.3, time, columns["master_pressure"]) == pytest.approx(3.5)
    assert set(columns["gear"]) == {1.0, 2.0}
    assert columns["gear"][time < 1.0999].max() == 1.0


def test_one_mf4_name_in_two_groups_needs_its_group(tmp_path: Path) -> None:
    with MDF() as mdf:
        mdf.append([Signal(np.ones(3), np.arange(3.0), name="v")])
        mdf.append([Signal(np.full(3, 2.0), np.arange(3.0), name="v")])
        mdf.save(tmp_path / "a.mf4")
    with pytest.raises(InputError, match="several channels 'v'"):
        read_log(tmp_path / "a.mf4", ChannelMap.model_validate({"channels": {"speed": {"source": "v"}}}))
    log = read_log(tmp_path / "a.mf4", ChannelMap.model_validate({"channels": {"speed": {"source": "v#1"}}}))
    assert log.channels["speed"].values.tolist() == [2.0] * 3


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("t,v\n0,1\n1,2\n0.5,3\n", "runs backwards after sample 2"),
        ("t,speed\n0,1\n1,2\n", "did you mean"),
        ("t,v\n0,\n1,nan\n", "holds no numbers"),
        ("", "is empty"),
        ("only words\nno numbers\n", "no header"),
        ("t,v\n0,1\n1,two\n", "not a table of numbers"),
        ("t,v\n0,1\n,2\n", "gaps"),
    ],
)
def test_broken_tables_end_in_one_message(tmp_path: Path, content: str, message: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(content)
    source = "spee" if "speed" in content else "v"
    with pytest.raises(InputError) as caught:
        read_log(path, ChannelMap.model_validate({"channels": {"speed": {"source": source}}}))
    assert message in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.mf4", b"MDF     garbage", "not a readable MF4"),
        ("a.blf", b"LOGG", "not a readable CAN log"),
        ("a.parquet", b"PAR1xxxx", "not a readable Parquet"),
        ("b.blf", b"no such thing", "not a readable CAN log"),
        ("a.xyz", b"12345678", "unknown kind of log"),
        ("a.blf", b"", "is empty"),
    ],
)
def test_broken_files_end_in_one_message(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    (tmp_path / name).write_bytes(content)
    (tmp_path / "car.dbc").write_text(DBC)
    dbc = str(tmp_path / "car.dbc") if name.endswith("blf") else None
    with pytest.raises(InputError, match=message):
        read_log(tmp_path / name, channel_map(SIGNALS, dbc=dbc), wheel_radius_m=RADIUS)


def test_can_logs_say_what_is_missing(tmp_path: Path) -> None:
    write_can(tmp_path / "a.blf")
    (tmp_path / "car.dbc").write_text(DBC.replace("512 BRAKE", "513 BRAKE"))

    def attempt(**fields):
        return read_log(
            tmp_path / "a.blf", channel_map(SIGNALS | fields.pop("sources", {}), **fields), wheel_radius_m=1
        )

    with pytest.raises(InputError, match="needs a database"):
        attempt()
    with pytest.raises(InputError, match="no such file"):
        attempt(dbc=str(tmp_path / "missing.dbc"))
    with pytest.raises(InputError, match=r"did you mean MOTION\.SPEED"):
        attempt(dbc=str(tmp_path / "car.dbc"), sources={"speed": "MOTION.SPED"})
    with pytest.raises(InputError, match="no frame of the log has it"):
        attempt(dbc=str(tmp_path / "car.dbc"))


def test_a_wheel_speed_along_the_road_needs_the_radius(tmp_path: Path) -> None:
    write_csv(tmp_path / "a.csv")
    with pytest.raises(InputError, match="wheel radius"):
        read_log(tmp_path / "a.csv", channel_map())


def test_channels_without_common_time_are_refused(tmp_path: Path) -> None:
    with MDF() as mdf:
        mdf.append([Signal(np.ones(3), np.arange(3.0), name="v")])
        mdf.append([Signal(np.ones(3), 10 + np.arange(3.0), name="p")])
        mdf.save(tmp_path / "a.mf4")
    chosen = {"channels": {"speed": {"source": "v"}, "master_pressure": {"source": "p"}}}
    with pytest.raises(InputError, match="no time is covered by all channels: 'v' ends at 2"):
        read_log(tmp_path / "a.mf4", ChannelMap.model_validate(chosen)).resample()


def test_faults_of_a_channel_map_have_places(tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text(
        "clock: {unit: furlong}\n"
        "channels:\n"
        "  sped: {source: v}\n"
        "  yaw_rate: {source: r, unit: bar}\n"
        "  speed: {sourc: v}\n"
    )
    with pytest.raises(FileFaults) as caught:
        load_channel_map(path)
    text = "\n".join(str(fault) for fault in caught.value.faults)
    assert f"{path}:5:" in text
    path.write_text(path.read_text().replace("sourc:", "source:"))
    with pytest.raises(FileFaults) as caught:
        load_channel_map(path)
    text = "\n".join(str(fault) for fault in caught.value.faults)
    assert f"{path}:1:" in text
    assert f"{path}:3:" in text
    assert "did you mean speed?" in text
    assert f"{path}:4:" in text


def test_the_dbc_is_looked_for_beside_the_map(tmp_path: Path) -> None:
    (tmp_path / "map.yaml").write_text("dbc: car.dbc\nchannels:\n  speed: {source: MOTION.SPEED, unit: km/h}\n")
    assert load_channel_map(tmp_path / "map.yaml").dbc == str(tmp_path / "car.dbc")


def test_format_by_content_beats_the_name(tmp_path: Path) -> None:
    write_mf4(tmp_path / "log.mf4")
    (tmp_path / "log.mf4").rename(tmp_path / "log.csv")
    assert detect_format(tmp_path / "log.csv") == "mf4"


def test_a_format_that_is_said_beats_the_name(tmp_path: Path) -> None:
    write_can(tmp_path / "log.asc")
    (tmp_path / "log.asc").rename(tmp_path / "log.dat")
    (tmp_path / "car.dbc").write_text(DBC)
    chosen = channel_map(SIGNALS, dbc=str(tmp_path / "car.dbc"), file_format="asc")
    assert len(read_log(tmp_path / "log.dat", chosen, wheel_radius_m=RADIUS).channels["speed"].values) == len(TIME)


def test_comments_of_an_asc_file_are_of_any_code_page(tmp_path: Path) -> None:
    write_can(tmp_path / "log.asc")
    (tmp_path / "car.dbc").write_text(DBC)
    header, rest = (tmp_path / "log.asc").read_bytes().split(b"Begin", 1)
    (tmp_path / "log.asc").write_bytes(header + "// Prüfstand\r\nBegin".encode("cp1252") + rest)
    log = read_log(tmp_path / "log.asc", channel_map(SIGNALS, dbc=str(tmp_path / "car.dbc")), wheel_radius_m=RADIUS)
    assert len(log.channels["speed"].values) == len(TIME)


def test_bus_logging_of_mf4_is_read_beside_the_bench_s_own_links(tmp_path: Path) -> None:
    """They import python-can without asammdf, which its reader of MF4 needs."""
    write_can(tmp_path / "log.mf4")
    (tmp_path / "car.dbc").write_text(DBC)
    (tmp_path / "map.yaml").write_text("dbc: car.dbc\nchannels:\n  speed: {source: MOTION.SPEED, unit: km/h}\n")
    code = (
        "import sys; import bench.links.python_can_library\n"
        "from signals.measured.channel_map import load_channel_map\n"
        "from signals.measured.measured_log import read_log\n"
        "print(len(read_log(sys.argv[1], load_channel_map(sys.argv[2])).channels['speed'].values))"
    )
    arguments = [sys.executable, "-c", code, tmp_path / "log.mf4", tmp_path / "map.yaml"]
    result = subprocess.run(arguments, capture_output=True, text=True, check=True)
    assert int(result.stdout) == len(TIME)


def shared_data() -> Path:
    import os

    return Path(os.environ.get("BENCH_SHARED_DATA", Path(__file__).parents[3].parent / "shared" / "data"))


@pytest.mark.parametrize(
    ("name", "channels", "clock", "rows"),
    [
        # origin of the numbers: the README beside each file
        (
            "carmaker-bosch/experiment2_40kmh.CSV.gz",
            {"speed": {"source": "Car.vx"}, "yaw_rate": {"source": "Car.YawRate"}},
            {},
            1000,
        ),
        (
            "iac-av21/LVMS_23_01_04_B.csv.gz",
            {
                "speed": {"source": "vx(m/s)"},
                "master_pressure": {"source": "brake_ped_cmd(kPa)", "unit": "kPa"},
                "wheel_speed_fl": {"source": "wheel_fl(kmph)", "unit": "km/h"},
            },
            {"column": "time(s)"},
            16000,
        ),
        ("revs-250lm-2014/250lm_20140222_01_t150-425.csv.gz", {"speed": {"source": "vx"}}, {"column": "t"}, 20000),
    ],
)
def test_public_logs_are_read(name: str, channels: dict, clock: dict, rows: int) -> None:
    path = shared_data() / name
    if not path.is_file():
        pytest.skip(f"shared data not here: {path}")
    log = read_log(path, ChannelMap.model_validate({"channels": channels, "clock": clock}), wheel_radius_m=0.3)
    time, columns = log.resample()
    assert len(time) > rows
    assert 5 < columns["speed"].max() < 90
