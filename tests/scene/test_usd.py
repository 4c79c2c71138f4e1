# SPDX-License-Identifier: GPL-3.0-or-later
"""USD: what Blender wrote comes back as the FBX it was made of; what is no whole file is refused."""

import shutil
import sys
import zipfile
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

import w2w
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import UnusableMotion
from w2w.scene.motion import importers

FORMS = ("usda", "usdc", "usdz")
HAS_USD = bpy.app.version >= (4, 4)  # its own library, open to Python


@pytest.fixture(scope="module")
def written(shared_data, tmp_path_factory):
    """A run that Blender wrote in all forms, and the FBX it read."""
    fbx = shared_data / "mixamo/kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx"
    folder = tmp_path_factory.mktemp("usd")
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.import_scene.fbx(filepath=str(fbx))
    end = max(action.frame_range[1] for action in bpy.data.actions)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 0, int(end)
    for form in FORMS:
        bpy.ops.wm.usd_export(
            filepath=str(folder / f"run.{form}"), export_animation=True, export_armatures=True
        )
    return fbx, folder


@pytest.mark.parametrize("form", FORMS)
def test_a_motion_comes_back_as_the_fbx_it_was_made_of(written, bundled_body, form):
    if not HAS_USD:
        pytest.skip("this Blender's USD is not open to Python")
    fbx, folder = written
    path = sys.path.copy()
    expected, found = w2w.load(fbx)[0], w2w.load(folder / f"run.{form}")[0]
    assert found.rate == pytest.approx(expected.rate)
    assert abs(found.n_frames - expected.n_frames) <= 1
    a, b = (joint_transforms(bundled_body, motion)[0] for motion in (expected, found))
    n_frames = min(len(a), len(b))
    np.testing.assert_allclose(a[:n_frames], b[-n_frames:], atol=0.02)
    assert sys.path == path


def test_a_binary_file_under_the_common_name_keeps_its_own_rate(written, tmp_path):
    if not HAS_USD:
        pytest.skip("this Blender's USD is not open to Python")
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.context.scene.render.fps = 48
    shutil.copyfile(written[1] / "run.usdc", tmp_path / "run.usd")
    assert w2w.load(tmp_path / "run.usd")[0].rate == pytest.approx(w2w.load(written[0])[0].rate)
    assert bpy.context.scene.render.fps == 48


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("part", [0.05, 0.5, 0.98])
def test_a_file_cut_short_is_refused(written, tmp_path, form, part):
    data = (written[1] / f"run.{form}").read_bytes()
    (tmp_path / f"cut.{form}").write_bytes(data[: int(len(data) * part)])
    with pytest.raises(ValueError, match="damaged" if HAS_USD else "Blender 4"):
        w2w.load(tmp_path / f"cut.{form}")


def test_an_archive_of_other_things_is_refused(tmp_path):
    (tmp_path / "text.txt").write_text("no scene")
    shutil.make_archive(str(tmp_path / "other"), "zip", tmp_path, "text.txt")
    (tmp_path / "other.zip").rename(tmp_path / "other.usdz")
    with pytest.raises(ValueError, match="damaged" if HAS_USD else "Blender 4"):
        w2w.load(tmp_path / "other.usdz")


TEXT = "#usda 1.0\n(\n    {}\n)\n"
BODY = 'def Xform "a" ({})\n{{\n}}\n'


@pytest.fixture
def sdf():
    """USD's own layers, opened to Python by a first import."""
    if not HAS_USD:
        pytest.skip("this Blender's USD is not open to Python")
    importers.open_library()
    from pxr import Sdf

    return Sdf


def text(header: str = "", of_prim: str = "", body: str = "") -> str:
    """A layer as text, with what is said in its header, of its prim and after it."""
    return TEXT.format(header) + BODY.format(of_prim) + body


@pytest.mark.usefixtures("sdf")
@pytest.mark.parametrize(
    ("header", "rate"),
    [
        ("timeCodesPerSecond = 30", 30.0),
        ("timeCodesPerSecond = 29.97", 29.97),
        ("framesPerSecond = 60", 60.0),
        ("framesPerSecond = 60\n    timeCodesPerSecond = 120", 120.0),
        ('doc = "timeCodesPerSecond = 7"', 24.0),
    ],
)
def test_a_file_says_its_time_codes_a_second(tmp_path, header, rate):
    (tmp_path / "a.usd").write_text(text(header))
    assert importers.usd_rate(tmp_path / "a.usd") == rate


