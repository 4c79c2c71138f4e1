# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the README pictures from the demo results: `make demo && .venv/bin/python tools/make_pictures.py`."""

from __future__ import annotations

from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
WIDTH, COLOURS = 1400, 256


def main() -> None:
    """Shrink the demo's heatmaps to what a web page needs."""
    results, pictures = ROOT / "demo_output" / "results" / "heatmaps", ROOT / "docs" / "pictures"
    pictures.mkdir(parents=True, exist_ok=True)
    for name in ("mean", "subset"):
        with Image.open(results / f"{name}.png") as picture:
            height = round(picture.height * WIDTH / picture.width)
            small = picture.convert("RGB").resize((WIDTH, height), Image.Resampling.LANCZOS)
            small.quantize(COLOURS).save(pictures / f"demo_{name}.png", optimize=True)


if __name__ == "__main__":
    main()
