# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of docs/report.md: the demo's report in headless Chromium, from behind, a patch pointed at.

make demo && python docs/make_report_picture.py demo_output/results
"""

from __future__ import annotations

import io
import shutil
import sys
import time
from pathlib import Path

from PIL import Image
from selenium import webdriver
from selenium.webdriver import ActionChains
from selenium.webdriver.common.by import By

PICTURE = Path(__file__).resolve().parent / "pictures" / "report.png"
FLAGS = (
    "--headless --no-sandbox --disable-gpu --use-gl=angle --use-angle=swiftshader "
    "--enable-unsafe-swiftshader --hide-scrollbars --window-size=1280,1100"
)
POINTED_AT = (0.05, -0.14)
"""Of the view's width and height, right of its middle and above it."""

DRAWN_S = 3.0
"""Seconds that a page may take to draw in software."""

MARGIN, WIDTH = 8, 960
"""Pixels left around the body and what stands beside it; width of the picture."""


def main(report: Path) -> None:
    """Open, choose the first activity, turn to the back, point, cut."""
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for flag in FLAGS.split():
        options.add_argument(flag)
    browser = webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))
    try:
        browser.get(report.resolve().as_uri())
        time.sleep(DRAWN_S)
        for button in ("input[name=map][value='1']", "button[data-turn='180']"):
            browser.execute_script("arguments[0].click()", browser.find_element(By.CSS_SELECTOR, button))
        shown = browser.find_element(By.CSS_SELECTOR, "main")
        browser.execute_script("arguments[0].scrollIntoView()", shown)
        view = browser.find_element(By.ID, "view")
        right, down = round(POINTED_AT[0] * view.size["width"]), round(POINTED_AT[1] * view.size["height"])
        ActionChains(browser).move_to_element_with_offset(view, right, down).perform()
        time.sleep(DRAWN_S)
        picture = Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB")
        box = browser.execute_script(
            "const box = arguments[0].getBoundingClientRect();"
            "return [box.left, box.top, box.right, box.bottom]",
            shown,
        )
    finally:
        browser.quit()
    left, top, right, bottom = (round(side) for side in box)
    picture = picture.crop(
        (
            max(left - MARGIN, 0),
            max(top - MARGIN, 0),
            min(right + MARGIN, picture.width),
            min(bottom + MARGIN, picture.height),
        )
    )
    height = round(picture.height * WIDTH / picture.width)
    picture.resize((WIDTH, height), Image.Resampling.LANCZOS).save(PICTURE, optimize=True)  # all colours
    print(f"{PICTURE.name}: {PICTURE.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]) / "report.html")
