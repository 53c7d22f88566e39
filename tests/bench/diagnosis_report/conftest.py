import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parent.parent / "report"))

import made_up_findings
from browser import Browser, start_chromium

from model_diagnosis.findings import Findings


@pytest.fixture(scope="session")
def findings() -> Findings:
    """Worn pads, found."""
    return made_up_findings.findings()


@pytest.fixture(scope="session")
def diagnosis_page(findings: Findings, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """``diagnosis.html`` of it."""
    from bench.diagnosis_report.page import build

    return build(findings, tmp_path_factory.mktemp("diagnosis"))


@pytest.fixture(scope="session")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """One Chromium for all tests."""
    started = start_chromium(tmp_path_factory.mktemp("chromium"))
    yield started
    started.driver.quit()


@pytest.fixture
def browser(chromium: Browser) -> Callable[..., Browser]:
    """``browser(page, width=…, dark=…)`` opens a page."""
    return chromium.open
