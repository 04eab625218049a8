"""Joint positions of a known motion, computed with rotation matrices of scipy, and the files that
generators of motion write with them."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from halfphysics.motion.skeleton import PARENTS

#: Offsets from the parents [m] of a made-up person whose pelvis and chest are as in models that
#: regress joints from the skin: hips under the pelvis, collars beside the spine. 1.68 m.
STRANGER = np.array(
    [
        *([0, 0, 0], [0.06, -0.09, -0.01], [-0.06, -0.09, -0.01], [0, 0.12, -0.02]),
        *([0.04, -0.38, 0], [-0.04, -0.38, 0], [0, 0.135, 0.02], [-0.01, -0.40, -0.04]),
        *([0.01, -0.40, -0.04], [0, 0.055, 0], [0.04, -0.06, 0.12], [-0.04, -0.06, 0.12]),
        *([0, 0.21, -0.03], [0.08, 0.115, -0.02], [-0.08, 0.115, -0.02], [0, 0.09, 0.05]),
        *([0.09, 0.03, -0.01], [-0.09, 0.03, -0.01], [0.26, -0.01, -0.02], [-0.26, -0.01, -0.02]),
        *([0.25, 0.01, 0], [-0.25, 0.01, 0]),
    ]
)


def offsets(rest: np.ndarray, count: int = 55) -> np.ndarray:
    """Offsets (J, 3) from the parents of joints at rest."""
    return np.array([rest[j] - (rest[PARENTS[j]] if j else 0.0) for j in range(count)])


def places(rotations: np.ndarray, pelvis: np.ndarray, bones: np.ndarray) -> np.ndarray:
    """Forward kinematics: positions (T, J, 3) of a pelvis (T, 3), rotations (T, >= J, 3)."""
    frames, count = len(rotations), len(bones)
    world = np.empty((frames, count, 3, 3))
    out = np.empty((frames, count, 3))
    for j in range(count):
        own = Rotation.from_rotvec(np.array(rotations[:, j])).as_matrix()
        p = PARENTS[j]
        world[:, j] = own if j == 0 else world[:, p] @ own
        out[:, j] = pelvis if j == 0 else out[:, p] + world[:, p] @ bones[j]
    return out


def y_up(points: np.ndarray) -> np.ndarray:
    """Points (..., 3) of the z-up world in the axes of files with y up."""
    return np.stack([points[..., 0], points[..., 2], -points[..., 1]], axis=-1)


def features(joints: np.ndarray, contacts: np.ndarray | None = None) -> np.ndarray:
    """HumanML3D's features (T - 1, 263) of positions (T, 22, 3), y up; rotations are left zero.

    The heading of a frame is that of the hips: the feet's way is across them. As there, the last
    frame gives only velocities.
    """
    across = joints[:, 1] - joints[:, 2]
    heading = np.arctan2(-across[:, 2], across[:, 0])  # turned by this about y from facing +z
    turns = Rotation.from_rotvec(heading[:, None] * [0.0, 1.0, 0.0]).as_matrix()
    root = joints[:, 0]
    local = joints - root[:, None] * [1.0, 0.0, 1.0]
    local = np.einsum("tji,tkj->tki", turns, local)
    step = np.einsum("tji,tj->ti", turns[1:], np.diff(root, axis=0))
    yaw = Rotation.from_matrix(np.swapaxes(turns[:-1], 1, 2) @ turns[1:]).as_rotvec()[:, 1]
    count = joints.shape[1]
    out = np.zeros((len(joints) - 1, 4 + 3 * (count - 1) + 6 * (count - 1) + 3 * count + 4))
    out[:, 0] = -0.5 * yaw  # the stored quaternion turns the frame, not the person
    out[:, 1], out[:, 2], out[:, 3] = step[:, 0], step[:, 2], root[:-1, 1]
    out[:, 4 : 4 + 3 * (count - 1)] = local[:-1, 1:].reshape(len(out), -1)
    out[:, -4:] = 1.0 if contacts is None else contacts
    return out


def first_heading(joints: np.ndarray) -> np.ndarray:
    """The positions as features keep them: from x = z = 0, with the first frame facing +z."""
    across = joints[0, 1] - joints[0, 2]
    turn = Rotation.from_rotvec([0.0, np.arctan2(-across[2], across[0]), 0.0]).as_matrix()
    moved = joints - joints[0, 0] * [1.0, 0.0, 1.0]
    return moved @ turn


def rows(rotations: np.ndarray) -> np.ndarray:
    """The first two rows of rotation matrices (..., 6)."""
    matrices = Rotation.from_rotvec(np.array(rotations).reshape(-1, 3)).as_matrix()
    return matrices[:, :2].reshape(*rotations.shape[:-1], 6)


def matrices(rotations: np.ndarray) -> np.ndarray:
    """Rotation matrices (..., 3, 3)."""
    return (
        Rotation.from_rotvec(np.array(rotations).reshape(-1, 3))
        .as_matrix()
        .reshape(*rotations.shape[:-1], 3, 3)
    )
