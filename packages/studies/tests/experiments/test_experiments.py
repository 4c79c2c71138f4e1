# SPDX-License-Identifier: GPL-3.0-or-later
"""Every experiment can still be started; what they measure is tested where the measured code is."""

from importlib import import_module
from pathlib import Path

import pytest

from w2w_studies import experiments


@pytest.mark.parametrize("name", sorted(path.stem for path in Path(experiments.__path__[0]).glob("[!_]*.py")))
def test_it_is_imported(name):
    import_module(f"{experiments.__name__}.{name}")
