"""A user's own ECU: a foreign database and a mapping file, and what is said when they do not fit."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from bench.codec.codec import AGE_NAMES, Codec
from bench.codec.database import shipped_database
from bench.codec.mapping_file import BUS_NAMES, MappingFile
from bench.links.frame import EXTENDED, new_frames
from signals.errors import BenchError, FileFaults, InputError
from signals.yaml_files import parse_yaml, validate

OWN_DBC = """VERSION ""
BU_: GATEWAY ABS_UNIT
BO_ 1200 WHL_SPD: 8 GATEWAY
 SG_ FL : 7|16@0+ (0.01,0) [0|655.35] "km/h" ABS_UNIT
 SG_ FR : 23|16@0+ (0.01,0) [0|655.35] "km/h" ABS_UNIT
 SG_ RL : 39|16@0+ (0.01,0) [0|655.35] "km/h" ABS_UNIT
 SG_ RR : 55|16@0+ (0.01,0) [0|655.35] "km/h" ABS_UNIT
BO_ 1201 PRESSURE: 4 GATEWAY
 SG_ MASTER : 0|12@1+ (0.1,-5) [-5|400] "bar" ABS_UNIT
 SG_ SPARE : 12|8@1+ (1,0) [0|255] "" ABS_UNIT
BO_ 1202 REST: 2 GATEWAY
 SG_ MODE : 0|8@1+ (1,0) [0|255] "" ABS_UNIT
BO_ 2550136833 VALVES: 4 ABS_UNIT
 SG_ CMD : 16|8@1+ (1,0) [0|255] "" GATEWAY
 SG_ I1 : 12|1@1+ (1,0) [0|1] "" GATEWAY
 SG_ I2 : 13|1@1+ (1,0) [0|1] "" GATEWAY
 SG_ I3 : 14|1@1+ (1,0) [0|1] "" GATEWAY
 SG_ I4 : 15|1@1+ (1,0) [0|1] "" GATEWAY
 SG_ O1 : 24|1@1+ (1,0) [0|1] "" GATEWAY
 SG_ O2 : 25|1@1+ (1,0) [0|1] "" GATEWAY
 SG_ O3 : 26|1@1+ (1,0) [0|1] "" GATEWAY
 SG_ O4 : 27|1@1+ (1,0) [0|1] "" GATEWAY
 SG_ PUMP_OFF : 28|1@1+ (1,0) [0|1] "" GATEWAY
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_DEF_ SG_ "GenSigStartValue" FLOAT 0 100000;
BA_DEF_DEF_ "GenMsgCycleTime" 0;
BA_DEF_DEF_ "GenSigStartValue" 0;
BA_ "GenMsgCycleTime" BO_ 1200 20;
BA_ "GenMsgCycleTime" BO_ 1202 100;
BA_ "GenSigStartValue" SG_ 1201 SPARE 165;
BA_ "GenSigStartValue" SG_ 1202 MODE 7;
"""

MAPPING = """format: 1
dbc: own.dbc
ecu: [ABS_UNIT]
signals:
  wheel_speed_fl: {signal: WHL_SPD.FL, scale: 0.9259259259259258}   # km/h -> rad/s, radius 0.3 m
  wheel_speed_fr: {signal: WHL_SPD.FR, scale: 0.9259259259259258}
  wheel_speed_rl: {signal: WHL_SPD.RL, scale: 0.9259259259259258}
  wheel_speed_rr: {signal: WHL_SPD.RR, scale: 0.9259259259259258}
  master_pressure: {signal: PRESSURE.MASTER, unit: bar}
  valve_inlet_fl: VALVES.I1
  valve_inlet_fr: VALVES.I2
  valve_inlet_rl: VALVES.I3
  valve_inlet_rr: VALVES.I4
  valve_outlet_fl: VALVES.O1
  valve_outlet_fr: VALVES.O2
  valve_outlet_rl: VALVES.O3
  valve_outlet_rr: VALVES.O4
  pump: {signal: VALVES.PUMP_OFF, scale: -1, offset: 1}
also_send: [REST]
messages:
  PRESSURE: {cycle: 10 ms, offset: 3 ms}
  VALVES: {cycle: 5 ms, data_ids: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16]}
