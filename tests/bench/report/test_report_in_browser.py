"""The page in a real browser: both colour schemes, a telephone's and a desk's width, keyboard and pointer."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from browser import Browser

pytestmark = pytest.mark.browser

EMPTY_CURVES = """return [...document.querySelectorAll('.chart')].flatMap((chart) => {
  const curves = [...chart.querySelectorAll('path.curve[data-series]')];
  return curves.filter((c) => c.getAttribute('d').length < 20).map((c) => chart.id + ' ' + c.dataset.series);
})"""

# relative luminance and contrast as WCAG 2.1 defines them: 4.5 for every text, 3 for every curve
CONTRAST = """
const luminance = ([r, g, b]) => {
  const linear = [r, g, b].map((v) => { v /= 255; return v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4; });
  return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
};
const numbers = (colour) => (colour.match(/[\\d.]+/g) ?? []).map(Number);
const ground = (element) => {
  for (let e = element; e; e = e.parentElement) {
    const colour = numbers(getComputedStyle(e).backgroundColor);
    if (colour.length === 3 || colour[3] === 1) return colour.slice(0, 3);
  }
  return [255, 255, 255];
};
const poor = [];
const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
while (walker.nextNode()) {
  const element = walker.currentNode.parentElement;
  const box = element.getBoundingClientRect();
  if (!walker.currentNode.data.trim() || !box.width || element.closest('script, .visually-hidden, .skip')) continue;
  const style = getComputedStyle(element);
  const text = numbers(element.closest('svg') ? style.fill : style.color).slice(0, 3);
  const [a, b] = [luminance(text), luminance(ground(element))].sort((x, y) => y - x);
  const contrast = (a + 0.05) / (b + 0.05);
  if (contrast < 4.5) poor.push(`${walker.currentNode.data.trim().slice(0, 30)}: ${contrast.toFixed(2)}`);
}
for (const curve of document.querySelectorAll('path.curve[data-series]')) {
  const colours = [numbers(getComputedStyle(curve).stroke).slice(0, 3), ground(curve)];
  const [a, b] = colours.map(luminance).sort((x, y) => y - x);
  if ((a + 0.05) / (b + 0.05) < 3) poor.push(`curve ${curve.dataset.series}: ${((a + 0.05) / (b + 0.05)).toFixed(2)}`);
}
return poor;
"""


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [400, 1600])
def test_page_is_drawn_without_complaint(
    browser: Callable[..., Browser], report_page: Path, width: int, dark: bool
) -> None:
    page = browser(report_page, width=width, dark=dark)
    assert page.console_messages() == []
    assert [url for url in page.requests() if not url.startswith(("file:", "data:"))] == []
    assert page.run("return document.documentElement.scrollWidth") <= width
    assert page.run("return document.querySelectorAll('path.curve[data-series]').length") >= 25
    assert page.run(EMPTY_CURVES) == []
    assert page.run("return document.querySelectorAll('#chart-lateness path.f-bench').length") >= 10
    assert page.run("return document.querySelectorAll('#chart-frames .f-ecu').length") >= 2
    ground = page.run("return getComputedStyle(document.body).backgroundColor")
    brightness = sum(map(int, re.findall(r"\d+", ground)[:3])) / 3
    assert (brightness < 60) == dark


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_every_text_and_curve_has_contrast(browser: Callable[..., Browser], report_page: Path, dark: bool) -> None:
    page = browser(report_page, width=1280, dark=dark)
    page.run("for (const details of document.querySelectorAll('details')) details.open = true;")
    assert page.run(CONTRAST) == []


def test_nothing_sticks_out_on_a_narrow_screen(browser: Callable[..., Browser], report_page: Path) -> None:
    page = browser(report_page, width=400)
    page.run("for (const details of document.querySelectorAll('details')) details.open = true;")
    assert page.run("return document.documentElement.scrollWidth") <= 400


def test_link_of_a_failure_shows_its_instant(browser: Callable[..., Browser], report_page: Path) -> None:
    page = browser(report_page)
    page.run("document.querySelector('tr.fail [data-at]').click()")
    page.settle()
    time = float(page.run("return document.querySelector('tr.fail [data-at]').dataset.at"))
    assert f"t = {time:.3f} s" in page.run("return document.querySelector('.toolbar output').textContent")
    assert page.run("return document.querySelectorAll('.cursor-line').length") >= 10
    assert page.run("return Math.abs(document.getElementById('chart-slip').getBoundingClientRect().top) < 200")
    values = page.run(
        "return [...document.querySelectorAll('#chart-slip .legend .value')].map((value) => Number(value.textContent))"
    )
    assert len(values) == 4
    assert max(values) > 10.0


def test_dragging_zooms_and_double_click_shows_everything(browser: Callable[..., Browser], report_page: Path) -> None:
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By

    page = browser(report_page, width=1280)
    plot = page.driver.find_element(By.CSS_SELECTOR, "#chart-speed .plot")
    before = page.run("return document.querySelector('#chart-slip path.curve[data-series]').getAttribute('d')")
    ActionChains(page.driver).move_to_element_with_offset(plot, -200, 0).click_and_hold().move_by_offset(
        150, 0
    ).release().perform()
    page.settle()
    after = page.run("return document.querySelector('#chart-slip path.curve[data-series]').getAttribute('d')")
    assert before != after
    assert page.run("return document.querySelector('.toolbar [aria-pressed=true]')") is None
    ActionChains(page.driver).double_click(plot).perform()
    page.settle()
    assert page.run("return document.querySelector('.toolbar [aria-pressed=true]').textContent") == "whole run"


def test_keys_move_the_cursor_and_zoom(browser: Callable[..., Browser], report_page: Path) -> None:
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys

    page = browser(report_page)
    plot = page.driver.find_element(By.CSS_SELECTOR, "#chart-speed .plot")
    page.run("arguments[0].focus()", plot)
    plot.send_keys(Keys.ARROW_RIGHT * 5)
    page.settle()
    assert "t = 0.500 s" in page.run("return document.querySelector('.toolbar output').textContent")
    plot.send_keys("+")
    page.settle()
    assert page.run("return document.querySelector('.toolbar [aria-pressed=true]')") is None
    plot.send_keys(Keys.HOME)
    plot.send_keys(Keys.ESCAPE)
    page.settle()
    assert "0.00 to 10.00 s" in page.run("return document.querySelector('.toolbar output').textContent")


def test_step_buttons_show_a_step(browser: Callable[..., Browser], report_page: Path) -> None:
    page = browser(report_page)
    page.run("[...document.querySelectorAll('.toolbar [data-start]')].find((b) => b.textContent === 'brake').click()")
    page.settle()
    text = page.run("return document.querySelector('.toolbar output').textContent")
    assert text.startswith("1.00 to 4.")


def test_legend_hides_a_curve(browser: Callable[..., Browser], report_page: Path) -> None:
    page = browser(report_page)
    count = "return document.querySelectorAll('#chart-speed path.curve[data-series]').length"
    before = page.run(count)
    page.run("document.querySelector('#chart-speed .legend button').click()")
    assert page.run(count) == before - 1
    assert (
        page.run("return document.querySelector('#chart-speed .legend button').getAttribute('aria-pressed')") == "false"
    )


def test_address_can_name_an_instant(browser: Callable[..., Browser], report_page: Path) -> None:
    page = browser(report_page)
    page.driver.get("about:blank")
    page.driver.get(report_page.absolute().as_uri() + "#t=2.5")
    page.settle()
    assert "t = 2.500 s" in page.run("return document.querySelector('.toolbar output').textContent")


def test_page_prints_with_open_details(browser: Callable[..., Browser], report_page: Path) -> None:
    page = browser(report_page, dark=True)
    printed = page.driver.execute_cdp_cmd("Page.printToPDF", {"printBackground": True})
    assert len(printed["data"]) > 50_000
    assert page.run("return [...document.querySelectorAll('details')].every((details) => details.open)")


def test_everything_that_acts_has_a_name(browser: Callable[..., Browser], report_page: Path) -> None:
    page = browser(report_page)
    unnamed = page.run(
        "return [...document.querySelectorAll('button, a, [tabindex=\"0\"]')].filter((e) => "
        "!(e.getAttribute('aria-label') ?? e.textContent).trim()).map((e) => e.outerHTML.slice(0, 80))"
    )
    assert unnamed == []
    assert page.run("return document.documentElement.lang") == "en"
    assert page.run("return document.querySelectorAll('h1').length") == 1
    labels = page.run("return [...document.querySelectorAll('.plot')].map((plot) => plot.getAttribute('aria-label'))")
    assert all(len(label) > 20 for label in labels)
