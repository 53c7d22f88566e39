"""The page of a made-up diagnosis: what it says, what it draws, and what it leaves out."""

import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import made_up_findings
import numpy as np
import pytest

from bench.diagnosis_report.bars import evidence_bars, gain_bars, interval_mark
from bench.diagnosis_report.house import FLOORS, LEAST_RATIO, brightness, house_of_equations, outside
from bench.diagnosis_report.page import page_of, rating_table
from bench.diagnosis_report.residual_maps import binned_residual, residual_maps
from bench.diagnosis_report.signal_charts import ranked_signals
from bench.diagnosis_report.timeline import GAP_S, Timeline
from bench.diagnosis_report.words import headline, percent, signal_words
from model_diagnosis.findings import Findings
from model_diagnosis.manoeuvre import SAMPLE_TIME_S
from model_diagnosis.result import Diagnosis, ParameterEstimate, ViolatedEquation


def texts(page: str) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", page))


def test_the_answer_stands_at_the_top(diagnosis_page: Path) -> None:
    top = texts(diagnosis_page.read_text("utf-8").partition("<main>")[0])
    assert "The car differs from its vehicle file: brake pad friction −20.5 % or pressure sensor scale." in top
    for figure in ("83 %", "0.318", "12 % [9, 16]", "4, 1 held out"):
        assert figure in top


@pytest.mark.parametrize("verdict", ["nothing_found", "data_fault", "insufficient_data"])
def test_an_extended_file_without_causes_is_told(findings: Findings, verdict: str) -> None:
    plain = findings.diagnosis.model_copy(update={"verdict": verdict, "causes": [], "extension_file": None})
    extended = plain.model_copy(update={"extension_file": "extended_vehicle.yaml"})
    own = " The extended vehicle file has this car's numbers within their scatter."
    assert headline(extended) == headline(plain) + own


def test_everything_found_is_on_the_page(diagnosis_page: Path) -> None:
    page = texts(diagnosis_page.read_text("utf-8"))
    for words in (
        "0.314 … 0.322",
        "brakes.*.pad_friction",
        "cannot tell it from: pressure sensor scale",
        "hold at standstill",
        "channel sign",
        "no samples from 1.50 s to 1.80 s",
        "bench run stops/dry --vehicle extended_vehicle.yaml",
        "stopping distance from 100 km/h",
        "tyre temperature fade, steering ratio",
        "20 % [15, 27]",
    ):
        assert words in page


def test_runs_that_restart_each_second_are_drawn_and_rated_beside_the_free_ones(
    diagnosis_page: Path, findings: Findings
) -> None:
    page = texts(diagnosis_page.read_text("utf-8"))
    assert "Free runs from the first sample" in page
    assert "Runs that restart each second at the measured speeds" in page
    assert "restarted each second" in diagnosis_page.read_text("utf-8")
    free, restarted = rating_table(findings), rating_table(findings, restarted=True)
    assert free is not None
    assert restarted is not None
    # a quarter of the error before rates no worse anywhere, and better somewhere
    pairs = [
        (float(a["before"]), float(b["before"]))
        for (_, first), (_, second) in zip(free["rows"], restarted["rows"], strict=True)
        for a, b in zip(first, second, strict=True)
        if a is not None and b is not None
    ]
    assert all(b >= a for a, b in pairs)
    assert any(b > a for a, b in pairs)
    without = [replace(part, restarted_before=None, restarted_after=None) for part in findings.manoeuvres]
    assert rating_table(replace(findings, manoeuvres=without), restarted=True) is None


def test_the_page_stands_alone(diagnosis_page: Path) -> None:
    page = diagnosis_page.read_text("utf-8")
    assert "default-src 'none'" in page
    assert not re.search(r"""(src|href)=["']https?:""", page)
    assert diagnosis_page.stat().st_size < 3e6


def test_names_from_files_do_not_become_markup(findings: Findings) -> None:
    part = findings.manoeuvres[0]
    named = replace(part, manoeuvre=replace(part.manoeuvre, name="<script>alert(1)</script>"))
    page = page_of(replace(findings, manoeuvres=[named, *findings.manoeuvres[1:]]))
    assert "<script>alert" not in page


def test_a_page_without_causes_has_no_second_curve(findings: Findings) -> None:
    clean = Diagnosis(verdict="nothing_found", probability_of_nothing=0.97)
    untouched = [
        replace(part, after=part.before, free_after=part.free_before, restarted_after=part.restarted_before)
        for part in findings.manoeuvres
    ]
    page = page_of(replace(findings, diagnosis=clean, manoeuvres=untouched, evidence={}))
    assert "The vehicle file explains the data" in page
    assert "with what was found" not in texts(page.partition('<script id="data"')[0])
    for absent in ("house-title", "gain-title", "causes-title", "faults-title", "next-title"):
        assert absent not in page


