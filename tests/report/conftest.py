# SPDX-License-Identifier: GPL-3.0-or-later
"""The report in headless Chromium.

Skips where Chromium or its driver is not installed, unless W2W_NEED_CHROMIUM is set, as CI does.
"""

import os
import shutil

import pytest

from w2w.headless.commands.report import write_report

from ..headless.conftest import (
    drawn,
    drawn_results,
    made_once_here,
    one_worker,
    quick_run,
    sparse_results,
)
from .browser import settle

__all__ = ["drawn", "drawn_results", "made_once_here", "one_worker", "quick_run", "sparse_results"]

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
DRIVER = shutil.which("chromedriver")
FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --use-gl=angle --use-angle=swiftshader "
    "--enable-unsafe-swiftshader --hide-scrollbars --window-size=1280,1000"
)


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    if not (CHROMIUM and DRIVER) and not os.environ.get("W2W_NEED_CHROMIUM"):
        pytest.skip("Chromium and chromedriver are not installed")
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in FLAGS.split():
        options.add_argument(flag)
    options.add_argument(f"--user-data-dir={tmp_path_factory.mktemp('chromium')}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(executable_path=DRIVER))
    driver.set_script_timeout(60)
    yield driver
    driver.quit()


@pytest.fixture
def page(browser, drawn_results):
    """The report, opened anew at desktop size."""
    path = write_report(drawn_results)
    browser.set_window_size(1280, 1000)
    browser.get(path.as_uri())
    settle(browser)
    browser.execute_script("document.querySelector(\"[data-turn='0']\").click()")
    settle(browser)
    yield browser
    loud = [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]
    assert not loud, loud
