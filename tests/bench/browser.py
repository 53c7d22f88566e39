"""Chromium as the tests of pages use it: a window of given width, a colour scheme, and all that it complains about."""

import json
import os
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = Path("/usr/bin/chromium")
CHROMEDRIVER = Path("/usr/bin/chromedriver")
INSTALL = "sudo apt-get install chromium chromium-driver"


class Browser:
    """A page in a window of Chromium."""

    def __init__(self, driver: Any) -> None:
        self.driver = driver

    def run(self, script: str, *arguments: Any) -> Any:
        """Run a script in the page."""
        return self.driver.execute_script(script, *arguments)

    def settle(self) -> None:
        """Wait until what the last action caused is drawn."""
        twice = "requestAnimationFrame(() => requestAnimationFrame(() => done()))"
        self.driver.execute_async_script(f"const done = arguments[arguments.length - 1]; {twice};")

    def console_messages(self) -> list[str]:
        """Warnings and errors of the page so far."""
        return [f"{entry['level']}: {entry['message']}" for entry in self.driver.get_log("browser")]

    def requests(self) -> list[str]:
        """Addresses that the page asked for so far."""
        events = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        return [e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"]

    def open(self, page: Path, *, width: int = 1280, height: int = 900, dark: bool = False) -> "Browser":
        """Open a page and wait until its script has drawn everything."""
        from selenium.webdriver.support.ui import WebDriverWait

        driver = self.driver
        driver.get("about:blank")
        for log in ("browser", "performance"):
            driver.get_log(log)  # what an earlier page or the browser's own start page left there
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [scheme]})
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        driver.get(page.absolute().as_uri())
        ready = "return document.documentElement.dataset.ready === 'true'"
        WebDriverWait(driver, 20).until(lambda _: self.run(ready))
        return self


def start_chromium(profile: Path) -> Browser:
    """Chromium without a window; skips where it is not installed."""
    if not CHROMIUM.exists() or not CHROMEDRIVER.exists():
        pytest.skip(f"no chromium here: {INSTALL}")
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service

    options = Options()
    options.binary_location = str(CHROMIUM)
    switches = ["headless", "disable-gpu", "no-first-run", "disable-background-networking", "disable-component-update"]
    switches += ["disable-sync", "hide-scrollbars", f"user-data-dir={profile}"]
    if os.geteuid() == 0:
        switches.append("no-sandbox")  # Chromium's sandbox does not start as root
    for switch in switches:
        options.add_argument(f"--{switch}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return Browser(webdriver.Chrome(options=options, service=Service(str(CHROMEDRIVER))))
