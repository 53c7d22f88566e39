"""From contents to one self-contained file: template, style, script and data in a single page."""

import json
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

FOLDER = Path(__file__).parent / "assets"
SCRIPTS = ("scale.js", "time_view.js", "line_chart.js", "lane_chart.js", "histogram.js", "main.js")


@cache
def _environment() -> Environment:
    return Environment(
        loader=FileSystemLoader(FOLDER),
        autoescape=select_autoescape(("j2",), default=True),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def render(
    template: str, data: Mapping[str, Any], contents: Mapping[str, Any], scripts: Sequence[str] = SCRIPTS
) -> str:
    """Page with everything inside it.

    Parameters
    ----------
    template : str
        File of the assets folder.
    data : mapping
        What the page's script draws.
    contents : mapping
        Variables of the template.
    scripts : sequence of str
        Files of the assets folder that make the page's script.
    """
    inline = json.dumps(data, separators=(",", ":"), allow_nan=False)
    for character, escape in (("<", "\\u003c"), (">", "\\u003e"), ("&", "\\u0026")):
        inline = inline.replace(character, escape)  # nothing in the data can end the script element
    script = "\n".join((FOLDER / name).read_text(encoding="utf-8") for name in scripts)
    style = (FOLDER / "style.css").read_text(encoding="utf-8")
    page = _environment().get_template(template)
    return page.render(contents, data=Markup(inline), script=Markup(script), style=Markup(style))