"""


@pytest.fixture
def mapping(tmp_path: Path) -> Path:
    (tmp_path / "own.dbc").write_text(OWN_DBC)
    file = tmp_path / "own.yaml"
    file.write_text(MAPPING)
    return file


def position(name: str) -> int:
    return BUS_NAMES.index(name)


def test_mapping_of_a_whole_ecu_is_at_most_40_lines() -> None:
    assert len(MAPPING.splitlines()) <= 40


def test_bench_talks_the_ecus_own_language(mapping: Path) -> None:
    codec = Codec.load(mapping=mapping)
    values = np.zeros(len(BUS_NAMES))
    values[position("wheel_speed_fl")] = 100.0
    values[position("master_pressure")] = 87.3e5
    transmitter = codec.transmitter("bench", values)
    frames, sent = new_frames(8), {}
    for tick in range(20):
        for frame in frames[: transmitter.due(tick, frames)]:
            sent.setdefault(int(frame["identifier"]), []).append((tick, bytes(frame["data"][: frame["length"]])))
    assert [tick for tick, _ in sent[1201]] == [3, 13]
    assert [tick for tick, _ in sent[1200]] == [0]
    # 100 rad/s × 0.3 m × 3.6 = 108 km/h = raw 10800, Motorola; 87.3 bar = raw 923; start value of SPARE
    assert sent[1200][0][1] == (10800).to_bytes(2, "big") + bytes(6)
    assert sent[1201][0][1] == (923 | 165 << 12).to_bytes(4, "little")
    assert sent[1202] == [(0, b"\x07\x00")]


def test_commands_of_the_ecu_reach_our_names(mapping: Path) -> None:
    codec = Codec.load(mapping=mapping)
    values, decoded, ages = np.zeros(len(BUS_NAMES)), np.zeros(len(BUS_NAMES)), np.zeros(len(AGE_NAMES))
    for name in ("valve_inlet_fr", "valve_outlet_rr"):
        values[position(name)] = 1.0
    ecu, bench = codec.transmitter("ecu", values), codec.receiver("bench", decoded, ages)
    frames = new_frames(8)
    count = ecu.due(0, frames)
    assert count == 1
    assert frames["identifier"][0] == 2550136833 & 0x1FFFFFFF
    assert frames["flags"][0] & EXTENDED
    assert frames["data"][0, 3] == 0b1_1000  # outlet rr; the pump is off, which this ECU writes as 1
    assert bench.accept(frames, count, 0) == 1
    assert decoded[position("valve_inlet_fr")] == decoded[position("valve_outlet_rr")] == 1.0
    assert decoded[position("valve_inlet_fl")] == decoded[position("pump")] == 0.0
    assert codec.identifiers("ecu") == {(2550136833 & 0x1FFFFFFF, True)}


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (("VALVES.I1", "VALVE.I1"), ["own.yaml:10:", "signals.valve_inlet_fl", "no message VALVE", "mean VALVES?"]),
        (("VALVES.I1", "VALVES.I9"), ["own.yaml:10:", "signals.valve_inlet_fl", "no signal of VALVES called I9"]),
        (("ABS_UNIT]", "ABS]"), ["own.yaml:3:", "ecu", "no node ABS", "GATEWAY, ABS_UNIT"]),
        (("  valve_inlet_rl: VALVES.I3\n", ""), ["valve_inlet_rl", "to set the hydraulics"]),
        (("unit: bar", "unit: km/h"), ["own.yaml:9:", "signals.master_pressure.unit", "Pa"]),
        (("  PRESSURE: {cycle: 10 ms, offset: 3 ms}\n", ""), ["PRESSURE", "no cycle time", "cycle: 10 ms"]),
        (("valve_inlet_fl:", "valve_inlet_fx:"), ["own.yaml:10:", "valve_inlet_fx", "did you mean"]),
        (("scale: -1,", "scale: 0,"), ["own.yaml:18:", "scale", "any number but 0"]),
        (("format: 1", "fromat: 1"), ["own.yaml:1:", "format"]),
        (("also_send: [REST]", "also_send: [RESTS]"), ["own.yaml:19:", "no message RESTS", "mean REST?"]),
        (("dbc: own.dbc", "dbc: other.dbc"), ["other.dbc", "No such file"]),
        ((" 15, 16]", " 15]"), ["own.yaml:", "data_ids"]),
    ],
)
def test_faults_of_a_mapping_name_place_and_remedy(mapping: Path, change: tuple[str, str], expected: list[str]) -> None:
    assert change[0] in MAPPING
    mapping.write_text(MAPPING.replace(*change))
    with pytest.raises(InputError) as caught:
        Codec.load(mapping=mapping)
    text = str(caught.value)
    assert all(part in text for part in expected), text
    assert len(text.splitlines()) <= 6
    assert caught.value.exit_code == 2


def test_all_faults_are_reported_at_once(mapping: Path) -> None:
    mapping.write_text(MAPPING.replace("VALVES.I", "VALVE.I").replace("unit: bar", "unit: s"))
    with pytest.raises(FileFaults) as caught:
        Codec.load(mapping=mapping)
    assert sorted(fault.line for fault in caught.value.faults) == [9, 10, 11, 12, 13]
    assert "bench check" in str(caught.value)
    assert len(str(caught.value).splitlines()) <= 6


def test_database_without_a_needed_message_lists_what_is_missing(tmp_path: Path) -> None:
    paragraphs = shipped_database().read_text().split("\n\n")
    kept = [paragraph for paragraph in paragraphs if "BO_ 528 VALVE_PUMP:" not in paragraph]
    text = "\n".join(line for line in "\n\n".join(kept).split("\n") if "_ 528 " not in line)
    (tmp_path / "lame.dbc").write_text(text)
    with pytest.raises(InputError) as caught:
        Codec.load(tmp_path / "lame.dbc")
    assert "valve_inlet_fl" in str(caught.value)
    assert "pump" in str(caught.value)
    assert "VALVE_PUMP (0x210)" in str(caught.value)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("rubbish\n", "not a usable CAN database"),
        ("", "not a usable CAN database"),
        (None, "No such file"),
        ('VERSION ""\nBU_: BENCH\n', "no node ECU"),
    ],
)
def test_unusable_database(tmp_path: Path, content: str | None, expected: str) -> None:
    file = tmp_path / "bad.dbc"
    if content is not None:
        file.write_text(content)
    with pytest.raises(InputError, match=expected) as caught:
        Codec.load(file)
    assert "bad.dbc" in str(caught.value)


def test_multiplexed_and_float_signals_are_refused_clearly(mapping: Path) -> None:
    own = mapping.parent / "own.dbc"
    own.write_text(OWN_DBC.replace("SG_ CMD : ", "SG_ CMD M : ").replace("SG_ I1 : ", "SG_ I1 m0 : "))
    with pytest.raises(InputError, match=r"VALVES\.I1 is multiplexed"):
        Codec.load(mapping=mapping)


def test_requirements_of_a_consumer(mapping: Path) -> None:
    codec = Codec.load(mapping=mapping)
    codec.require("bench", ["wheel_speed_fl"], "by the filter")
    with pytest.raises(BenchError, match=r"yaw_rate \(needed by the filter\)"):
        codec.require("bench", ["wheel_speed_fl", "yaw_rate"], "by the filter")


def test_checking_a_known_database_imports_nothing_heavy() -> None:
    """What ``bench check`` does with a mapping; the database was read before, so not even cantools is needed."""
    Codec.load()
    program = (
        "import sys; from bench.codec.resolve import load_layout; load_layout(); "
        "print(sorted({'numba', 'scipy', 'mujoco', 'can', 'cantools', 'asammdf', 'matplotlib'} & set(sys.modules)))"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert result.stdout == "[]\n"


def test_the_manuals_example_is_a_mapping_file() -> None:
    manual = (Path(__file__).parents[3] / "docs" / "bus.md").read_text()
    example = manual.split("```yaml\n")[1].split("```")[0]
    mapping = validate(parse_yaml(example, "docs/bus.md"), MappingFile)
    assert mapping.signals["pump"].scale == -1.0
    assert mapping.messages["PRESSURE"].cycle == 0.01
