# SPDX-License-Identifier: GPL-3.0-or-later
"""Cut the pictures of docs/animator.md from the screenshots that tests/gui leaves in .cache.

tools/real_blender.sh && make extension && pytest tests/gui && python docs/make_animator_pictures.py
"""

from __future__ import annotations

from pathlib import Path

from PIL import Image

PROJECT = Path(__file__).resolve().parents[1]
SCREENSHOTS = PROJECT / ".cache" / "blender-4.3"
PICTURES = PROJECT / "docs" / "pictures"

VIEW = (0, 28, 1188, 904)
"""The 3D viewport with its sidebar, in pixels of the screenshot."""

SIDEBAR = (902, 80, 1162, 904)

CUTS = {
    "animator_shape": ("window/pictures/8_shape", VIEW),
    "animator_source_beside": ("window/pictures/2_source_beside", VIEW),
    "animator_motions": ("window/pictures/2_motions_problem", SIDEBAR),
    "animator_patches": ("window/pictures/3_patches", VIEW),
    "animator_heatmap": ("window/pictures/5_mean", VIEW),
    "animator_pick": ("window/pictures/6_compare", VIEW),
    "animator_two_maps": ("run/pictures/6_two_maps", VIEW),
    "animator_overnight": ("run/pictures/3_signals", VIEW),
}
"""Screenshot and cut of each picture."""

WIDTH = 960


def main() -> None:
    """Cut, scale down and compress."""
    for name, (screenshot, cut) in CUTS.items():
        picture = Image.open(SCREENSHOTS / f"{screenshot}.png").convert("RGB").crop(cut)
        if picture.width > WIDTH:
            picture = picture.resize(
                (WIDTH, round(picture.height * WIDTH / picture.width)), Image.Resampling.LANCZOS
            )
        path = PICTURES / f"{name}.png"
        picture.save(path, optimize=True)  # all colours: fewer would bend the colour maps
        print(f"{path.relative_to(PROJECT)}: {path.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