@pytest.mark.usefixtures("sdf")
@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.usda", b"", "empty"),
        ("a.usda", b"nothing of the kind", "it does not begin as one"),
        ("a.usdc", b"PXR", "it does not begin as one"),
        ("a.usda", text().encode()[:-4], "damaged"),
        ("a.usda", text("timeCodesPerSecond = -1").encode(), "has -1 time codes a second"),
        ("a.usda", text("timeCodesPerSecond = inf").encode(), "has inf time codes a second"),
        ("a.usda", text("timeCodesPerSecond = many").encode(), "damaged"),
        ("a.usdc", b"PXR-USDC" + bytes(200), "damaged"),
    ],
)
def test_what_is_no_usable_file_is_refused(tmp_path, name, data, message):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(UnusableMotion) as caught:
        importers.usd_rate(tmp_path / name)
    assert message in str(caught.value)


CLIPS = "clips = {\n dictionary default = {\n asset[] assetPaths = [@b.usda@]\n }\n }\n"
IN_VARIANT = """over "b" (
    prepend variantSets = "v"
)
{{
    variantSet "v" = {{
        "one" ({}
        ) {{
        }}
    }}
}}
"""
PARTS = {
    "a sublayer": text("subLayers = [@b.usda@]"),
    "a sublayer after empty lines": text("subLayers = [\n\n\n\n    # @none@\n\n    @b.usda@\n]"),
    "a reference": text(of_prim="references = @b.usda@</a>"),
    "a reference between others": text(of_prim="prepend references = [</a>,\n\n\n @@@b.usda@@@]"),
    "a payload": text(of_prim="append payload = @b.usda@"),
    "a reference of a variant": text(body=IN_VARIANT.format("\n\n references = @b.usda@</a>")),
    "a path to be worked out": text(of_prim='references = @`"${X}.usda"`@</a>'),
    "value clips": text(of_prim=CLIPS),
    "value clips by a pattern": text(
        of_prim='clips = {\n dictionary default = {\n string templateAssetPath = "b.#.usda"\n }\n }\n'
    ),
    "value clips of a variant": text(body=IN_VARIANT.format(CLIPS)),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("part", PARTS)
def test_a_file_of_parts_in_other_files_is_refused(tmp_path, sdf, part, form):
    """The other file may lie anywhere, and nobody would see it change."""
    layer = sdf.Layer.CreateAnonymous(".usda")
    assert layer.ImportFromString(PARTS[part])
    path = tmp_path / f"a.{form}"
    whole = tmp_path / ("whole.usdc" if form == "usdz" else path)
    layer.Export(str(whole))
    if form == "usdz":
        with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
            archive.write(whole, whole.name)
    with pytest.raises(UnusableMotion, match=r"parts of it lie in other files \(.*\): save it as one file"):
        importers.usd_rate(path)


ALONE = """
def Xform "root" (
    references = </a>
    customData = {
        string s = "references = @b.usda@"
    }
)
{
    # payload = @b.usda@
    asset inputs:file = @skin.png@
    def DomeLight "sky"
    {
        asset inputs:texture:file = @sky.png@
    }
    def Volume "smoke"
    {
        rel field:density = </root/smoke/field>
        def OpenVDBAsset "field"
        {
            asset filePath = @smoke.vdb@
        }
    }
}
"""


@pytest.mark.usefixtures("sdf")
def test_what_is_read_of_no_other_file_stays(tmp_path):
    (tmp_path / "a.usda").write_text(text(body=ALONE))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    importers.import_usd(tmp_path / "a.usda")
    assert [item.name for item in bpy.data.objects if item.type == "EMPTY"]
    assert not [*bpy.data.volumes, *bpy.data.images, *bpy.data.lights]


@pytest.mark.parametrize("form", FORMS)
def test_without_usds_library_a_file_is_refused(written, monkeypatch, form):
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(UnusableMotion, match=r"use Blender 4\.4 or later, or export it as \.glb or FBX"):
        importers.usd_rate(written[1] / f"run.{form}")


@pytest.mark.usefixtures("sdf")
def test_a_long_text_is_gone_over_once(tmp_path):
    (tmp_path / "long.usda").write_text(text('doc = "' + "references=" * 2**18 + '"', body="\n" * 2**18))
    assert importers.usd_rate(tmp_path / "long.usda") == 24.0


def test_a_blender_built_without_usd_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(
        importers, "bpy", SimpleNamespace(ops=SimpleNamespace(wm=SimpleNamespace()))
    )  # as Debian's
    with pytest.raises(UnusableMotion, match=r"built without USD: export the file as \.glb or FBX"):
        importers.import_usd(tmp_path / "run.usdc")