def test_a_page_without_manoeuvres_is_made(findings: Findings) -> None:
    empty = Diagnosis(verdict="insufficient_data", remarks=["no signal could be compared"])
    page = page_of(replace(findings, diagnosis=empty, manoeuvres=[], evidence={}))
    assert "This data cannot answer the question." in page
    assert "No signal could be compared." in page


@pytest.mark.parametrize(
    ("verdict", "words"),
    [
        ("indistinguishable", "One of brake pad friction or pressure sensor scale; this data cannot tell which."),
        ("data_fault", "channel sign in lateral_acceleration and gap in speed"),
        ("wrong_vehicle", "this is probably not the car of the vehicle file"),
        ("insufficient_data", "cannot answer"),
    ],
)
def test_headlines(verdict: str, words: str) -> None:
    assert words in headline(made_up_findings.diagnosis().model_copy(update={"verdict": verdict}))


def test_words() -> None:
    assert signal_words("brake_pressure_fl") == "brake pressure front left"
    assert [percent(value) for value in (1.0, 0.9949, 0.42, 0.001)] == ["> 99 %", "99 %", "42 %", "< 1 %"]


def test_the_house_lights_the_most_violated_balance(findings: Findings) -> None:
    drawing = house_of_equations(findings.diagnosis.guilty_equations)
    rooms = re.findall(r'<g class="(\w+)">.*?<text class="name"[^>]*>([^<]+)<', drawing)
    states = {name: state for state, name in rooms}
    assert len(rooms) == 1 + sum(len(floor) for floor in FLOORS)
    assert states["wheel front right"] == "guilty"
    assert states["wheel front left"] == "lit"
    assert states["sensor chain"] == "lit"
    assert states["load transfer"] == "kept"
    assert states["brake rear right"] == "unseen"
    assert list(states.values()).count("guilty") == 1


def test_innovations_light_the_house_and_both_numbers_stand_in_it(findings: Findings) -> None:
    """The balance at the front right wheel has the larger equation error, the innovations point to the left one."""
    innovations = {
        "wheel torque fl": ViolatedEquation(likelihood_ratio=91.5, error=21.0, unit="N m"),
        "wheel torque fr": ViolatedEquation(likelihood_ratio=3.0, error=2.0, unit="N m"),
        "sensor yaw_rate": ViolatedEquation(likelihood_ratio=45.0, error=0.004, unit="rad/s"),
    }
    drawing = house_of_equations(findings.diagnosis.guilty_equations, innovations)
    rooms = re.findall(r'<g class="(\w+)">.*?class="name"[^>]*>([^<]+)<.*?class="ratio"[^>]*>([^<]+)<', drawing)
    shown = {name: (state, text) for state, name, text in rooms}
    assert shown["wheel front left"] == ("guilty", "LR 91.5 · by balance 310")
    assert shown["wheel front right"] == ("kept", "LR 3 · by balance 402")
    assert shown["sensor chain"] == ("lit", "LR 45 · by balance 52")
    assert shown["brake rear right"] == ("unseen", "not seen in this data")


def test_brightness_grows_with_the_likelihood_ratio() -> None:
    ratios = [LEAST_RATIO, 10.0, 100.0, 1000.0]
    values = [brightness(ratio, 1000.0) for ratio in ratios]
    assert values[0] == 0.0
    assert values == sorted(values)
    assert values[-1] == 1.0
    assert brightness(None, 1000.0) == 0.0
    assert outside({"wheel torque fl": 500.0, "yaw rate and wheel speeds": 50.0}) == [
        ("yaw rate and wheel speeds", 50.0)
    ]


def test_the_page_says_from_which_ratio_on_a_room_is_lit(findings: Findings) -> None:
    assert f"replay, from {LEAST_RATIO:g} on" in page_of(findings)


def test_no_likelihood_ratios_no_house() -> None:
    assert house_of_equations({}) == ""


def test_mean_residual_over_pressure_is_the_lost_force(findings: Findings) -> None:
    """The vehicle file brakes with F = k p where the car has 0.8 k p: the residual of ax is 0.2 k p / m."""
    binned = binned_residual(findings, "longitudinal_acceleration", "pressure")
    assert binned is not None
    lost = (1.0 - made_up_findings.TRUE_FRICTION) * made_up_findings.FORCE_PER_PRESSURE_N_PA / made_up_findings.MASS_KG
    held = binned.centres > 6.5e6  # the held 70 bar: no ramp inside the bin
    assert binned.before[held] == pytest.approx(lost * 7.0e6, rel=0.02)
    assert np.abs(binned.after).max() < 0.1 * np.abs(binned.before).max()
    assert binned.before[0] == pytest.approx(0.0, abs=3 * binned.band[0])


def test_residuals_over_a_state_that_no_data_has(findings: Findings) -> None:
    assert binned_residual(findings, "longitudinal_acceleration", "slip_angle") is None
    rows = residual_maps(findings, ["speed"])
    assert [len(pictures) for _, _, pictures in rows] == [4]


