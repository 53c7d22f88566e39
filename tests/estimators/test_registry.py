"""Registry, settings and their errors; what must be importable without compiled code."""

import subprocess
import sys
from pathlib import Path

import friction_twin as twin
import numpy as np
import pytest

import estimators
from estimators.documentation import estimators_page
from estimators.post_filter import MEDIAN, memory_size, post_filter
from signals.catalogue import catalogue
from signals.errors import InputError


def test_unknown_estimator_names_the_nearest():
    with pytest.raises(InputError, match="friction_ekf"):
        estimators.create("friction_efk", twin.TABLE_8)


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({"torque_mod": "z2"}, "did you mean torque_mode"),
        ({"process_noise.slipp": 0.1}, "did you mean slip"),
        ({"torque_mode": "z3"}, "torque_mode: found 'z3'"),
        ({"minimum_speed": "5 kg"}, "a quantity in kg"),
        ({"prediction_substeps": 0}, "greater than or equal to 1"),
        ({"gate": float("nan")}, "gate"),
    ],
)
def test_wrong_settings_say_what_is_wrong(settings, expected):
    with pytest.raises(InputError, match=expected):
        estimators.create("friction_ekf", twin.TABLE_8, settings)


def test_settings_take_units_and_dotted_keys():
    estimator = estimators.create(
        "friction_ekf", twin.TABLE_8, {"minimum_speed": "10 km/h", "process_noise.slip": 0.03}
    )
    assert estimator.settings.minimum_speed == pytest.approx(10 / 3.6)
    assert estimator.settings.process_noise.slip == 0.03


@pytest.mark.parametrize("name", estimators.names())
def test_outputs_have_their_deviation_or_confidence(name):
    """Every estimated quantity that claims a reference has ``_std`` or ``_confidence`` beside it."""
    description = estimators.describe(name)
    known = {signal.name for signal in catalogue()}
    names = {output.name for output in description.outputs}
    assert len(names) == len(description.outputs)
    for output in description.compared():
        assert f"{output.name}_std" in names or f"{output.name}_confidence" in names
        assert set(output.references + output.weights + output.over) <= known
        assert len(output.weights) in (0, len(output.references))
    settings = description.settings()
    assert set(description.inputs(settings)) <= {s.name for s in catalogue() if s.block == "bus"}


def test_descriptions_import_no_compiled_code():
    code = (
        "import sys, estimators; [estimators.describe(n).signals() for n in estimators.names()];"
        "print([m for m in ('numba', 'scipy', 'mujoco', 'can') if m in sys.modules])"
    )
    assert (
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip() == "[]"
    )


def test_page_of_the_estimators_is_up_to_date():
    """``python -m estimators.documentation`` writes docs/estimators.md."""
    page = Path(__file__).resolve().parents[2] / "docs" / "estimators.md"
    assert page.read_text(encoding="utf-8") == estimators_page()


def test_running_median_equals_the_median():
    random = np.random.default_rng(0)
    samples = random.standard_normal(400).round(1)
    memory = np.zeros(memory_size(51))
    for k, sample in enumerate(samples):
        assert post_filter(memory, MEDIAN, 0.0, sample) == np.median(samples[max(0, k - 50) : k + 1])
