# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of worn sensors: put together by clip and place, from arrays, tables and folders."""

import numpy as np
import pytest

from w2w.core.imu.clock import at_rate
from w2w.core.imu.formats import write_recording
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.recordings import Recordings

from ...phone_exports import GRAVITY, right


def one(place, clip, samples=20, rate=50.0, activity="walking", subject="Ada", level=1.0):
    acc = np.full((samples, 1, 3), level)
    return ImuRecording(acc, 2 * acc, rate, (place,), activity, subject, clip)


class Table(dict):
    """What a table of pandas has of which W2W takes note: columns by name, and as many rows as it is long."""

    def __init__(self, rows):
        self.rows, self.columns = len(rows), list(rows[0])
        super().__init__({name: [row[name] for row in rows] for name in rows[0]})

    def __setitem__(self, name, values):
        super().__setitem__(name, values)
        self.columns = list(self)

    def __len__(self):
        return self.rows


def test_sensors_of_a_clip_become_one_recording_cut_to_the_shortest():
    found = Recordings([one("wrist", "a"), one("My Pocket", "a", samples=15, level=3.0)])
    assert found.places == ("wrist", "My Pocket")
    (recording,) = found
    assert recording.n_samples == 15
    assert (recording.activity, recording.subject, recording.clip) == ("walking", "Ada", "a")
    np.testing.assert_array_equal(recording.acc[0, :, 0], [1.0, 3.0])
    np.testing.assert_array_equal(recording.gyr[0, :, 0], [2.0, 6.0])


def test_a_place_that_comes_again_begins_a_new_stretch_of_its_clip():
    found = Recordings([one("wrist", "a"), one("belt", "a"), one("wrist", "a", 9), one("belt", "a", 9)])
    assert [(recording.clip, recording.n_samples) for recording in found] == [("a", 20), ("a", 9)]


def test_what_was_not_worn_is_nan_and_said():
    found = Recordings([one("wrist", "a"), one("belt", "a"), one("WRIST ", "b")])
    assert found.places == ("wrist", "belt")
    assert np.isnan(found[1].acc[:, 1]).all()
    assert found.lacking() == {"b": ("belt",)}
    assert found.at("wrist").lacking() == {}
    assert [recording.clip for recording in found.at("Belt")] == ["a"]
    assert len(found[:1]) == 1


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ([], "there is no recording"),
        (["walk.csv"], "give a list of ImuRecording"),
        ([one("wrist", "a", activity="")], "a has no activity"),
        ([one("wrist", "a").labelled((), "walking", "", "a")], "does not say where its sensors were worn"),
        ([one("wrist", "a"), one("belt", "a", rate=100)], "a has 100 samples per second and a 50: bring all"),
        (
            [one("wrist", "a"), one("belt", "a", activity="running")],
            "more than one activity: running and walking",
        ),
    ],
)
def test_what_does_not_fit_is_said(given, why):
    with pytest.raises(ValueError, match=why):
        Recordings(given)


def test_arrays_by_place():
    values = np.arange(60.0).reshape(10, 6)
    worn = {"wrist": [values, values], "belt": [None, values + 1]}
    found = Recordings.from_arrays(worn, 50, ["still", "waving"], ["Ada", "Bob"])
    np.testing.assert_array_equal(found[0].acc[:, 0], values[:, :3])
    np.testing.assert_array_equal(found[1].gyr[:, 1], values[:, 3:] + 1)
    assert [(r.activity, r.subject, r.clip) for r in found] == [
        ("still", "Ada", "recording 1"),
        ("waving", "Bob", "recording 2"),
    ]
    with pytest.raises(ValueError, match=r"recording 1 at wrist must have shape \(T, 6\), not \(10, 3\)"):
        Recordings.from_arrays({"wrist": [values[:, :3]]}, 50, ["still"])
    with pytest.raises(ValueError, match="wrist has 1 entries for 2 activities"):
        Recordings.from_arrays({"wrist": [values]}, 50, ["still", "waving"])
    with pytest.raises(ValueError, match="places are given as"):
        Recordings.from_arrays([values], 50, ["still"])


