"""Makes the twin of these tests importable; the twin shares no code with the estimators."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
