# SPDX-License-Identifier: GPL-3.0-or-later
"""BVH files whose header and frames disagree, or that say no frame rate, are refused with the numbers."""

import pytest

from w2w.core.motion.bvh_check import check_bvh
from w2w.core.motion.source import UnusableMotion

BVH = "bvh/bandai_namco/dataset-2_raise-up-left-hand_active_001.bvh"
SKELETON = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  End Site
  {
    OFFSET 0 10 0
  }
}
"""
HEADER = "MOTION\nFrames: 3\nFrame Time: 0.0333\n"
ROWS = "0 0 0 1 2 3\n" * 3
WHOLE = SKELETON + HEADER + ROWS


def reason(path, content):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(UnusableMotion) as said:
        check_bvh(path)
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
        WHOLE.replace("0.0333", "3.33e-2"),
    ],
    ids=["plain", "Windows", "old Mac", "blank lines", "no last line end", "other cases", "exponent"],
)
def test_whole_files_pass(tmp_path, content):
    (tmp_path / "walk.bvh").write_bytes(content.encode())
    check_bvh(tmp_path / "walk.bvh")


def test_every_real_file_passes_but_the_broken_one(shared_data):
    refused = {}
    files = sorted((shared_data / "bvh").rglob("*.bvh"))
    for path in files:
        try:
            check_bvh(path)
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
    ("time", "rate"), [("1e-9", "1e+09"), ("0.0001", "1e+04"), ("33.3", "0.03003"), ("1e308", "1e-308")]
)
def test_a_frame_time_beyond_reason(tmp_path, time, rate):
    assert reason(tmp_path / "walk.bvh", WHOLE.replace("0.0333", time)) == (
        f"its frame time of {time} s means {rate} frames a second; motions have 1 to 2,000: correct its "
        "'Frame Time' line"
    )


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
    ],
)
def test_damage_is_told_with_its_line(tmp_path, old, new, said):
    assert said in reason(tmp_path / "walk.bvh", WHOLE.replace(old, new, 1))


def test_bytes_that_are_no_utf8(tmp_path):
    assert "not UTF-8 text" in reason(tmp_path / "walk.bvh", WHOLE.replace("Hips", "Hüfte").encode("latin-1"))
    assert "byte order mark" in reason(tmp_path / "walk.bvh", WHOLE.encode("utf-8-sig"))
    assert "does not begin with HIERARCHY" in reason(tmp_path / "walk.bvh", WHOLE.encode("utf-16"))
