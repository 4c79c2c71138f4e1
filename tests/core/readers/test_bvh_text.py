# SPDX-License-Identifier: GPL-3.0-or-later
"""BVH files whose header and frames disagree, or that say no frame rate, are refused with the numbers."""

import numpy as np
import pytest

from w2w.core.motion.source import UnusableMotion
from w2w.core.readers.bvh_text import LINES_AT_ONCE, read_bvh_text

from ...made_bvh import ONE_JOINT as SKELETON

BVH = "bvh/bandai_namco/dataset-2_raise-up-left-hand_active_001.bvh"
HEADER = "MOTION\nFrames: 3\nFrame Time: 0.0333\n"
ROWS = "0 0 0 1 2 3\n" * 3
WHOLE = SKELETON + HEADER + ROWS


def reason(path, content):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(UnusableMotion) as said:
        read_bvh_text(path)
    return str(said.value)


@pytest.mark.parametrize(
    "content",
    [
        WHOLE,
        WHOLE.replace("\n", "\r\n"),
        WHOLE.replace("\n", "\r"),
        WHOLE.replace("\n", "\n\n") + "\n \n\n",
        WHOLE.rstrip(),
        WHOLE.replace("MOTION", "motion").replace("Frames", "FRAMES").replace("Hips", "Hüfte"),
        WHOLE.replace("0.0333", "3.33e-2").replace("0 10 0", "0 1E1 +0").replace("1 2 3", "+1 .2e1 300E-2"),
        WHOLE.replace(" ", "\t"),
        WHOLE.replace("\n{", " {"),
        WHOLE.replace("0 10 0\n  }\n}", "0 10 0 } }"),
        "\ufeff" + WHOLE,
    ],
    ids=[
        "plain", "Windows", "old Mac", "blank lines", "no last line end", "other cases", "exponent", "tabs",
        "brace behind the name", "braces behind the offset", "byte order mark",
    ],
)  # fmt: skip
def test_whole_files_are_read(tmp_path, content):
    (tmp_path / "walk.bvh").write_bytes(content.encode())
    found = read_bvh_text(tmp_path / "walk.bvh")
    (joint,) = found.joints
    assert (joint.parent, joint.offset, len(joint.channels)) == (-1, (0, 0, 0), 6)
    assert found.rate == 1 / 0.0333
    np.testing.assert_array_equal(found.values, [[0, 0, 0, 1, 2, 3]] * 3)


def long_file(lines, blank=""):
    head = SKELETON + HEADER.replace("Frames: 3", f"Frames: {len(lines)}")
    return head + blank.join(f"{line}\n" for line in lines)


@pytest.mark.parametrize("blank", ["", "\n", "\n \n" * LINES_AT_ONCE], ids=["close", "spaced", "far apart"])
@pytest.mark.parametrize("odd", ["5", "+.5e1", "0_5"])
def test_every_number_of_a_long_file(tmp_path, blank, odd):
    values = np.random.default_rng(0).normal(0, 100, (LINES_AT_ONCE + 3, 6))
    values[-2, 3] = 5
    lines = [" ".join(map(repr, row)) for row in values.tolist()]
    lines[-2] = lines[-2].replace(" 5.0 ", f" {odd} ")
    (tmp_path / "walk.bvh").write_text(long_file(lines, blank))
    np.testing.assert_array_equal(read_bvh_text(tmp_path / "walk.bvh").values, values)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("0 0 0 1 2", "holds 5 numbers, and its skeleton has 6 channels"),
        ("0 0 0 1 2 3 4", "holds 7 numbers, and its skeleton has 6 channels"),
        ("0 0 0 1 2 3;", "holds '3;' where a number"),
        ("0 0 0 1 2 0x1p3", "holds '0x1p3' where a number"),
    ],
)
@pytest.mark.parametrize("at", [0, LINES_AT_ONCE - 1, LINES_AT_ONCE])
def test_damage_in_a_long_file_is_told_with_its_line(tmp_path, at, line, said):
    lines = ["0 0 0 1 2 3"] * (LINES_AT_ONCE + 3)
    lines[at] = line
    first = (SKELETON + HEADER).count("\n") + 1
    found = reason(tmp_path / "walk.bvh", long_file(lines))
    assert found.startswith(f"it is damaged: line {first + at} {said}")


