# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies of every kind are found beside their originals; labels by chance need clips enough."""

import re

from tests.command_line import cli
from w2w_studies.commands.study_copies import KINDS


def test_copies_of_every_kind_are_found(motions):
    code, said = cli("study", "copies", motions)
    assert code == 0
    assert said.startswith("8 clips, 8 motions")
    for kind in KINDS:
        (share,) = re.findall(rf"(?:^| ){re.escape(kind)} ([\d.]+) of 8", said)
        if kind not in ("15 % faster", "30 % faster"):
            assert float(share) > 0.7, kind


def test_a_test_by_chance_of_few_clips_is_refused(motions):
    code, said = cli("study", "copies", motions, "--chance")
    assert code == 2
    assert said == "--chance needs 36 clips of 1.5 s or more; there are 8"
