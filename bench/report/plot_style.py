"""The one style of pictures that matplotlib draws, in the colours of the report page."""

from typing import Any

INK, SOFT, LINE = "#14181f", "#515b6a", "#d9dde4"
WHEEL_COLOURS = {"fl": "#0b62c4", "fr": "#c2410c", "rl": "#0f7b4f", "rr": "#9333a8"}
VALVE_COLOURS = {"build": "#b6d4f5", "hold": "#f0b23e", "release": "#c6324f", "rebuild": "#2f9c95"}
VERDICT_COLOURS = {"pass": "#12713f", "fail": "#b3132f", "inconclusive": "#8a5300", "error": "#7a1fa2"}


def plot_style() -> dict[str, Any]:
    """Parameters for ``matplotlib.rc_context``."""
    return {
        "figure.facecolor": "white",
        "axes.facecolor": "white",
        "axes.edgecolor": LINE,
        "axes.labelcolor": SOFT,
        "axes.labelsize": 9,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "grid.color": "#e8ebf0",
        "grid.linewidth": 0.8,
        "axes.axisbelow": True,
        "font.size": 9,
        "font.family": "sans-serif",
        "legend.frameon": False,
        "legend.fontsize": 8,
        "legend.handlelength": 1.6,
        "legend.columnspacing": 1.4,
        "lines.linewidth": 1.3,
        "text.color": INK,
        "xtick.color": SOFT,
        "ytick.color": SOFT,
        "xtick.labelsize": 8,
        "ytick.labelsize": 8,
        "svg.fonttype": "path",
        "svg.hashsalt": "bench",
    }