@pytest.mark.later
def test_every_real_file_passes_but_the_broken_one(shared_data):
    refused = {}
    files = sorted((shared_data / "bvh").rglob("*.bvh"))
    for path in files:
        try:
            read_bvh_text(path)
        except UnusableMotion as error:
            refused[path.name] = str(error)
    assert len(files) > 70
    assert refused == {"kick.bvh": "it is damaged: its skeleton opens 7 braces and closes 12"}


@pytest.mark.parametrize("time", ["0", "0.0", "-0.0333", "nan", "inf", "-inf", "soon"])
def test_a_frame_time_that_gives_no_rate(tmp_path, time):
    said = reason(tmp_path / "walk.bvh", WHOLE.replace("0.0333", time))
    assert said.startswith(
        f"its frame time is '{time}', which gives no frame rate: write the seconds from one"
    )


@pytest.mark.parametrize(
    ("time", "rate"),
    [("1e-9", "1e+09"), ("0.0001", "1e+04"), ("33.3", "0.03003"), ("1.000000", "1"), ("1e308", "1e-308")],
)
def test_a_frame_time_beyond_reason(tmp_path, time, rate):
    assert reason(tmp_path / "walk.bvh", WHOLE.replace("0.0333", time)) == (
        f"its frame time of {time} s means {rate} frames a second; motions have 5 to 2,000: give the "
        "true rate (--pose-rate, or a column 'rate' in labels.csv)"
    )


def test_a_default_of_one_second_a_frame_is_asked_about(shared_cases):
    path = shared_cases / "second/frame_time_of_one_second.bvh"
    with pytest.raises(UnusableMotion, match=r"^its frame time of 1.000000 s means 1 frames a second"):
        read_bvh_text(path)
    assert read_bvh_text(path, 30.0).rate == 30
    assert read_bvh_text(path, 1.0).rate == 1  # whoever says so is believed


@pytest.mark.parametrize(
    ("line", "instead", "said"),
    [
        ("Frame Time: 0.0333", "", "does not say its frame rate: '0 0 0 1 2 3' stands where a line such as"),
        (
            "Frame Time: 0.0333",
            "Frame Time:0.0333",
            "'Frame Time:0.0333' stands where a line such as 'Frame T",
        ),
        ("Frames: 3", "Frames: three", "does not say how many frames it has: 'Frames: three' stands"),
        ("Frames: 3", "Frames: -3", "does not say how many frames it has"),
        ("Frames: 3", "Frames: 3.0", "does not say how many frames it has"),
    ],
)
def test_a_header_that_cannot_be_understood(tmp_path, line, instead, said):
    assert said in reason(tmp_path / "walk.bvh", WHOLE.replace(line, instead))


@pytest.mark.parametrize(
    ("promised", "rows", "said"),
    [
        (69, 29, "promises 69 frames, and it holds 29"),
        (1_000_000_000, 69, "promises 1,000,000,000 frames, and it holds 69"),
        (29, 69, "promises 29 frames, and it holds 69"),
        (1, 0, "promises 1 frame, and it holds 0"),
        (0, 3, "promises 0 frames, and it holds 3"),
    ],
)
def test_a_header_that_promises_more_or_less(tmp_path, promised, rows, said):
    text = WHOLE.replace("Frames: 3", f"Frames: {promised}").replace(ROWS, "0 0 0 1 2 3\n" * rows)
    told = reason(tmp_path / "walk.bvh", text)
    assert said in told
    assert told.endswith("export it again, or correct its 'Frames' line")


def test_a_number_of_frames_that_never_ends(tmp_path):
    assert "promises 999" in reason(
        tmp_path / "walk.bvh", WHOLE.replace("Frames: 3", f"Frames: {'9' * 9999}")
    )