VALUES = np.zeros((10, 6))


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"activities": "walking"}, "activities must be a list with an entry per recording"),
        ({"activities": None}, "activities must be a list"),
        ({"subjects": 3}, "subjects must be a list"),
        ({"places": {"wrist": 3}}, "wrist must be a list"),
        ({"places": {"wrist": ["a.csv", VALUES]}}, "recording 1 at wrist must be an array of numbers"),
        ({"places": {"": [VALUES, VALUES]}}, "does not say where its sensors were worn"),
        ({"rate": None}, "the sample rate must be positive"),
        ({"rate": "fast"}, "the sample rate must be positive, not 'fast'"),
    ],
)
def test_what_are_no_arrays_is_said(given, why):
    usual = {"places": {"wrist": [VALUES, VALUES]}, "rate": 50, "activities": ["still", "waving"]}
    with pytest.raises(ValueError, match=why):
        Recordings.from_arrays(**usual | given)


@pytest.mark.parametrize(
    ("column", "value", "why"),
    [
        ("t", "noon", "the column t must be an array of numbers"),
        ("t", float("nan"), "the column t lacks the time of some rows"),
        ("t", 0.5, "by default the steps of t say them"),
        ("acc_x", "a", "the column acc_x must be an array of numbers"),
        ("acc", 3.0, "three numbers a row"),
        ("activity", float("nan"), "has no activity"),
        ("place", None, "does not say where its sensors were worn"),
    ],
)
def test_what_is_no_table_of_samples_is_said(column, value, why):
    row = {"place": "wrist", "clip": "a", "activity": "still", "acc_x": 0.0, "acc_y": 0.0, "acc_z": 9.8}
    rows = [{**row, "t": number / 50, column: value} for number in range(10)]
    with pytest.raises(ValueError, match=why):
        Recordings.from_frame(Table(rows))


def test_recordings_are_taken_by_number():
    found = Recordings([one("wrist", "a"), one("wrist", "b")])
    with pytest.raises(ValueError, match="by number or slice, such as"):
        found["a"]
    with pytest.raises(ValueError, match="name a place at least; there are wrist"):
        found.at()
    assert found.at("wrist", "Wrist").places == ("wrist",)


def test_a_table_is_brought_to_one_clock():
    """A sensor that starts later and one that lost samples: on the shared clock, a ramp stays a ramp."""
    rows = []
    for place, start, lost in (("wrist", 0.0, range(0)), ("belt", 0.103, range(40, 60))):
        for number in range(100):
            t = start + number / 50
            if number not in lost:
                acc = dict.fromkeys(("acc_x", "acc_y", "acc_z"), t)
                rows.append({"place": place, "clip": "a", "t": t, "activity": "walking"} | acc)
    (recording,) = Recordings.from_frame(Table(rows))
    assert recording.rate == 50
    expected = 0.103 + recording.time
    np.testing.assert_allclose(recording.acc[:, 0, 0], expected, atol=1e-5)
    lost = np.isnan(recording.acc[:, 1, 0])
    np.testing.assert_allclose(recording.acc[~lost, 1, 0], expected[~lost], atol=1e-5)
    assert 15 < lost.sum() < 25
    assert not recording.gyr[~lost].any()  # a table without angular velocity
    triples = Table([{name: row[name] for name in ("place", "clip", "t", "activity")} for row in rows])
    triples["acc"] = [[row["acc_x"]] * 3 for row in rows]
    np.testing.assert_array_equal(Recordings.from_frame(triples)[0].acc, recording.acc)
    with pytest.raises(ValueError, match="lacks the columns place, activity"):
        Recordings.from_frame(Table([{"clip": "a", "t": 0.0}]))


@pytest.mark.parametrize(
    ("kind", "ending"), [("npz", ".npz"), ("csv", ".csv"), ("xsens", ".txt"), ("x-io", "")]
)
def test_a_folder_says_activity_clip_and_place(tmp_path, kind, ending):
    for activity in ("walking", "sitting"):
        for place in ("wrist", "belt"):
            path = tmp_path / activity / "clip 1" / f"{place}{ending}"
            path.parent.mkdir(parents=True, exist_ok=True)
            write_recording(path, one(place, "").labelled((), "", "", ""), kind)
    found = Recordings.read(tmp_path)
    assert [(r.activity, r.clip) for r in found] == [
        ("sitting", "sitting/clip 1"),
        ("walking", "walking/clip 1"),
    ]
    assert set(found.places) == {"wrist", "belt"}
    assert found.lacking() == {}


