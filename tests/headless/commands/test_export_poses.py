# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs for pose estimators, opened as the estimators' own programs open them.

Their code cannot come along, so what their loaders do is stated anew: `PoseDataset` of MobilePoser (Xu et al.
2024), `evaluate_pose` of TransPose (Yi et al. 2021) and PIP (Yi et al. 2022), and IMUPoser's second script
(Mollyn et al. 2023). `make test-peers` runs them without a skip.
"""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import PARENTS

from .test_export import exported, results  # noqa: F401 - a fixture

SPEED = 0.2
"""Metres a second at which the run's clips walk."""

HEAD, PELVIS = 4, 5
COMBO = [0, 3, 4]
"""Left wrist, right pocket and head, MobilePoser's first."""


def mobileposer(torch, folder):
    """Inputs and targets of MobilePoser's windows: it opens what lies in its folder of processed data."""
    fps, acc_scale, vel_scale, window = 30, 30, 2, 125
    windows = []
    for path in sorted(path for path in folder.iterdir() if path.suffix == ".pt"):
        data = torch.load(path, weights_only=True)
        lists = (data[name] for name in ("acc", "ori", "pose", "tran", "joint", "contact"))
        for acc, ori, pose, tran, joint, foot in zip(*lists, strict=True):
            turns = pose.view(-1, 216).view(-1, 24, 3, 3)
            imu = torch.cat([acc[:, COMBO].flatten(1) / acc_scale, ori[:, COMBO].flatten(1)], dim=1)
            vel = torch.cat((torch.zeros(1, 24, 3), torch.diff(joint.view(-1, 24, 3), dim=0)))
            vel[:, 0] = torch.cat((torch.zeros(1, 3), tran[1:] - tran[:-1]))
            r6d = turns[..., :2].transpose(-1, -2).reshape(len(turns), -1)
            parts = (imu, r6d, joint, tran, vel * (fps / vel_scale), foot)
            windows += zip(*(torch.split(part, window) for part in parts), strict=True)
    return windows


def evaluated(torch, folder):
    """Input frames, poses and paths as the evaluation of TransPose and PIP gives them to the networks."""
    data = torch.load(folder / "test.pt", weights_only=True)
    inputs = []
    for acc, ori in zip(data["acc"], data["ori"], strict=True):
        acc, ori = acc.view(-1, 6, 3), ori.view(-1, 6, 3, 3)
        acc = torch.cat((acc[:, :5] - acc[:, 5:], acc[:, 5:]), dim=1).bmm(ori[:, -1]) / 30
        ori = torch.cat((ori[:, 5:].transpose(2, 3).matmul(ori[:, :5]), ori[:, 5:]), dim=1)
        inputs.append(torch.cat((acc.flatten(1), ori.flatten(1)), dim=1))
    turns = [
        Rotation.from_rotvec(pose.view(-1, 3)).as_matrix().reshape(-1, 24, 3, 3) for pose in data["pose"]
    ]
    return inputs, turns, data["tran"]


def imuposer(torch, folder):
    """Accelerations, orientations and poses at 25 Hz, of the lists that IMUPoser's first script leaves."""

    def resampled(values):
        places = torch.arange(0, len(values), 60 / 25)
        start, end = torch.floor(places).long(), torch.ceil(places).long().clamp(max=len(values) - 1)
        weights = (places - start).view(-1, *[1] * (values.ndim - 1))
        return torch.lerp(values[start], values[end], weights.expand_as(values[start]))

    lists = [
        torch.load(folder / f"{name}.pt", weights_only=True) for name in ("vacc", "vrot", "pose", "tran")
    ]
    for name in ("joint", "shape"):
        assert len(torch.load(folder / f"{name}.pt", weights_only=True)) == len(lists[0])
    return [[resampled(part) for part in clip] for clip in zip(*lists, strict=True)]


def head_of(turns):
    """World rotation of the head by the turns (T, 24, 3, 3) of all joints."""
    joint, chain = 15, []
    while joint >= 0:
        chain.append(joint)
        joint = PARENTS[joint]
    world = np.eye(3)
    for joint in reversed(chain):
        world = world @ turns[:, joint]
    return world


def assert_frames_of_reference(turns, head, tran, rate):
    """The head's sensor turns as its bone does, and the body walks at its speed in a world with y up."""
    apart = Rotation.from_matrix(head_of(turns).swapaxes(1, 2) @ head).magnitude()
    assert np.degrees(apart).max() < 3
    steps = np.diff(tran, axis=0) * rate
    np.testing.assert_allclose(np.median(steps, axis=0), [SPEED, 0, 0], atol=1e-3)


@pytest.mark.slow
def test_mobileposer_takes_windows_of_the_file(results, tmp_path):  # noqa: F811
    torch = pytest.importorskip("torch")
    folder = exported(results, tmp_path, "mobileposer")
    windows = mobileposer(torch, folder)
    assert len(windows) == 16  # eight clips of 150 frames in windows of 125
    for imu, r6d, joint, tran, vel, foot in windows:
        n = len(imu)
        shapes = [tuple(part.shape) for part in (imu, r6d, joint, tran, vel, foot)]
        assert shapes == [(n, 36), (n, 144), (n, 24, 3), (n, 3), (n, 24, 3), (n, 2)]
        assert all(torch.isfinite(part.float()).all() for part in (imu, r6d, joint, tran, vel))
        assert set(foot.unique().tolist()) <= {0, 1}
        if n == 125:
            assert abs(imu[10:-10, 6:9].mean(axis=0)).max() * 30 < 1.5  # the head's: no 9.81 is left in it
        assert vel[5:, 0, 0].median() * 2 == pytest.approx(SPEED, abs=1e-3)
    data = torch.load(folder / "w2w.pt", weights_only=True)
    for pose, ori, tran in zip(data["pose"], data["ori"], data["tran"], strict=True):
        assert_frames_of_reference(pose.numpy(), ori[:, HEAD].numpy(), tran.numpy(), 30)


@pytest.mark.slow
def test_the_evaluation_of_transpose_and_pip_opens_its_file(results, tmp_path):  # noqa: F811
    torch = pytest.importorskip("torch")
    folder = exported(results, tmp_path, "transpose")
    inputs, turns, trans = evaluated(torch, folder)
    assert len(inputs) == 8
    for frames, pose, tran in zip(inputs, turns, trans, strict=True):
        assert frames.shape == (len(pose), 72)
        orientations = frames[:, 18:].view(-1, 6, 3, 3).numpy()
        head = orientations[:, PELVIS] @ orientations[:, HEAD]
        assert_frames_of_reference(pose, head, tran.numpy(), 60)


@pytest.mark.slow
def test_imuposer_resamples_the_lists(results, tmp_path):  # noqa: F811
    torch = pytest.importorskip("torch")
    folder = exported(results, tmp_path, "imuposer")
    clips = imuposer(torch, folder)
    assert len(clips) == len(json.loads((folder / "clips.json").read_text())["clips"])
    for acc, ori, pose, tran in clips:
        n = len(acc)
        assert (acc.shape, ori.shape, pose.shape) == ((n, 6, 3), (n, 6, 3, 3), (n, 24, 3))
        steps = torch.diff(tran, dim=0).median(dim=0).values * 25
        np.testing.assert_allclose(steps, [SPEED, 0, 0], atol=1e-3)
        assert torch.linalg.det(ori).mean() == pytest.approx(1, abs=0.02)
