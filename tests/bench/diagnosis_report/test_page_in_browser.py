"""The page of a diagnosis in a real browser: nothing is asked for, nothing sticks out, every curve is drawn."""

from collections.abc import Callable
from pathlib import Path

import pytest
from browser import Browser

pytestmark = pytest.mark.browser


@pytest.mark.parametrize(("width", "dark"), [(400, False), (1500, True)])
def test_page_is_drawn_without_complaint(
    browser: Callable[..., Browser], diagnosis_page: Path, width: int, dark: bool
) -> None:
    page = browser(diagnosis_page, width=width, dark=dark)
    page.run("for (const details of document.querySelectorAll('details')) details.open = true;")
    assert page.console_messages() == []
    assert [url for url in page.requests() if not url.startswith(("file:", "data:"))] == []
    assert page.run("return document.documentElement.scrollWidth") <= width
    # six signals: measured, before, after and restarted beside residuals before and after
    assert page.run("return document.querySelectorAll('path.curve[data-series]').length") == 6 * 6
    assert page.run("return document.querySelectorAll('.area').length") >= 6 * 2
    assert page.run("return document.querySelectorAll('.house .guilty').length") == 1
    assert page.run("return document.querySelectorAll('.maps svg').length") == 6 * 4


def test_a_manoeuvre_button_zooms_all_charts(browser: Callable[..., Browser], diagnosis_page: Path) -> None:
    page = browser(diagnosis_page, width=1300)
    page.run("[...document.querySelectorAll('.toolbar button')].find((b) => b.textContent === 'firm stop').click()")
    page.settle()
    assert page.run("return document.querySelector('.toolbar output').textContent") == "18.00 to 23.99 s"
