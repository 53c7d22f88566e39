"""The generator is a program of its own: its tests find its package beside it, not among those that are installed."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
