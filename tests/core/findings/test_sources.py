# SPDX-License-Identifier: GPL-3.0-or-later
"""A caution where sources or people coincide with activities, and none where they do not."""

import csv

import pytest

from w2w.core.findings.sources import Origin, confined, source_caution, system_of

MIXAMO, CMU = system_of("Mixamo", 30.0), system_of("CMU", 120.0)


def clip(activity, system=MIXAMO, subject="", source="", folder=""):
    return Origin(activity, source, system, folder, subject)


def test_activities_of_two_systems_are_named_with_them():
    clips = [clip("sitting")] * 4 + [clip("walking", CMU)] * 5 + [clip("running", CMU)] * 2
    assert source_caution(clips) == (
        "the ranking may tell the sources of the clips apart, not the activities: running and walking come "
        "from CMU skeletons at 120 frames/s alone, sitting from Mixamo skeletons at 30 frames/s alone; take "
        "all activities from the same sources, or compare within each"
    )


@pytest.mark.parametrize("systems", [("Mixamo", 30, "CMU", 30), ("Mixamo", 30, "Mixamo", 120)])
def test_skeleton_or_rate_alone_tells_sources_apart(systems):
    first, second = system_of(*systems[:2]), system_of(*systems[2:])
    assert "sources" in source_caution([clip("sitting", first)] * 3 + [clip("walking", second)] * 3)


def test_frame_times_in_microseconds_are_one_rate():
    assert system_of("CMU", 1 / 0.008333) == system_of("CMU", 120.0)


def test_sources_that_show_the_same_activities_say_nothing():
    clips = [clip(name, system) for name in ("sitting", "walking") for system in (MIXAMO, CMU) for _ in "abc"]
    assert source_caution(clips) == ""
    assert source_caution([*clips, clip("walking", CMU)]) == ""


def test_one_stray_clip_hides_no_coincidence():
    clips = [clip("sitting")] * 9 + [clip("walking", CMU)] * 9 + [clip("walking")]
    assert "walking from CMU skeletons at 120 frames/s alone" in source_caution(clips)


def test_the_labels_own_sources_count_before_skeletons():
    one_rig = [clip("sitting", source="film")] * 3 + [clip("walking", source="studio")] * 3
    assert "sitting comes from film alone, walking from studio alone" in source_caution(one_rig)
    two_rigs = [
        clip(name, system, source="studio") for name, system in (("a", MIXAMO), ("b", CMU)) for _ in "xy"
    ]
    assert source_caution(two_rigs) == ""


def test_folders_count_where_each_shows_several_activities():
    def library(of):
        return [clip(name, folder=folder) for folder, names in of.items() for name in names for _ in "ab"]

    assert "a, b and c come from film alone, d and e from lab alone" in source_caution(
        library({"film": "abc", "lab": "de"})
    )
    assert (
        source_caution(library({"walking": ["walking"], "sitting": ["sitting"]})) == ""
    )  # folders are labels
    assert source_caution(library({"day 1": "abc", "day 2": "abc"})) == ""


def test_people_who_show_one_activity_each():
    clips = [clip(name, subject=f"{name}er") for name in ("sit", "walk", "run") for _ in range(4)]
    assert source_caution(clips).startswith("the ranking may tell people apart, not the activities: ")
    assert "sit comes from siter alone" in source_caution([one for one in clips if one.activity != "run"])
    several = [clip(name, subject=who) for name in ("sit", "walk", "run") for who in ("Ann", "Bob")]
    assert source_caution(several) == ""
    own = [clip(name, subject=f"{name} {number}") for name in ("sit", "walk") for number in range(4)]
    assert source_caution(own) == ""  # several people each: none of them is the activity
    assert source_caution([*clips, clip("sit")]) == ""  # of one clip nobody knows who moves


def test_an_activity_is_confined_where_half_of_the_others_are_strangers_and_not_where_fewer_are():
    halves = ["x", "x", "x", "y", "y"] * 2
    assert confined(list("abcde") * 2, halves) == dict(zip("abcde", halves[:5], strict=True))
    assert confined(list("abcde") * 2, ["x", "x", "x", "x", "y"] * 2) == {"e": "y"}
    assert confined(["a", "b"], ["x", "x"]) == {}


def test_many_are_counted_not_listed():
    clips = [clip(f"{system} {number}", system) for system in "pqrst" for number in range(5) for _ in "ab"]
    text = source_caution(clips)
    assert "p 0, p 1, p 2 and 2 more come from p alone, q 0, q 1, q 2 and 2 more from q alone" in text
    assert "and others from 2 more" in text


def test_real_libraries_of_one_source_raise_no_alarm_and_mixed_ones_do(shared_data):
    with (shared_data / "motions.csv").open(newline="", encoding="utf-8") as stream:
        rows = [row for row in csv.DictReader(stream) if row["fps"]]
    skeletons = {"bandai_namco": "Bandai-Namco", "cmu_JonathanAlderson": "CMU"}

    def shown(folder):
        return [
            clip(
                row["activity"],
                system_of(skeletons.get(row["file"].split("/")[1], "Mixamo"), float(row["fps"])),
            )
            for row in rows
            if row["file"].startswith(folder)
        ]

    assert source_caution(shown("bvh/bandai_namco")) == ""
    mixed = [*shown("bvh/bandai_namco"), *shown("bvh/cmu_Jonathan")]
    assert "dribbling comes from CMU skeletons at 120 frames/s alone" in source_caution(
        [one for one in mixed if one.activity in ("dribbling", "running", "bow", "waving")]
    )
