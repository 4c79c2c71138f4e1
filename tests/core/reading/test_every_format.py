# SPDX-License-Identifier: GPL-3.0-or-later
"""What every reader must do; a format that is added without a whole file to try fails here."""

import re
from functools import partial
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

from w2w.core.body.body import JOINT_INDEX
from w2w.core.keypoints.facts import PoseFacts
from w2w.core.motion.examples import demo_motions
from w2w.core.motion.sight import UPS
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import UnusableMotion
from w2w.core.motion.up import Unasked
from w2w.core.reading.clips import Clip, How, open_clip
from w2w.core.reading.formats import FORMATS, formats_of
from w2w.core.reading.reader import Reader

from ...made_bvh import write_bvh
from ...robustness.formats import KINDS, whole_files
from ..readers.test_poselib import skeleton_motion

OURS = tuple(kind for kind in KINDS if formats_of(Path(f"a{kind}"))[0].read)
"""Suffixes of files that are read without Blender; other suffixes of a format are read alike."""

RATE = 25.0
NUMBER = re.compile(rb"-?\d+\.\d+")


@pytest.fixture(scope="module")
def reader():
    with Reader(60.0) as reader:
        yield reader


@pytest.fixture(scope="module")
def whole(bundled_body, tmp_path_factory):
    """Whole files of a person who moves, by their suffixes."""
    folder = tmp_path_factory.mktemp("whole")
    files = whole_files(folder, OURS)
    motion = next(iter(demo_motions(1).values()))
    write_bvh(folder / "whole.bvh", bundled_body, motion)
    files[".bvh"] = [(folder / "whole.bvh").read_bytes()]
    np.save(content := BytesIO(), np.array(skeleton_motion(bundled_body, motion, True), dtype=object))
    files[".npy"].append(content.getvalue())
    return files


def write(folder, kind, data):
    """A file of these bytes; before those of an AMC are its skeleton's."""
    *beside, data = data.split(b"SPLIT") if kind == ".amc" else [data]
    for content in beside:
        (folder / "07.asf").write_bytes(content)
    path = folder / f"whole{kind}"
    path.write_bytes(data)
    return path


def opened(reader, path, body, **facts):
    how = How(pose=PoseFacts(**{"rate": RATE} | facts), ups=Unasked())
    return reader.read(path, partial(open_clip, Clip(path, path.name, "", ""), body, how)).motion


def test_each_format_has_a_whole_file_to_try(whole, tmp_path):
    tried = set()
    for kind, files in whole.items():
        for data in files:
            path = write(tmp_path, kind, data)
            for each in formats_of(path):
                if each.holds and not each.holds(path):
                    continue
                if each.read(path, PoseFacts(rate=RATE), Unasked(), "") is not None:
                    tried.add(each.name)
                    break
    assert tried == {each.name for each in FORMATS if each.read}


@pytest.mark.parametrize("kind", OURS)
def test_a_given_rate_goes_before_that_of_the_file(whole, tmp_path, bundled_body, reader, kind):
    for data in whole[kind]:
        motion = opened(reader, write(tmp_path, kind, data), bundled_body)
        assert motion.rate == RATE
        assert motion.n_frames > RATE


@pytest.mark.parametrize("kind", OURS)
def test_a_given_axis_is_up_and_one_alone_is_right(whole, tmp_path, bundled_body, reader, kind):
    for data in whole[kind]:
        path, trunks = write(tmp_path, kind, data), {}
        for up in UPS:
            places = joint_transforms(bundled_body, opened(reader, path, bundled_body, up=up))[1]
            trunk = np.median(places[:, JOINT_INDEX["head"], 2] - places[:, 0, 2])
            trunks[up] = 0 if abs(trunk) < 0.35 else int(np.sign(trunk))
        (right,) = (up for up in UPS if trunks[up] > 0)
        (wrong,) = (up for up in UPS if trunks[up] < 0)
        assert {right, wrong} in [{axis, f"-{axis}"} for axis in "xyz"]


@pytest.mark.parametrize("kind", OURS)
def test_a_file_that_is_cut_short_is_refused_in_a_sentence_or_read_in_part(
    whole, tmp_path, bundled_body, reader, kind
):
    reasons = []
    for data in whole[kind]:
        full = opened(reader, write(tmp_path, kind, data), bundled_body).n_frames
        for part in (0.0, 0.1, 0.6, 0.95):
            skeleton, mark, content = data.rpartition(b"SPLIT") if kind == ".amc" else (b"", b"", data)
            path = write(tmp_path, kind, skeleton + mark + content[: int(part * len(content))])
            try:
                read = opened(reader, path, bundled_body).n_frames
            except UnusableMotion as error:
                reasons.append(str(error))
            else:
                assert read < full or part > 0.9  # no frame is made up
    assert reasons
    assert not [reason for reason in reasons if not reason or "W2W failed" in reason]


@pytest.mark.parametrize("kind", [kind for kind in OURS if kind not in (".pkl", ".c3d")])
def test_no_number_that_is_none_comes_through(whole, tmp_path, bundled_body, reader, kind):
    for data in whole[kind]:
        try:
            motion = opened(reader, write(tmp_path, kind, with_nan(kind, data)), bundled_body)
        except UnusableMotion:
            continue
        assert np.isfinite(motion.rotations).all()
        assert np.isfinite(motion.pelvis).all()


def with_nan(kind, data):
    """The same file with one number replaced by NaN."""
    if kind in (".npz", ".smpl", ".npy"):
        stored = np.load(BytesIO(data), allow_pickle=True)
        if isinstance(stored, np.ndarray) and stored.dtype == object:
            content = stored.item()
            content["root_translation"]["arr"][20, 1] = np.nan
            np.save(made := BytesIO(), np.array(content, dtype=object))
            return made.getvalue()
        if isinstance(stored, np.ndarray):
            stored[20, 3, 1] = np.nan
            np.save(made := BytesIO(), stored)
            return made.getvalue()
        arrays = dict(stored)
        name = max(arrays, key=lambda name: arrays[name].size)
        arrays[name].reshape(-1)[arrays[name].size // 2] = np.nan
        np.savez(made := BytesIO(), **arrays)
        return made.getvalue()
    found = list(NUMBER.finditer(data))
    one = found[int(0.8 * len(found))]
    return data[: one.start()] + b"nan" + data[one.end() :]