def test_a_state_that_hardly_changes_is_not_drawn(findings: Findings) -> None:
    """Discs that warm by half a degree: a mean over them would show time, not temperature."""
    assert binned_residual(findings, "longitudinal_acceleration", "temperature") is not None
    cool = [
        replace(
            part,
            states={
                name: 20.0 + 0.5 * (values - values[0]) / max(np.ptp(values), 1e-9) if "temperature" in name else values
                for name, values in part.states.items()
            },
        )
        for part in findings.manoeuvres
    ]
    assert binned_residual(replace(findings, manoeuvres=cool), "longitudinal_acceleration", "temperature") is None


def test_a_signal_no_sample_of_which_counts_is_told_and_not_drawn(findings: Findings) -> None:
    """As the longitudinal acceleration of a log without drive torque and brake pressure."""
    column = findings.manoeuvres[0].signals.index("longitudinal_acceleration")
    silent = [replace(part, weights=part.weights.copy()) for part in findings.manoeuvres]
    for part in silent:
        part.weights[:, column] = 0.0
    without = replace(findings, manoeuvres=silent)
    assert "longitudinal_acceleration" not in ranked_signals(Timeline(silent), findings.sensor_std)
    assert binned_residual(without, "longitudinal_acceleration", "pressure") is None
    page = page_of(without)
    assert "curve-longitudinal_acceleration" not in page
    assert "Measured but not compared: longitudinal acceleration" in texts(page)
    assert "Measured but not compared" not in texts(page_of(findings))


def test_one_of_each_kind_of_signal_comes_first(findings: Findings) -> None:
    order = ranked_signals(Timeline(findings.manoeuvres), findings.sensor_std)
    kinds = [name.partition("_f")[0].partition("_r")[0] for name in order[:3]]
    assert sorted(kinds) == ["longitudinal_acceleration", "speed", "wheel_speed"]


def test_manoeuvres_follow_each_other_with_a_pause(findings: Findings) -> None:
    timeline = Timeline(findings.manoeuvres)
    ends = [(stretch.start_s, stretch.end_s) for stretch in timeline.stretches]
    assert all(begin == pytest.approx(end + GAP_S + SAMPLE_TIME_S) for (_, end), (begin, _) in pairwise(ends))
    speed = timeline.column("speed", lambda part: part.measured)
    assert speed is not None
    assert np.isnan(speed).sum() == round(GAP_S / SAMPLE_TIME_S) * (len(ends) - 1)
    assert timeline.column("yaw_rate", lambda part: part.measured) is None


def test_gain_bars_say_better_and_worse(findings: Findings) -> None:
    gain = findings.diagnosis.gain
    assert gain is not None
    drawing = gain_bars(gain)
    assert drawing.count('class="after"') == 2
    assert drawing.count('class="worse-bar"') == 1
    assert "1.9 → 0.11 m/s" in drawing


def test_evidence_bars_mark_threshold_and_named_effect(findings: Findings) -> None:
    drawing = evidence_bars(findings.evidence, 4.2, findings.diagnosis.causes)
    assert drawing.count('class="after"') == 1
    assert "needed: 4.2" in drawing
    assert "92.4" in drawing  # the refit's evidence in place of the linear one
    assert evidence_bars({}, None, []) == ""


def test_interval_mark_holds_the_interval_and_the_nominal_value() -> None:
    drawing = interval_mark(ParameterEstimate(value=0.3, low=0.28, high=0.32, unit="1", nominal=0.4))
    nominal, centre, left, width = (
        float(value)
        for pattern in (r'nominal" x1="([\d.]+)', r'cx="([\d.]+)', r'range" x="([\d.]+)', r'range".* width="([\d.]+)')
        for value in re.findall(pattern, drawing)
    )
    assert left < centre < left + width < nominal
    assert (nominal - centre) / width == pytest.approx(0.1 / 0.04, rel=0.01)


def test_ratings_are_better_with_what_was_found(findings: Findings) -> None:
    table = rating_table(findings)
    assert table is not None
    stop = dict(table["rows"])["firm stop"]
    speed = stop[table["signals"].index("speed over ground")]
    assert float(speed["after"]) > 0.94 > float(speed["before"])
    assert speed["grade"] == "excellent"


def test_the_answer_is_kept_where_the_page_fails(
    findings: Findings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Minutes of searching are not lost to a page that cannot be drawn."""
    import bench.diagnosis_report.page as page
    from bench.diagnosis.diagnosing import ANSWER_FILE, Found, write
    from vehicle_model.vehicle_file import load_vehicle

    def failing(*_: object) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(page, "build", failing)
    nothing = replace(findings, diagnosis=findings.diagnosis.model_copy(update={"causes": []}), terms=[])
    with pytest.raises(OSError, match="no space"):
        write(Found(nothing, load_vehicle("ekf_car"), "ekf_car"), tmp_path, stops=False)
    written = Diagnosis.model_validate_json((tmp_path / ANSWER_FILE).read_text("utf-8"))
    assert written.verdict == nothing.diagnosis.verdict
