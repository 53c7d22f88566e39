"""Exit codes and texts of the errors that a user sees (design.md section 9, anchors section 6)."""

import pytest

from signals.errors import BenchError, Fault, FileFaults, InputError, LinkError, RunError, nearest_name, unknown_name


@pytest.mark.parametrize(("kind", "code"), [(BenchError, 4), (InputError, 2), (RunError, 4), (LinkError, 4)])
def test_exit_codes(kind: type[BenchError], code: int) -> None:
    assert kind("x").exit_code == code


def test_text_names_found_nearest_allowed_and_mend() -> None:
    error = LinkError(
        "vcan0: no such interface (AF_CAN is there)",
        mend="make it: sudo ip link add vcan0 type vcan && sudo ip link set vcan0 up\nor run without: --link udp",
    )
    assert str(error).splitlines() == [
        "vcan0: no such interface (AF_CAN is there)",
        "  make it: sudo ip link add vcan0 type vcan && sudo ip link set vcan0 up",
        "  or run without: --link udp",
    ]
    assert str(InputError("a", found="400", allowed="0 to 5", nearest="b")).splitlines() == [
        "a",
        "  found 400; did you mean b?; allowed: 0 to 5",
    ]


def test_nearest_name() -> None:
    assert nearest_name("brake_presure_fl", ["brake_pressure_fl", "speed"]) == "brake_pressure_fl"
    assert nearest_name("zzz", ["brake_pressure_fl", "speed"]) == ""
    assert "did you mean speed" in str(unknown_name("signal", "sped", ["speed"]))


def test_at_most_six_lines_are_printed() -> None:
    faults = [Fault("a.yaml", n, 3, f"field{n}", "unknown field", found="1", allowed="x") for n in range(1, 8)]
    text = str(FileFaults(faults, "a.yaml"))
    assert len(text.splitlines()) <= 6
    assert text.splitlines()[-1] == "  5 more errors; all: bench check a.yaml"
    assert text.splitlines()[0] == "a.yaml:1:3  field1: unknown field"


def test_a_few_faults_are_printed_whole() -> None:
    faults = [Fault("a.yaml", 1, 1, "b", "required field is missing")] * 6
    assert str(FileFaults(faults, "a.yaml")).count("required") == 6
