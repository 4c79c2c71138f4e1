# SPDX-License-Identifier: GPL-3.0-or-later
"""World poses of frames on an OpenSim model, from its joints' coordinates over time.

Delp et al. 2007 (doi:10.1109/TBME.2007.901024). Custom, pin and weld joints, as gait models have.
"""

import gzip
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

FREE = ("rotation1", "rotation2", "rotation3", "translation1", "translation2", "translation3")


def read_table(path: Path) -> tuple[list[str], np.ndarray]:
    """Columns' names and values of a .mot or .sto file (gz); vectors' parts stand side by side.

    Returns `names` (C,), time first, and values (T, C, k).
    """
    head, _, body = gzip.decompress(path.read_bytes()).decode().partition("endheader\n")
    names, *rows = [line.split("\t") for line in body.splitlines() if line.strip()]
    widest = max(cell.count(",") for cell in rows[0]) + 1
    values = np.array(
        [
            [[float(x) for x in cell.split(",")] + [0.0] * (widest - 1 - cell.count(",")) for cell in row]
            for row in rows
        ]
    )
    if "inDegrees=yes" in head:
        turned = [not name.endswith(("_tx", "_ty", "_tz", "time")) for name in names]
        values[:, turned] = np.radians(values[:, turned])
    return [name.strip() for name in names], values


def frame_poses(model: Path, coordinates: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """World matrices (T, 4, 4) of the model's bodies and of all frames fixed to them, y up.

    `model`: an .osim file (gz). `coordinates` (T,) by name: rad and m.
    """
    root = ElementTree.fromstring(gzip.decompress(model.read_bytes())).find("Model")
    n_frames = len(next(iter(coordinates.values())))
    poses = {"ground": np.tile(np.eye(4), (n_frames, 1, 1))}
    joints = list(root.findall("JointSet/objects/*"))
    while joints:
        left = [joint for joint in joints if not _place_child(joint, coordinates, poses)]
        if len(left) == len(joints):
            raise ValueError(f"{model}: joints that hang on nothing: {[joint.get('name') for joint in left]}")
        joints = left
    for body in root.iter("Body"):
        _place_fixed(body, poses[body.get("name")], poses)
    return poses


def _place_fixed(parent: ElementTree.Element, pose: np.ndarray, poses: dict[str, np.ndarray]) -> None:
    for frame in parent.findall("components/PhysicalOffsetFrame"):
        poses[frame.get("name")] = pose @ _offset(frame)
        _place_fixed(frame, poses[frame.get("name")], poses)


def _place_child(
    joint: ElementTree.Element, coordinates: dict[str, np.ndarray], poses: dict[str, np.ndarray]
) -> bool:
    """Place the body that a joint carries; False while that of its parent is not placed."""
    frames = {frame.get("name"): frame for frame in joint.findall("frames/PhysicalOffsetFrame")}
    ends = [frames[joint.findtext(f"socket_{end}_frame")] for end in ("parent", "child")]
    parent, child = (end.findtext("socket_parent").rpartition("/")[2] for end in ends)
    if parent not in poses:
        return False
    moved = _moved(joint, coordinates, len(poses["ground"]))
    poses[child] = poses[parent] @ _offset(ends[0]) @ moved @ np.linalg.inv(_offset(ends[1]))
    return True


def _moved(joint: ElementTree.Element, coordinates: dict[str, np.ndarray], n_frames: int) -> np.ndarray:
    """Pose (T, 4, 4) of a joint's child in its parent."""
    pose = np.tile(np.eye(4), (n_frames, 1, 1))
    if joint.tag == "PinJoint":
        angle = coordinates[joint.find("coordinates/Coordinate").get("name")]
        pose[:, :3, :3] = Rotation.from_euler("z", angle).as_matrix()
    elif joint.tag == "CustomJoint":
        axes = {axis.get("name"): axis for axis in joint.findall("SpatialTransform/TransformAxis")}
        for name in FREE:
            along = np.array(axes[name].findtext("axis").split(), dtype=float)
            value = _value(axes[name], coordinates)
            if name.startswith("rotation"):
                pose[:, :3, :3] = (
                    pose[:, :3, :3]
                    @ Rotation.from_rotvec(np.outer(np.broadcast_to(value, n_frames), along)).as_matrix()
                )
            else:
                pose[:, :3, 3] += np.outer(np.broadcast_to(value, n_frames), along)
    elif joint.tag != "WeldJoint":
        raise ValueError(f"a joint of kind {joint.tag} is not known")
    return pose


def _value(axis: ElementTree.Element, coordinates: dict[str, np.ndarray]) -> np.ndarray | float:
    name = (axis.findtext("coordinates") or "").strip()
    function = next(part for part in axis if part.get("name") == "function")
    return _of(function, coordinates[name] if name else np.zeros(1))


def _of(function: ElementTree.Element, x: np.ndarray) -> np.ndarray | float:
    """Value of one of OpenSim's functions."""
    numbers = {
        part.tag: np.array(part.text.split(), dtype=float)
        for part in function
        if part.text and part.text.strip()
    }
    match function.tag:
        case "Constant":
            return float(numbers["value"][0])
        case "LinearFunction":
            return numbers["coefficients"][0] * x + numbers["coefficients"][1]
        case "SimmSpline":
            return CubicSpline(numbers["x"], numbers["y"], bc_type="natural")(x)
        case "MultiplierFunction":
            return numbers["scale"][0] * _of(next(iter(function.find("function"))), x)
    raise ValueError(f"a function of kind {function.tag} is not known")


def _offset(frame: ElementTree.Element) -> np.ndarray:
    pose = np.eye(4)
    turn, place = (
        np.array(frame.findtext(part).split(), dtype=float) for part in ("orientation", "translation")
    )
    pose[:3, :3] = Rotation.from_euler("XYZ", turn).as_matrix()
    pose[:3, 3] = place
    return pose
