# SPDX-License-Identifier: GPL-3.0-or-later
"""Claims about parts of the body: true ones are supported, false ones contradicted, noise decides nothing."""

import numpy as np
import pytest

from w2w.core.body.body import Body
from w2w.core.patches.patches import sample_patches
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import utility_map
from w2w_studies.placements.activity_groups import PAPER_GROUPS
from w2w_studies.placements.trends import (
    CONTRADICTED,
    SUPPORTED,
    UNDECIDED,
    Claim,
    check_claims,
    judge,
    read_claims,
    sides_of,
)

NAMES = ("nod", "wave", "hop", "kick")
GROUPS = {"nod": "gesture", "wave": "gesture", "hop": "step", "kick": "step"}
CLAIMS = [
    Claim("Gestures are told at the arms", "gesture", ("arm",), ()),
    Claim("Gestures are told at the legs", "gesture", ("leg",), ("arm",)),
    Claim("Steps are told at the legs", "step", ("leg", "foot"), ("arm",)),
    Claim("Steps are told on the right", "step", ("right leg",), ("left leg",)),
    Claim("Everything is told at the head", "", ("head",), ("torso",)),
    Claim("Steps are told at the torso", "step", ("torso",), ("head",)),
]


@pytest.fixture(scope="module")
def patches():
    return sample_patches(Body.bundled(), 40)


def ranked(patches, seed=0, clips=6, shuffled=False):
    """Gestures move the arms, steps the legs; head and torso move by chance."""
    rng = np.random.default_rng(seed)
    clip = np.repeat(np.arange(4 * clips), 3)
    activity = np.repeat(np.arange(4), 3 * clips)
    features = rng.normal(size=(len(clip), len(patches), 4))
    features += rng.normal(size=(4 * clips, len(patches), 4))[clip]
    arm, leg = (sides_of(Claim("", "", words, ()), patches)[0] for words in (("arm",), ("leg",)))
    side = np.where(activity % 2, 2.5, -2.5)
    features[:, arm, 0] += np.where(activity < 2, side, 0)[:, None]
    features[:, leg, 0] += np.where(activity >= 2, side, 0)[:, None]
    if shuffled:
        activity = rng.permutation(np.repeat(np.arange(4), clips))[clip]
    every = np.ones(len(clip), dtype=bool)
    names = np.array(NAMES)[activity]
    return utility_map(
        features.astype(np.float32), CrossValidation(names, clip, None, every, NAMES), resamples=2, halvings=0
    )


def test_what_is_so_is_supported_and_the_contrary_contradicted(patches):
    trends = judge(ranked(patches), patches, CLAIMS, GROUPS)
    assert [trend.verdict for trend in trends] == [
        SUPPORTED, CONTRADICTED, SUPPORTED, UNDECIDED, UNDECIDED, UNDECIDED,
    ]  # fmt: skip
    for trend in trends:
        assert trend.difference == pytest.approx(trend.f1 - trend.other_f1)
        assert trend.low < trend.difference < trend.high
    assert (trends[0].clips, trends[0].activities) == (12, 2)
    assert (trends[4].clips, trends[4].activities) == (24, 4)
    turned = judge(ranked(patches), patches, [Claim("", "gesture", ("arm",), ("leg",))], GROUPS)[0]
    assert turned.difference == pytest.approx(-trends[1].difference)


@pytest.mark.slow
@pytest.mark.parametrize("clips", [3, 8])
def test_shuffled_labels_support_nothing_more_often_than_chance(patches, clips):
    """Of twenty libraries about one may decide one of its claims."""
    decided = [
        any(
            trend.verdict != UNDECIDED
            for trend in judge(ranked(patches, seed, clips, shuffled=True), patches, CLAIMS, GROUPS)
        )
        for seed in range(40)
    ]
    assert sum(decided) <= 5  # of 40 at .05 more come once in a hundred times


def test_too_few_clips_or_no_patch_leave_a_claim_undecided(patches):
    utility = ranked(patches)
    claims = [Claim("a", "none", ("arm",), ()), Claim("b", "step", ("leg",), ("leg",))]
    few, nowhere = judge(utility, patches, claims, GROUPS)
    assert (few.verdict, few.why, few.clips) == (UNDECIDED, "too few clips", 0)
    assert (nowhere.verdict, nowhere.why) == (UNDECIDED, "no patch lies there")
    assert np.isnan(few.difference)


def test_claims_are_read_and_checked(tmp_path):
    file, body = tmp_path / "claims.csv", Body.bundled()
    file.write_text(
        "claim;group;regions;against\n"
        'Carrying tips the trunk;asymmetric;"lower spine; waist";wrist\n'
        "Nothing beats the foot;;foot;\n"
    )
    claims = read_claims(file)
    assert claims[0] == Claim("Carrying tips the trunk", "asymmetric", ("lower spine", "waist"), ("wrist",))
    assert claims[1] == Claim("Nothing beats the foot", "", ("foot",), ())
    check_claims(claims, PAPER_GROUPS, body)
    with pytest.raises(ValueError, match="no group is called 'dance'; there are locomotion_posture"):
        check_claims([Claim("x", "dance", ("foot",), ())], PAPER_GROUPS, body)
    with pytest.raises(ValueError, match=r"claim 'x': .*tail"):
        check_claims([Claim("x", "", ("foot",), ("tail",))], PAPER_GROUPS, body)
    for text, message in (
        ("claim,regions\nx,\n", "line 2: a claim needs its sentence and its regions"),
        ("claim,regions\n", "holds no claim"),
        ("group\nx\n", "'claim' and 'regions'"),
    ):
        file.write_text(text)
        with pytest.raises(ValueError, match=message):
            read_claims(file)


def test_the_claims_that_come_with_w2w_can_be_judged():
    from w2w_studies.placements.placement_study import CLAIMS as FILE

    claims = read_claims(FILE)
    assert len(claims) == 13
    assert {claim.group for claim in claims} == {"", *PAPER_GROUPS}
    check_claims(claims, PAPER_GROUPS, Body.bundled())
