# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of known motion in every guise: what is read and retargeted to the body is that motion."""

import bpy
import numpy as np
import pytest

from w2w.core.body.body import JOINT_INDEX
from w2w.core.motion.skinning import joint_transforms, skin, skinning_transforms
from w2w.core.reading.formats import read_motion
from w2w.core.retargeting.bone_maps import BoneMap
from w2w.core.retargeting.retarget import BY_STRUCTURE, retarget
from w2w.scene.motion.load import read_by_blender
from w2w.scene.motion.takes import find_takes, imported
from w2w_studies.rehab.skeleton import BONE_INDEX

from ..made_motions import FILES, PLAYED_BY, SPEED

pytestmark = pytest.mark.filterwarnings("ignore:Gimbal lock")

SKELETONS = {
    "walking/names of one's own.fbx": "Werkstatt",
    "walking/centimetres.bvh": "CMU",
    "waving/names that say nothing.fbx": BY_STRUCTURE,
    "waving/3ds Max's names.bvh": "3ds Max Biped",
    "waving/SMPL's names.bvh": "SMPL",
    "squatting/Unreal's names, arms down, two takes.fbx": "Unreal",
    "squatting/inches, names that say nothing.bvh": BY_STRUCTURE,
    "squatting/Xsens's names.bvh": "Xsens BVH",
}
"""The bone map that each file wants; Mixamo's where nothing is said."""

SEGMENTS = [
    (f"{side}_{start}", f"{side}_{end}")
    for side in ("left", "right")
    for start, end in (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))
]


@pytest.fixture(scope="module", params=FILES)
def file(request):
    return request.param


@pytest.fixture(scope="module")
def clip(made_files, file):
    return made_files[1][file]


@pytest.fixture(scope="module")
def carried(made_files, bundled_body, file):
    """Source, retargeting and joint positions of a file."""
    folder, _ = made_files
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    source = read_motion(folder / file, blender=read_by_blender)
    result = retarget(source, bundled_body, [BoneMap.load(folder / "werkstatt.json")])
    return source, result, joint_transforms(bundled_body, result.motion)


def truth_of(clip, joint):
    return clip.heads[:, BONE_INDEX[PLAYED_BY[joint]]]


def leg_length(clip):
    return sum(
        np.linalg.norm(clip.rest[BONE_INDEX[f"Left{a}"]] - clip.rest[BONE_INDEX[f"Left{b}"]])
        for a, b in (("UpLeg", "Leg"), ("Leg", "Foot"))
    )


def body_leg_length(body):
    legs = body.joints[
        [[JOINT_INDEX[f"{s}_{part}"] for part in ("hip", "knee", "ankle")] for s in ("left", "right")]
    ]
    return np.linalg.norm(np.diff(legs, axis=1), axis=-1).sum() / 2


def test_the_right_take_is_read_whole_at_its_rate_with_every_joint(clip, carried, file):
    source, result, _ = carried
    assert (source.n_frames, source.rate) == (len(clip.heads), pytest.approx(clip.rate, rel=1e-4))
    assert result.bone_map == SKELETONS.get(file, "Mixamo")
    names = FILES[file][0].names
    if file.endswith(".bvh"):  # which has no spaces in names

        def names(bone, written=names):
            return written(bone).replace(" ", "_")

    for joint in ("pelvis", *(end for segment in SEGMENTS for end in segment)):
        assert result.bones[joint] == names(PLAYED_BY[joint])


def test_files_hold_what_they_are_named_for(made_files):
    """Takes, units, axes and rest poses are in the files, not only in the table of them."""
    folder, clips = made_files
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    for file, (rig, _) in FILES.items():
        with imported(folder / file) as objects:
            armature = next(item for item in objects if item.type == "ARMATURE")
            takes = {take.action.name.split("|")[-1] for take in find_takes(armature, bpy.data.actions)}
            rest = {
                joint: armature.matrix_world @ armature.data.bones[bone].head_local
                for joint, bone in carried_names(armature, rig).items()
            }
        if rig.kind == "fbx":
            assert len(takes) == 1 + rig.empty_take, file
        height = leg_length(clips[file]) * rig.units
        leg = (rest["left_hip"] - rest["left_knee"]).length + (rest["left_knee"] - rest["left_ankle"]).length
        assert leg == pytest.approx(height, rel=1e-3), file
        arm = rest["left_wrist"] - rest["left_shoulder"]
        lowered = np.degrees(np.arctan2(-arm.z, arm.xy.length))
        assert lowered == pytest.approx(np.degrees(rig.arms_down), abs=0.1), file


def carried_names(armature, rig):
    """Bone of each joint as the file has it."""
    written = {joint: rig.names(bone) for joint, bone in PLAYED_BY.items()}
    return {
        joint: name if name in armature.data.bones else name.replace(" ", "_")
        for joint, name in written.items()
        if name in armature.data.bones or name.replace(" ", "_") in armature.data.bones
    }


def test_limbs_point_where_they_were_made_to(clip, carried):
    _, _, (turns, heads) = carried
    for start, end in SEGMENTS:
        made = truth_of(clip, end) - truth_of(clip, start)
        ours = heads[:, JOINT_INDEX[end]] - heads[:, JOINT_INDEX[start]]
        made, ours = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (made, ours))
        away = np.degrees(np.arctan2(np.linalg.norm(np.cross(made, ours), axis=1), (made * ours).sum(axis=1)))
        assert away.max() < 0.1, (start, end)
    # the pelvis turns as it was made to: not at all
    tilt = np.degrees(np.arccos(np.clip((np.trace(turns[:, 0], axis1=1, axis2=2) - 1) / 2, -1, 1)))
    assert tilt.max() < 0.1


def test_the_path_is_the_one_made_in_the_body_s_own_leg_lengths(clip, carried, bundled_body, file):
    _, result, (_, heads) = carried
    ratio = body_leg_length(bundled_body) / leg_length(clip)
    assert result.scale * FILES[file][0].units == pytest.approx(ratio, rel=1e-3)
    hips = [heads[:, JOINT_INDEX[f"{side}_hip"]] for side in ("left", "right")]
    made = [truth_of(clip, f"{side}_hip") for side in ("left", "right")]
    ours, truth = sum(hips) / 2, ratio * sum(made) / 2
    np.testing.assert_allclose(ours - ours[0], truth - truth[0], atol=1e-3)
    np.testing.assert_allclose(ours[0, :2], truth[0, :2], atol=1e-3)
    travelled = np.linalg.norm(ours[-1, :2] - ours[0, :2])
    asked = SPEED * 3.0 * ratio if FILES[file][1].get("travels") else 0.0
    assert travelled == pytest.approx(asked, abs=2e-3)


def test_bodies_stand_on_the_ground(carried, bundled_body):
    _, result, _ = carried
    lowest = skin(bundled_body, skinning_transforms(bundled_body, result.motion))[..., 2].min(axis=1)
    assert abs(np.percentile(lowest, 2)) < 0.01
    assert lowest.max() < 0.25  # a step's bob, or toes that dip
