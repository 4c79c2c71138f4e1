# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of public libraries become one set of activities, with who moves where the name says so."""

import re
import tarfile
from collections import Counter

import pytest

from w2w_studies.validation.library_names import RULES
from w2w_studies.validation.protocol import first_rule


@pytest.mark.parametrize(
    ("file", "activity", "source", "who"),
    [
        ("hdm05/jog/bd_jogLeftCircle4StepsRstart_001.bvh", "run", "HDM05", "bd"),
        ("bandai_namco/dash/dataset-1_dash_active_001.bvh", "run", "Bandai-Namco", "active"),
        ("dataset-2_walk-turn-left_youthful_003.bvh", "turn left", "Bandai-Namco", "youthful"),
        ("mixamo/x/aj@Walking.fbx", "walk", "Mixamo", ""),
        ("mixamo/x/Walking (1).fbx", "walk", "Mixamo", ""),
        ("mixamo/x/Running Up Stairs.fbx", "climb stairs", "Mixamo", ""),
        ("bvh/cmu_JonathanAlderson/06_15.bvh", "dribble a ball", "CMU", "06"),
        ("bvh/cmu_DragonForged/007_12.bvh", "walk", "CMU", "07"),
        ("smpl_poses/hbertiche__NeuralClothSim/0000.npz", "run", "AMASS", ""),
    ],
)
def test_known_names(file, activity, source, who):
    rule, found = first_rule(RULES, file)
    assert (rule.activity, rule.source, found) == (activity, source, who)


@pytest.mark.parametrize(
    "file",
    ["my/Walking.bvh", "mixamo/T-Pose.fbx", "mixamo/Walking In The Rain.fbx", "truncated_50pct_Walking.fbx",
     "jog/zz_jog_001.bvh", "bandai_namco/dataset-1_respond_normal_001.bvh", "0000.npz"],
)  # fmt: skip
def test_other_names_are_nobodys(file):
    assert first_rule(RULES, file) == (None, "")


def test_no_rule_hides_another():
    patterns = [(rule.source, rule.pattern) for rule in RULES]
    assert len(set(patterns)) == len(patterns)
    for rule in RULES:
        assert re.compile(rule.pattern).groups >= 1


@pytest.mark.slow
def test_the_real_libraries_are_known_by_their_names(shared_data):
    known = Counter()
    for name in ("hdm05", "bandai_namco"):
        with tarfile.open(shared_data / "library" / f"{name}.tar.xz") as archive:
            files = [file for file in archive.getnames() if file.endswith(".bvh")]
        rules = [first_rule(RULES, f"{name}/{file}")[0] for file in files]
        assert None not in rules
        known.update(rule.activity for rule in rules)
    assert len(known) >= 27
    assert sum(count >= 20 for count in known.values()) >= 14
