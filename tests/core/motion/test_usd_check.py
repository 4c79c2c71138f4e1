# SPDX-License-Identifier: GPL-3.0-or-later
"""USD: what Blender wrote comes back as the FBX it was made of; what is no whole file is refused."""

import importlib.util

import numpy as np
import pytest

import w2w
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import UnusableMotion
from w2w.core.motion.usd_check import check_usd

HEADER = "#usda 1.0\n(\n    timeCodesPerSecond = 30\n)\n"
BODY = 'def Xform "a"\n{\n}\n'
HAS_USD = importlib.util.find_spec("pxr") is not None


@pytest.mark.parametrize(
    ("text", "rate"),
    [
        (HEADER + BODY, 30.0),
        (HEADER.replace("30", "29.97") + BODY, 29.97),
        ("#usda 1.0\n(\n    framesPerSecond = 60\n)\n" + BODY, 60.0),
        ("#usda 1.0\n(\n    framesPerSecond = 60\n    timeCodesPerSecond = 120\n)\n" + BODY, 120.0),
        ("#usda 1.0\n" + BODY, 24.0),
    ],
)
def test_text_says_its_time_codes_a_second(tmp_path, text, rate):
    (tmp_path / "a.usd").write_text(text)
    assert check_usd(tmp_path / "a.usd") == rate


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.usda", b"", "empty"),
        ("a.usda", b"nothing of the kind", "it does not begin as one"),
        ("a.usdc", b"PXR", "it does not begin as one"),
        ("a.usda", (HEADER + BODY).encode()[:-4], "it is cut short"),
        ("a.usda", HEADER.replace("30", "-1").encode() + BODY.encode(), "has -1 time codes a second"),
        ("a.usda", HEADER.replace("30", "many").encode() + BODY.encode(), "has many time codes"),
        (
            "a.usda",
            (HEADER + 'def "a" (\n    references = @../../etc/rig.usd@</rig>\n)\n{\n}\n').encode(),
            "parts of it lie in other files (../../etc/rig.usd)",
        ),
        (
            "a.usda",
            b"#usda 1.0\n(\n    subLayers = [\n        @b.usd@\n    ]\n)\n" + BODY.encode(),
            "(b.usd)",
        ),
    ],
)
def test_what_is_no_whole_file_is_refused(tmp_path, name, data, message):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(UnusableMotion) as caught:
        check_usd(tmp_path / name)
    assert message in str(caught.value)


@pytest.mark.parametrize("head", [b"PXR-USDC", b"PK\x03\x04"])
def test_a_binary_file_wants_usd_itself(tmp_path, head):
    (tmp_path / "a.usdz").write_bytes(head + b"\0" * 200)
    wanted = "it is damaged" if HAS_USD else "pip install usd-core"
    with pytest.raises(UnusableMotion, match=wanted):
        check_usd(tmp_path / "a.usdz")


@pytest.fixture(scope="module")
def written(shared_data, tmp_path_factory):
    """A run that Blender wrote in both forms, and the FBX it read."""
    bpy = pytest.importorskip("bpy")
    fbx = shared_data / "mixamo/kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx"
    folder = tmp_path_factory.mktemp("usd")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.fbx(filepath=str(fbx))
    end = max(action.frame_range[1] for action in bpy.data.actions)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 0, int(end)
    for form in ("usda", "usdc"):
        bpy.ops.wm.usd_export(
            filepath=str(folder / f"run.{form}"), export_animation=True, export_armatures=True
        )
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return fbx, folder


def test_a_motion_comes_back_as_the_fbx_it_was_made_of(written, bundled_body):
    fbx, folder = written
    expected, found = w2w.load(fbx)[0], w2w.load(folder / "run.usda")[0]
    assert found.rate == pytest.approx(expected.rate)
    assert abs(found.n_frames - expected.n_frames) <= 1
    a, b = (joint_transforms(bundled_body, motion)[0] for motion in (expected, found))
    n_frames = min(len(a), len(b))
    np.testing.assert_allclose(a[:n_frames], b[-n_frames:], atol=0.02)


def test_a_file_cut_short_is_refused(written, tmp_path):
    data = (written[1] / "run.usda").read_bytes()
    (tmp_path / "cut.usda").write_bytes(data[: len(data) // 2])
    with pytest.raises(ValueError, match="cut short"):
        w2w.load(tmp_path / "cut.usda")


def test_binary_is_read_where_usd_is_there(written, tmp_path):
    if not HAS_USD:
        with pytest.raises(ValueError, match="frames a second cannot be read here"):
            w2w.load(written[1] / "run.usdc")
        return
    assert w2w.load(written[1] / "run.usdc")[0].n_frames > 10
    data = (written[1] / "run.usdc").read_bytes()
    (tmp_path / "cut.usdc").write_bytes(data[: len(data) // 2])
    with pytest.raises(ValueError, match="damaged"):
        w2w.load(tmp_path / "cut.usdc")
