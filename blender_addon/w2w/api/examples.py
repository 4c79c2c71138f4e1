# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W from Python: the demo's motions, without a file."""

from ..core.body.body import Body
from ..core.motion.examples import demo_motions
from .loading import Motions


def example_motions() -> Motions:
    """Motions that come with W2W: five gestures of eight people at a desk, the same as in `w2w demo`.

    Returns
    -------
    Motions
        Made by W2W's own generator; public domain (CC0).

    Examples
    --------
    >>> w2w.example_motions()
    <Motions: 40 of 5 activities, 0 files skipped>
    """
    motions = tuple(demo_motions().values())
    return Motions(motions, Body.bundled(), (), ("",) * len(motions), ({},) * len(motions))
