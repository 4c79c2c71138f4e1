# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the pictures of README, documents, web app and listing from the demo: `make pictures`.

Those of Blender's window and the listing's are made where `pytest tests/gui/test_try_examples.py` left its
screenshots, that of the report where Chromium is.
"""

from __future__ import annotations

import io
import json
import shutil
import time
from collections.abc import Callable
from pathlib import Path

from matplotlib import font_manager
from PIL import Image, ImageChops, ImageDraw, ImageFont

from tools import make_web_demo

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "demo_output" / "results"
PICTURES, RELEASE = ROOT / "docs" / "pictures", ROOT / "release"
SCREENSHOTS = ROOT / ".cache" / "blender-4.3" / "try_examples" / "pictures"

WIDTH, COLOURS = 1400, 256

VIEW = (0, 28, 1056, 720)
"""The 3D viewport with its sidebar, in pixels of the screenshot."""

BESIDE = (290, 80, 906, 800)
"""A clip and its source armature, in pixels of the larger window of `tests/gui/test_window.py`."""

WINDOWS = {"animator_heatmap": "2_answer", "animator_pick": "3_card"}
PREVIEWS = ("2_answer", "3_card", "4_details")

LISTED, INK, PAPER, DARK = (1920, 1080), (24, 28, 38), (255, 255, 255), (48, 48, 48)

FLAGS = (
    "--headless --no-sandbox --disable-gpu --use-gl=angle --use-angle=swiftshader "
    "--enable-unsafe-swiftshader --hide-scrollbars --window-size=1280,1000"
)

DRAWN_S = 4.0
"""Seconds that a page may take to draw in software."""


def main() -> None:
    """Make all that can be made here, and say what cannot."""
    for name in ("mean", "subset"):
        small = _wide(Image.open(RESULTS / "heatmaps" / f"{name}.png").convert("RGB"), WIDTH)
        small.quantize(COLOURS).save(PICTURES / f"demo_{name}.png", optimize=True)
    shown = json.dumps(make_web_demo.picture(RESULTS), separators=(",", ":"))
    make_web_demo.TARGET.write_text(f"{shown}\n", encoding="utf-8")
    _if("chromium and chromedriver", shutil.which("chromedriver"), _report)
    _if("the screenshots of make test-window", SCREENSHOTS.is_dir(), _windows)


def _if(needed: str, there: object, make: Callable[[], None]) -> None:
    if there:
        make()
    else:
        print(f"{make.__name__.strip('_')}: not made, for want of {needed}")


def _report() -> None:
    """The first screen of the report."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for flag in FLAGS.split():
        options.add_argument(flag)
    browser = webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))
    try:
        browser.get((RESULTS / "report.html").as_uri())
        time.sleep(DRAWN_S)
        picture = Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB")
    finally:
        browser.quit()
    picture.save(PICTURES / "report.png", optimize=True)


def _windows() -> None:
    """Cuts of the window, and what the listing shows, in all colours: fewer would bend the colour maps."""
    windows = {path.stem: Image.open(path).convert("RGB") for path in SCREENSHOTS.glob("*.png")}
    for name, window in WINDOWS.items():
        windows[window].crop(VIEW).save(PICTURES / f"{name}.png", optimize=True)
    larger = SCREENSHOTS.parents[1] / "window" / SCREENSHOTS.name / "2_source_beside.png"
    if larger.is_file():
        Image.open(larger).convert("RGB").crop(BESIDE).save(
            PICTURES / "animator_source_beside.png", optimize=True
        )
    for number, window in enumerate(PREVIEWS, 1):
        _fitted(windows[window], DARK, LISTED).save(RELEASE / f"preview_{number}.png", optimize=True)
    mean = Image.open(RESULTS / "heatmaps" / "mean.png").convert("RGB")
    bodies = mean.crop(ImageChops.difference(mean, Image.new("RGB", mean.size, PAPER)).getbbox())
    featured = Image.new("RGB", LISTED, PAPER)
    font = ImageFont.truetype(font_manager.findfont("DejaVu Sans:bold"), 84)
    ImageDraw.Draw(featured).text(
        (LISTED[0] / 2, 110), "Where should the sensor sit?", INK, font, anchor="mm"
    )
    featured.paste(_fitted(bodies, PAPER, (LISTED[0] - 160, LISTED[1] - 260)), (80, 200))
    featured.save(RELEASE / "featured.png", optimize=True)
    front = bodies.crop((0, 0, round(0.42 * bodies.width), bodies.height))
    front.putalpha(front.convert("HSV").getchannel("S").point(lambda value: 255 if value > 100 else 0))
    front = front.crop(front.getbbox())  # words are grey
    icon = Image.new("RGBA", (max(front.size),) * 2)
    icon.paste(front, ((icon.width - front.width) // 2, (icon.height - front.height) // 2))
    icon.resize((256, 256), Image.Resampling.LANCZOS).save(RELEASE / "icon.png", optimize=True)


def _wide(picture: Image.Image, width: int) -> Image.Image:
    height = round(picture.height * width / picture.width)
    return picture.resize((width, height), Image.Resampling.LANCZOS)


def _fitted(picture: Image.Image, ground: tuple[int, int, int], size: tuple[int, int]) -> Image.Image:
    """A picture as large as fits, in the middle of a ground."""
    small = _wide(picture, round(picture.width * min(size[0] / picture.width, size[1] / picture.height)))
    image = Image.new("RGB", size, ground)
    image.paste(small, ((size[0] - small.width) // 2, (size[1] - small.height) // 2))
    return image


if __name__ == "__main__":
    main()
