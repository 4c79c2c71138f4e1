# SPDX-License-Identifier: GPL-3.0-or-later
"""SMPL parameters as pose estimators and AIST++ write them, under the names and in the form of smplx."""

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from .source import UnusableMotion

IN_PARTS = ("global_orient", "body_pose")
WHOLE = {
    "smpl_poses": "smpl_trans",
    "pose_world": "trans_world",
    "pred_rotmat": "pred_trans",
    "pose": "trans",
}
"""Array of all joints' rotations -> array of the body's path: of AIST++, WHAM's world, TRAM and VIMO, and
WHAM's camera, PromptHMR and CoMotion."""

SCALE = "smpl_scaling"
"""AIST++ divides its path by it: what is left is in metres (Li et al. 2021, its own loader)."""

RESULT_KEYS = (*WHOLE, *WHOLE.values(), SCALE)

NOT_ORTHOGONAL = 0.01


def in_smplx_form(arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Arrays with rotation matrices made axis-angle, results renamed, and a path of 0 where there is none.

    Files of AMASS and `.smpl` files stay as they are. Raises UnusableMotion if matrices do not rotate.
    """
    found = {name: _axis_angle(name, array) for name, array in arrays.items()}
    whole = next((name for name in WHOLE if name in found), "")
    if whole and "poses" not in found and found[whole].ndim > 1:
        turns = found[whole].reshape(len(found[whole]), -1)
        found |= dict(zip(IN_PARTS, (turns[:, :3], turns[:, 3:]), strict=True))
        path = found.get(WHOLE[whole])
        found.pop("trans", None)  # of WHAM's camera, or that path
        if path is not None:
            found["transl"] = _path(path, found.get(SCALE))
    if found.keys() >= set(IN_PARTS) and found[IN_PARTS[0]].ndim > 1:
        found.setdefault("transl", np.zeros((len(found[IN_PARTS[0]]), 3)))
    return found


def _axis_angle(name: str, array: np.ndarray) -> np.ndarray:
    """Rotation matrices (T, J, 3, 3), or (T, 3, 3) of one joint, as rotation vectors (T, 3 J)."""
    if array.ndim < 3 or array.shape[-2:] != (3, 3) or array.dtype.kind != "f":
        return array
    turns = array.astype(np.float64)
    with np.errstate(invalid="ignore"):
        square = turns.swapaxes(-1, -2) @ turns
        if not (np.abs(square - np.eye(3)) < NOT_ORTHOGONAL).all() or (np.linalg.det(turns) < 0).any():
            raise UnusableMotion(f"its '{name}' have shape {array.shape}, and not all are rotation matrices")
    return Rotation.from_matrix(turns.reshape(-1, 3, 3)).as_rotvec().reshape(len(turns), -1)


def _path(path: np.ndarray, scale: np.ndarray | None) -> np.ndarray:
    """The body's path (T, 3) in metres."""
    if path.ndim == 3 and path.shape[1] == 1:
        path = path[:, 0]
    if scale is None:
        return path
    if scale.size != 1 or scale.dtype.kind not in "fiu" or not float(scale.item()) > 0:
        raise UnusableMotion(f"its '{SCALE}' is no number above 0")
    return path / float(scale.item())
