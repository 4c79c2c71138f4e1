# SPDX-License-Identifier: GPL-3.0-or-later
"""Make `assets/templates/colour_maps.npz` of colour maps of the `cmap` package."""

from cmap import Colormap

from w2w.core.body.body import TEMPLATES
from w2w.core.colours import COLOUR_MAPS
from w2w.core.files import write_npz

if __name__ == "__main__":
    write_npz(
        TEMPLATES / "colour_maps.npz",
        {name: Colormap(name).lut(256)[:, :3].astype(float) for name in COLOUR_MAPS},
        compress=True,
    )
