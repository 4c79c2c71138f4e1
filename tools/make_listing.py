# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the pictures of the listing in release/: previews of real windows, the featured image, the icon.

make demo && make test-window && .venv/bin/python tools/make_listing.py
"""

from pathlib import Path

from matplotlib import font_manager
from PIL import Image, ImageChops, ImageDraw, ImageFont

PROJECT = Path(__file__).resolve().parents[1]
RELEASE = PROJECT / "release"
SCREENSHOTS = PROJECT / ".cache" / "blender-4.3"
MEAN = PROJECT / "demo_output" / "results" / "heatmaps" / "mean.png"

PREVIEWS = ("window/pictures/5_mean", "run/pictures/3_signals", "run/pictures/6_two_maps")
"""Screenshots that the tests of Blender's window leave."""

SIZE = (1920, 1080)
INK, PAPER, DARK = (24, 28, 38), (255, 255, 255), (48, 48, 48)


def main() -> None:
    """Write all five."""
    for number, name in enumerate(PREVIEWS, 1):
        window = Image.open(SCREENSHOTS / f"{name}.png").convert("RGB")
        _fitted(window, DARK, SIZE).save(RELEASE / f"preview_{number}.png", optimize=True)
    bodies = _trimmed(Image.open(MEAN).convert("RGB"))
    _featured(bodies).save(RELEASE / "featured.png", optimize=True)
    _icon(bodies).save(RELEASE / "icon.png", optimize=True)


def _fitted(picture: Image.Image, ground: tuple[int, int, int], size: tuple[int, int]) -> Image.Image:
    """A picture as large as fits, in the middle of a ground."""
    scale = min(size[0] / picture.width, size[1] / picture.height)
    small = picture.resize(
        (round(picture.width * scale), round(picture.height * scale)), Image.Resampling.LANCZOS
    )
    image = Image.new("RGB", size, ground)
    image.paste(small, ((size[0] - small.width) // 2, (size[1] - small.height) // 2))
    return image


def _trimmed(picture: Image.Image) -> Image.Image:
    """A picture without the paper around it."""
    return picture.crop(ImageChops.difference(picture, Image.new("RGB", picture.size, PAPER)).getbbox())


def _featured(bodies: Image.Image) -> Image.Image:
    """The demo's heatmap under the question that it answers."""
    image = Image.new("RGB", SIZE, PAPER)
    font = ImageFont.truetype(font_manager.findfont("DejaVu Sans:bold"), 84)
    ImageDraw.Draw(image).text((SIZE[0] / 2, 110), "Where should the sensor sit?", INK, font, anchor="mm")
    image.paste(_fitted(bodies, PAPER, (SIZE[0] - 160, SIZE[1] - 260)), (80, 200))
    return image


def _icon(bodies: Image.Image) -> Image.Image:
    """The body from the front, on transparent ground."""
    front = bodies.crop((0, 0, round(0.42 * bodies.width), bodies.height))
    colourful = front.convert("HSV").getchannel("S").point(lambda value: 255 if value > 100 else 0)
    front.putalpha(colourful)  # words are grey
    front = front.crop(front.getbbox())
    side = max(front.size)
    square = Image.new("RGBA", (side, side))
    square.paste(front, ((side - front.width) // 2, (side - front.height) // 2))
    return square.resize((256, 256), Image.Resampling.LANCZOS)


if __name__ == "__main__":
    main()
