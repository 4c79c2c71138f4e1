# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of video pose estimators as their programs leave them: pickles of numpy, joblib and torch."""

import gzip
import io
import os
import pickle
import sys
from collections import OrderedDict
from types import ModuleType
from zipfile import ZIP_DEFLATED, ZipFile

import joblib
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.files import UNPACKED_FREELY
from w2w.core.keypoints.facts import PoseFacts
from w2w.core.library.library import is_motion
from w2w.core.motion.motion import read_amass
from w2w.core.motion.source import UnusableMotion
from w2w.core.reading.formats import read_motion

from ...rings import by_day

N_FRAMES = 40


@pytest.fixture(scope="module")
def poses():
    found = np.random.default_rng(0).normal(scale=0.2, size=(N_FRAMES, 72)).astype(np.float32)
    found[:, 66:] = 0
    return found


@pytest.fixture(scope="module")
def path():
    return np.cumsum(np.random.default_rng(1).normal(scale=0.02, size=(N_FRAMES, 3)), 0).astype(np.float32)


@pytest.fixture
def expected(tmp_path, poses, path):
    np.savez(tmp_path / "a.npz", global_orient=poses[:, :3], body_pose=poses[:, 3:66], transl=path, fps=30.0)
    return read_amass(tmp_path / "a.npz", up="y")


def same(found, expected):
    np.testing.assert_allclose(found.rotations, expected.rotations, atol=1e-6)
    np.testing.assert_allclose(found.pelvis, expected.pelvis, atol=1e-6)