def test_a_csv_labels_files_or_folders_and_what_is_damaged_is_skipped(tmp_path):
    for name in ("w1/left.csv", "w1/right.csv", "s1.csv", "other.csv"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        write_recording(tmp_path / name, one("x", "").labelled((), "", "", ""))
    (tmp_path / "w1" / "broken.csv").write_text("no recording")
    labels = tmp_path / "labels.csv"
    labels.write_text("file,activity,subject,clip,place\nw1,walking,Ada,,\ns1.csv,sitting,Bob,seat,left\n")
    found = Recordings.read(tmp_path)
    assert [(r.activity, r.subject, r.clip) for r in found] == [
        ("sitting", "Bob", "seat"),
        ("walking", "Ada", "w1"),
    ]
    assert found.places == ("left", "right")
    assert ("other.csv", "the labels do not list it") in found.skipped
    assert "w1/broken.csv" in dict(found.skipped)


def test_a_folder_without_recordings_is_refused(tmp_path):
    with pytest.raises(ValueError, match="is no folder of recordings"):
        Recordings.read(tmp_path / "nowhere")
    with pytest.raises(ValueError, match="can be used: it holds no"):
        Recordings.read(tmp_path)
    write_recording(tmp_path / "wrist.csv", one("wrist", "").labelled((), "", "", ""))
    with pytest.raises(ValueError, match="nothing says its activity"):
        Recordings.read(tmp_path)


def test_paths_say_activity_and_person_of_phones_files_which_are_cut_at_their_ends(tmp_path):
    write = right()["toolbox g-force, gyroscope"][0]
    for name in ("Ada/walking fast", "Ada/walking 2", "walking_Ben_3", "Cy/day 1/sitting"):
        write(tmp_path / name).rename(tmp_path / f"{name}.csv")
    (tmp_path / "Cy" / "day 1" / "sitting").rmdir()
    found = Recordings.read(tmp_path, place="left wrist", activities=("walking", "walking fast", "sitting"))
    assert {(one.activity, one.subject) for one in found} == {
        ("walking fast", "Ada"), ("walking", "Ada"), ("sitting", "day 1"), ("walking", "ben"),
    }  # fmt: skip
    assert found.places == ("left wrist",)
    assert len({one.clip for one in found}) == 4


def test_paths_that_name_two_activities_or_none_are_refused(tmp_path):
    write = right()["toolbox g-force"][0]
    write(tmp_path / "walking").rename(tmp_path / "walking" / "sitting.csv")
    write(tmp_path / "b").rename(tmp_path / "b" / "pocket.csv")
    with pytest.raises(ValueError, match="no recording"):
        Recordings.read(tmp_path, place="left wrist", activities=("walking", "sitting"))


def test_a_csv_of_times_labels_stretches_and_rates_become_one(tmp_path):
    right()["logger, Android"][0](tmp_path / "Ada")
    (tmp_path / "labels.csv").write_text(
        "file,activity,subject,place,start,end\nAda,walking,Ada,belt,0,5\nAda,sitting,Ada,belt,7,\n"
    )
    found = Recordings.read(tmp_path, rate=25)
    assert [(one.activity, round(one.n_samples / one.rate)) for one in found] == [
        ("walking", 5),
        ("sitting", 5),
    ]
    assert found.rate == 25
    np.testing.assert_allclose(found[0].acc[20:100, 0, 2], GRAVITY[40:200:2, 2], atol=2.5)
    assert len({one.clip for one in found}) == 2


def test_lost_samples_stay_lost_at_another_rate():
    acc = np.ones((200, 1, 3))
    acc[60:100] = np.nan
    found = at_rate(ImuRecording(acc, np.zeros_like(acc), 100.0, ("belt",)), 50.0)
    assert np.isnan(found.acc[:, 0, 0]).sum() == 20
    np.testing.assert_allclose(found.acc[~np.isnan(found.acc)], 1.0, atol=1e-6)
