# SPDX-License-Identifier: GPL-3.0-or-later
"""Door of the Blender extension: hands registration on to `w2w`, which lies among its wheels.

In the source tree the package is the folder beside this file. A Python that is started beside a clone called
`w2w` finds this file for `import w2w`, and gets the package.
"""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

WRONG = "This zip of W2W is not for this Blender: install the one whose name says its version ({})"
_TREE = Path(__file__).parent / "blender_addon" / "w2w"


def _load() -> None:
    """Make the package of the source tree `w2w`, where this is the tree."""
    if _TREE.is_dir():
        spec = spec_from_file_location("w2w", _TREE / "__init__.py", submodule_search_locations=[str(_TREE)])
        sys.modules["w2w"] = module_from_spec(spec)
        spec.loader.exec_module(sys.modules["w2w"])


if __name__ == "w2w":
    _load()
elif __package__:  # else it is pytest that looks in, from a folder whose name is no Python name

    def register() -> None:
        """Register with Blender, which knows the extension by this package's name."""
        for name in [name for name in sys.modules if name.partition(".")[0] == "w2w"]:
            del sys.modules[name]  # of the version before an update
        _load()
        try:
            import w2w
            import w2w.extension
        except ImportError as error:  # compiled libraries are for one Python
            raise ImportError(WRONG.format(error)) from error

        w2w.extension.NAME = __package__
        w2w.register()

    def unregister() -> None:
        """Take back what `register` did."""
        import w2w

        w2w.unregister()