def test_a_real_file_cut_short(shared_data, tmp_path):
    lines = (shared_data / BVH).read_text().splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith("Frame Time"))
    promised = len(lines) - start - 1
    assert f"promises {promised} frames, and it holds 29" in reason(
        tmp_path / "cut.bvh", "\n".join(lines[: start + 30])
    )
    middle = "\n".join(lines[: start + 30])
    middle = middle[: middle.rindex(" ", 0, len(middle) - 200)]
    assert f"line {start + 30} holds" in reason(tmp_path / "cut.bvh", middle)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("0 0 0 1 2 3\n", "0 0 0 1 2\n", "line 14 holds 5 numbers, and its skeleton has 6 channels"),
        ("0 0 0 1 2 3\n", "0 0 0 1 2 3 4\n", "line 14 holds 7 numbers, and its skeleton has 6 channels"),
        ("0 0 0 1 2 3\n", "0 0 0 1 x2 3\n", "line 14 holds 'x2' where a number should stand"),
        ("0 0 0 1 2 3\n", "0 0 0 1 2\0 3\n", r"line 14 holds '2\x00' where a number should stand"),
        ("0 10 0", "0 ten 0", "line 8 holds 'ten' where a number should stand"),
        ("0 10 0", "0 1e11 0", "(NaN, infinite or beyond 1e10)"),
        ("CHANNELS 6", "CHANNELS 5", "line 5 says '5' channels and names 6"),
        ("MOTION", "MOTIONS", "no MOTION follows its skeleton"),
        ("ROOT", "ROT", "line 2 holds 'ROT Hips' where no such line belongs"),
        ("  OFFSET 0 0 0\n", "", "its joint 'Hips' (line 2) has no OFFSET"),
        ("0 10 0", "0 10", "line 8 gives an offset of 2 numbers, and one has 3"),
        ("Zrotation", "Zrotatiom", "line 5 names the channel 'Zrotatiom', not one such as Xposition"),
        ("Zrotation", "Xrotation", "line 5 names the channel 'Xrotation' a second time"),
        ("ROOT Hips\n{", "{\nROOT Hips", "line 2 holds '{' where no such line belongs"),
        ("End Site\n  {", "{\n  End Site", "line 6 holds '{' where no such line belongs"),
    ],
)
def test_damage_is_told_with_its_line(tmp_path, old, new, said):
    assert said in reason(tmp_path / "walk.bvh", WHOLE.replace(old, new, 1))


def test_bytes_that_are_no_utf8(tmp_path):
    assert "not UTF-8 text" in reason(tmp_path / "walk.bvh", WHOLE.replace("Hips", "Hüfte").encode("latin-1"))
    assert "does not begin with HIERARCHY" in reason(tmp_path / "walk.bvh", WHOLE.encode("utf-16"))


def test_a_file_without_joints(tmp_path):
    assert "its skeleton has no joint" in reason(tmp_path / "walk.bvh", "HIERARCHY\n" + HEADER)


@pytest.mark.slow
def test_what_has_no_end_is_given_up_early(tmp_path):
    """A skeleton that goes on for ever, and a row as long as the file: neither is taken apart first."""
    assert "too large to be one" in reason(tmp_path / "walk.bvh", "HIERARCHY\n" + "ROOT a\n" * 700_000)
    endless = WHOLE.replace(ROWS, "0 " * 1_000_000)
    assert "line 14 holds 1000000 numbers" in reason(tmp_path / "walk.bvh", endless)


def test_more_frames_than_fit_are_refused_before_they_are_kept(tmp_path, monkeypatch):
    monkeypatch.setattr("w2w.core.readers.bvh_text.MOST_BONE_FRAMES", 2)
    monkeypatch.setattr("w2w.core.motion.source.MOST_BONE_FRAMES", 2)
    said = reason(tmp_path / "walk.bvh", WHOLE.replace("Frames: 3", "Frames: 70"))
    assert said.startswith("it is too long to be read at once (70 frames of 1 bones)")


def test_names_with_spaces_and_names_that_stand_twice(tmp_path):
    joint = "JOINT Left  Arm\n{\nOFFSET 1 2 3\nCHANNELS 1 Xrotation\n}\n"
    text = SKELETON.replace("  End Site", joint * 3 + "  End Site") + HEADER + "0 0 0 1 2 3 4 5 6\n" * 3
    (tmp_path / "walk.bvh").write_text(text)
    joints = read_bvh_text(tmp_path / "walk.bvh").joints
    assert [joint.name for joint in joints] == ["Hips", "Left_Arm", "Left_Arm.001", "Left_Arm.002"]
    assert [joint.parent for joint in joints] == [-1, 0, 0, 0]
    assert [joint.offset for joint in joints[1:]] == [(1, 2, 3)] * 3
