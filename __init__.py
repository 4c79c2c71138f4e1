# SPDX-License-Identifier: GPL-3.0-or-later
"""Door of the Blender extension: hands registration on to `w2w`.

A Python that is started beside a clone called `w2w` finds this file for `import w2w`, and gets the package.
"""

import sys

if __name__ == "w2w":
    from importlib.util import module_from_spec, spec_from_file_location
    from pathlib import Path

    _folder = Path(__file__).parent / "blender_addon" / "w2w"
    _spec = spec_from_file_location("w2w", _folder / "__init__.py", submodule_search_locations=[str(_folder)])
    sys.modules["w2w"] = module_from_spec(_spec)
    _spec.loader.exec_module(sys.modules["w2w"])
elif __package__:  # else it is pytest that looks in, from a folder whose name is no Python name
    from .blender_addon.w2w import register, unregister

    __all__ = ["register", "unregister"]
