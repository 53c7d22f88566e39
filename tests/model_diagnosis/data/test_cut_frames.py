"""CAN frames whose zero bytes at the end an export has cut off: completed and named, or passed over where unsure."""

import struct

import kinematic_car as car
import numpy as np
import pytest

from model_diagnosis.data.reading import read_manoeuvres
from signals.measured.channel_map import ChannelMap

WHEELS = ("fl", "fr", "rl", "rr")
DBC = """VERSION ""
NS_ :
BS_:
BU_: X
BO_ 170 WHEELS: 8 X
""" + "".join(f' SG_ {wheel.upper()} : {7 + 16 * k}|16@0+ (0.01,0) [0|0] "rad/s" X\n' for k, wheel in enumerate(WHEELS))


def _frames(seed, lowest_bits):
    """(stamp, eight bytes) of a coasting car; the last wheel's raw value has ``lowest_bits`` 0, so some bytes are 0."""
    random = np.random.default_rng(seed)
    driven = car.drive("stop", random)
    signals = car.sensed(driven, random)
    frames = []
    for stamp in np.arange(0.0, driven.time[-1], 0.01):
        raw = [round(float(np.interp(stamp, driven.time, signals[f"wheel_speed_{w}"])) / 0.01) for w in WHEELS]
        raw[3] &= ~((1 << lowest_bits) - 1)
        frames.append((stamp, struct.pack(">4H", *raw)))
    return frames


def _read(folder, frames, vehicle):
    (folder / "car.dbc").write_text(DBC)
    lines = [f"({stamp:.6f}) can0 0AA#{data.hex().upper()}\n" for stamp, data in frames]
    (folder / "can.log").write_text("".join(lines))
    channels = {f"wheel_speed_{w}": {"source": f"WHEELS.{w.upper()}", "unit": "rad/s"} for w in WHEELS}
    channel_map = ChannelMap(dbc=str(folder / "car.dbc"), channels=channels)
    return read_manoeuvres([folder / "can.log"], channel_map, vehicle)


@pytest.mark.parametrize("lowest_bits", [2, 6])
def test_cut_zero_bytes_are_put_back_and_told(tmp_path, vehicle, lowest_bits):
    frames = _frames(3, lowest_bits)
    cut = [(stamp, data.rstrip(b"\0")) for stamp, data in frames]
    short = sum(len(data) < 8 for _, data in cut)
    assert short > 1
    whole = _read(tmp_path, frames, vehicle)
    read = _read(tmp_path, cut, vehicle)
    assert [(f.kind, f.channel, f.value) for f in read[0].reading_faults] == [("cut_frames", "WHEELS", short)]
    assert not whole[0].reading_faults
    for wheel in WHEELS:
        name = f"wheel_speed_{wheel}"
        np.testing.assert_array_equal(read[0].channels[name], whole[0].channels[name])
        np.testing.assert_array_equal(read[0].weight(name), whole[0].weight(name))


def test_short_frames_beside_whole_ones_that_end_in_zero_are_passed_over(tmp_path, vehicle):
    """A sender that sometimes sends less: what its bytes would be nobody knows."""
    frames = _frames(4, 6)
    mixed = [(stamp, data[:6] if k % 50 == 49 else data) for k, (stamp, data) in enumerate(frames)]
    read = _read(tmp_path, mixed, vehicle)
    assert [fault.kind for fault in read[0].reading_faults] == ["frame_drop_hold"]
    assert read[0].reading_faults[0].value == pytest.approx(0.02, abs=0.003)
