# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers survive a property of single precision."""

from __future__ import annotations

import numpy as np
import pytest

from w2w.ui.precision import as_given


@pytest.mark.parametrize("given", [1 / 3, 0.85, 1e-5, 60.0])
def test_a_number_that_was_not_touched_is_the_one_that_was_given(given: float) -> None:
    assert as_given(float(np.float32(given)), given) == given


def test_a_number_that_was_typed_is_the_one_that_was_typed() -> None:
    assert as_given(float(np.float32(0.7)), 1 / 3) == 0.7
    assert as_given(float(np.float32(2.125)), float("nan")) == 2.125
    assert as_given(float(np.float32(-64.3)), 66.8) == -64.3
