import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import made_up_findings

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
