# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the pictures of the listing in release/: previews in a real window, the icon and the featured image.

make demo && tools/real_blender.sh && make extension && .venv/bin/python tools/make_listing.py
"""

import shutil
import sys

from blender_wheels import PROJECT
from PIL import Image, ImageChops, ImageDraw, ImageFont

sys.path.insert(0, str(PROJECT))
from tests.gui import sandbox

RELEASE = PROJECT / "release"
RUN = PROJECT / "demo_output" / "results"
SIZE = (1920, 1080)
PREVIEWS = ("preview_1", "preview_2", "preview_3")

INK, PAPER = (24, 28, 38), (255, 255, 255)


def main() -> None:
    """Write all five."""
    RELEASE.mkdir(exist_ok=True)
    sandbox.WINDOW = tuple(map(str, SIZE))
    out = sandbox.RESULTS / "listing"
    shutil.rmtree(out, ignore_errors=True)
    sandbox.run_in_window("listing.py", out, {"W2W_RUN": sandbox.inside(RUN)})
    for name in PREVIEWS:
        Image.open(out / "pictures" / f"{name}.png").convert("RGB").save(
            RELEASE / f"{name}.png", optimize=True
        )
    bodies = _trimmed(Image.open(RUN / "heatmaps" / "mean.png").convert("RGB"))
    _featured(bodies).save(RELEASE / "featured.png", optimize=True)
    _icon(bodies).save(RELEASE / "icon.png", optimize=True)


def _trimmed(picture: Image.Image) -> Image.Image:
    """A picture without the paper around it."""
    return picture.crop(ImageChops.difference(picture, Image.new("RGB", picture.size, PAPER)).getbbox())


def _featured(bodies: Image.Image) -> Image.Image:
    """The demo's heatmap under the question that it answers."""
    image = Image.new("RGB", SIZE, PAPER)
    draw, font = ImageDraw.Draw(image), _font(84)
    draw.text((SIZE[0] / 2, 110), "Where should the sensor sit?", INK, font, anchor="mm")
    room = (SIZE[0] - 160, SIZE[1] - 260)
    scale = min(room[0] / bodies.width, room[1] / bodies.height)
    fitted = bodies.resize(
        (round(bodies.width * scale), round(bodies.height * scale)), Image.Resampling.LANCZOS
    )
    image.paste(fitted, ((SIZE[0] - fitted.width) // 2, 200 + (room[1] - fitted.height) // 2))
    return image


def _icon(bodies: Image.Image) -> Image.Image:
    """The body from the front, on transparent ground."""
    front = bodies.crop((0, bodies.height // 6, round(0.42 * bodies.width), bodies.height))
    distance = ImageChops.difference(front, Image.new("RGB", front.size, PAPER)).convert("L")
    front = front.convert("RGBA")
    front.putalpha(distance.point(lambda value: 255 if value > 12 else 0))
    front = front.crop(front.getbbox())
    side = max(front.size)
    square = Image.new("RGBA", (side, side))
    square.paste(front, ((side - front.width) // 2, (side - front.height) // 2))
    return square.resize((256, 256), Image.Resampling.LANCZOS)


def _font(size: int) -> ImageFont.FreeTypeFont:
    from matplotlib import font_manager

    return ImageFont.truetype(font_manager.findfont("DejaVu Sans:bold"), size)


if __name__ == "__main__":
    main()