class Tensor(np.ndarray):
    """An array that is pickled as torch pickles a tensor."""

    def __reduce_ex__(self, _protocol):
        torch = sys.modules["torch._utils"]
        stride = tuple(step // self.itemsize for step in self.strides)
        return torch._rebuild_tensor_v2, (Storage(self), 0, self.shape, stride, False, OrderedDict())


class Storage:
    def __init__(self, array):
        self.array = np.asarray(array)


@pytest.fixture
def torch_saved(monkeypatch):
    """A function that writes a zip as torch.save does, without torch."""
    utils, torch = ModuleType("torch._utils"), ModuleType("torch")
    utils._rebuild_tensor_v2 = lambda *_: None
    utils._rebuild_tensor_v2.__module__ = "torch._utils"
    utils._rebuild_tensor_v2.__qualname__ = utils._rebuild_tensor_v2.__name__ = "_rebuild_tensor_v2"
    torch.FloatStorage = type("FloatStorage", (), {"__module__": "torch"})
    monkeypatch.setitem(sys.modules, "torch", torch)
    monkeypatch.setitem(sys.modules, "torch._utils", utils)

    def save(file, content, cut=0):
        stored = []

        class Pickler(pickle.Pickler):
            def persistent_id(self, value):
                if not isinstance(value, Storage):
                    return None
                stored.append(value.array)
                return "storage", torch.FloatStorage, str(len(stored) - 1), "cuda:0", value.array.size

        buffer = io.BytesIO()
        Pickler(buffer, 2).dump(content)
        with ZipFile(file, "w") as archive:
            archive.writestr("hmr4d_results/data.pkl", buffer.getvalue())
            for number, array in enumerate(stored):
                data = array.astype("<f4").tobytes()
                archive.writestr(f"hmr4d_results/data/{number}", data[: len(data) - cut])

    return save


def as_tensor(array):
    return np.ascontiguousarray(array, dtype=np.float32).view(Tensor)


def gvhmr(poses, path):
    world = {"global_orient": poses[:, :3], "body_pose": poses[:, 3:66], "transl": path}
    camera = {"global_orient": -poses[:, :3], "body_pose": poses[:, 3:66], "transl": 2 * path}
    return {
        side: {name: as_tensor(array) for name, array in arrays.items()}
        for side, arrays in (("smpl_params_incam", camera), ("smpl_params_global", world))
    }


def test_gvhmr_in_the_world(tmp_path, poses, path, expected, torch_saved):
    torch_saved(tmp_path / "hmr4d_results.pt", gvhmr(poses, path))
    assert is_motion(tmp_path / "hmr4d_results.pt")
    same(read_amass(tmp_path / "hmr4d_results.pt", 30.0, "y"), expected)
    with pytest.raises(UnusableMotion, match="does not say its frame rate"):
        read_amass(tmp_path / "hmr4d_results.pt")


def test_a_tensor_beyond_its_storage_is_refused(tmp_path, poses, path, torch_saved):
    torch_saved(tmp_path / "a.pt", gvhmr(poses, path), cut=4)
    with pytest.raises(UnusableMotion, match="reaches beyond its numbers"):
        read_amass(tmp_path / "a.pt", 30.0)


def wham(poses, path):
    person = {"pose": -poses, "trans": 2 * path, "pose_world": poses, "trans_world": path}
    short = {name: array[:9] for name, array in person.items()}
    return {0: short, 3: {**person, "betas": np.zeros((N_FRAMES, 10)), "frame_ids": np.arange(N_FRAMES)}}


@pytest.mark.parametrize("compress", [0, 3, ("gzip", 3)])
def test_wham_the_person_seen_longest(tmp_path, poses, path, expected, compress):
    joblib.dump(wham(poses, path), tmp_path / "wham_output.pkl", compress=compress)
    same(read_amass(tmp_path / "wham_output.pkl", 30.0, "y"), expected)


def test_wham_another_person(tmp_path, poses, path, expected):
    joblib.dump(wham(poses, path), tmp_path / "wham_output.pkl")
    found = read_amass(tmp_path / "wham_output.pkl", 30.0, "y", person=2)
    assert (found.people, found.n_frames) == (2, len(wham(poses, path)[0]["pose_world"]))
    same(read_amass(tmp_path / "wham_output.pkl", 30.0, "y", person=1), expected)
    with pytest.raises(UnusableMotion, match=r"it shows 2 people, and none is number 3"):
        read_amass(tmp_path / "wham_output.pkl", 30.0, person=3)


def test_files_that_are_no_result_have_no_other_person(shared_cases):
    with pytest.raises(UnusableMotion, match="--person chooses among people in a result of video"):
        read_motion(shared_cases / "tpose_at_end.bvh", PoseFacts(person=2))
    assert read_motion(shared_cases / "tpose_at_end.bvh", PoseFacts(person=1)).n_frames > 100


@pytest.mark.parametrize("protocol", [0, 2, 4, 5])
def test_aist(tmp_path, poses, path, expected, protocol):
    content = {"smpl_poses": poses, "smpl_trans": 92.5 * path, "smpl_scaling": np.array([92.5]), "fps": 60}
    (tmp_path / "a.pkl").write_bytes(pickle.dumps(content, protocol))
    found = read_amass(tmp_path / "a.pkl", up="y")
    assert found.rate == 60
    np.testing.assert_allclose(found.pelvis, expected.pelvis, atol=1e-5)
    np.testing.assert_allclose(found.rotations, expected.rotations, atol=1e-6)


def test_4d_humans_the_longest_track_in_place(tmp_path, poses, expected):
    turns = Rotation.from_rotvec(poses.reshape(-1, 3)).as_matrix().reshape(N_FRAMES, 24, 3, 3)
    other = {"global_orient": np.eye(3)[None], "body_pose": np.tile(np.eye(3), (23, 1, 1))}
    frames = {}
    for number, turn in enumerate(turns):
        own = {"global_orient": turn[:1], "body_pose": turn[1:], "betas": np.zeros(10)}
        tracks = {7: other, 2: own} if number % 3 else {2: own}
        frames[f"{number:06d}.jpg"] = {"tid": list(tracks), "smpl": list(tracks.values()), "shot": 0}
    joblib.dump(frames, tmp_path / "demo.pkl", compress=3)
    found = read_amass(tmp_path / "demo.pkl", 30.0, "y")
    np.testing.assert_allclose(found.rotations, expected.rotations, atol=1e-6)
    assert not np.ptp(found.pelvis, axis=0).any()


class Evil:
    def __init__(self, target):
        self.target = target

    def __reduce__(self):
        return os.system, (f"touch {self.target}",)


@pytest.mark.parametrize("write", ["pickle", "joblib", "gzip", "torch"])
def test_code_is_refused_and_nothing_runs(tmp_path, poses, write):
    content = {"poses": poses, "trans": Evil(tmp_path / "ran")}
    file = tmp_path / "a.pkl"
    if write == "joblib":
        joblib.dump(content, file)
    elif write == "torch":
        with ZipFile(file, "w") as archive:
            archive.writestr("archive/data.pkl", pickle.dumps(content))
    else:
        data = pickle.dumps(content)
        file.write_bytes(gzip.compress(data) if write == "gzip" else data)
    with pytest.raises(UnusableMotion, match=r"it names (posix|nt)\.system: a model or motion holds arrays"):
        read_amass(file, 30.0)
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"nothing of the kind", "it is damaged, or no pickle"),
        (pickle.dumps([1, 2]), "it holds no poses of SMPL, but list"),
        (pickle.dumps({"words": 3}), "it holds no poses of SMPL, but words"),
        (pickle.dumps({"a.jpg": {"tid": [1], "smpl": "words"}}), "its tracks hold no poses"),
        (pickle.dumps({"a.jpg": {"tid": [1], "smpl": [{"body_pose": 1}]}}), "its tracks hold no poses"),
        (pickle.dumps({"a.jpg": {"tid": [[]], "smpl": [{}]}}), "its tracks hold no poses"),
        (b"PK\x03\x04 cut", "it is damaged, or no pickle"),
        (b"\x78\x9ccut", "it is damaged, or no pickle"),
    ],
)
def test_what_is_no_result_is_said(tmp_path, content, reason):
    (tmp_path / "a.pkl").write_bytes(content)
    with pytest.raises(UnusableMotion, match=reason):
        read_amass(tmp_path / "a.pkl", 30.0)


def test_a_cut_result_is_said(tmp_path, poses, path):
    joblib.dump(wham(poses, path), tmp_path / "a.pkl")
    data = (tmp_path / "a.pkl").read_bytes()
    (tmp_path / "a.pkl").write_bytes(data[: len(data) // 2])
    with pytest.raises(UnusableMotion, match="it is damaged, or no pickle"):
        read_amass(tmp_path / "a.pkl", 30.0)


@pytest.mark.later
@pytest.mark.parametrize("name", by_day(["packed.pkl"], ["packed.pkl", "zipped.pt"]))
def test_a_result_that_unpacks_to_far_more_than_a_motion_is_refused(tmp_path, name):
    content, path = pickle.dumps(bytes(UNPACKED_FREELY)), tmp_path / name
    if name.endswith(".pkl"):
        path.write_bytes(gzip.compress(content))
    else:
        with ZipFile(path, "w", ZIP_DEFLATED) as archive:
            archive.writestr("a/data.pkl", content)
    with pytest.raises(UnusableMotion, match="it unpacks to more than any motion needs"):
        read_amass(path, 30.0)
