"""`body.skinning` in plain numpy: one equation a line."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.skinning import Skin
from halfphysics.motion.skeleton import PARENTS

Array = NDArray[np.float64]


def kinematics_reference(rotations: Array, root: Array, rest_joints: Array) -> tuple[Array, Array]:
    """`kinematics` in plain numpy."""
    local = rot.exp(rotations)
    positions, quaternions = np.empty(rotations.shape), np.empty(local.shape)
    positions[:, 0], quaternions[:, 0] = root, local[:, 0]
    for j, p in enumerate(PARENTS[1:], start=1):
        arm = rot.rotate(quaternions[:, p], rest_joints[j] - rest_joints[p])
        positions[:, j] = positions[:, p] + arm
        quaternions[:, j] = rot.multiply(quaternions[:, p], local[:, j])
    return positions, quaternions


def skin_reference(skin: Skin, rotations: Array, positions: Array, quaternions: Array) -> Array:
    """`skin` of all vertices in plain numpy."""
    shaped = np.broadcast_to(skin.rest_vertices, (len(positions), *skin.rest_vertices.shape))
    if skin.posedirs is not None:
        features = rot.rotvec_to_matrix(rotations[:, 1:]) - np.eye(3)
        shaped = shaped + np.einsum("vck,tk->tvc", skin.posedirs, features.reshape(-1, 486))
    # Blended about the pelvis: the translation passes through exactly, at any size.
    world = rot.to_matrix(quaternions)
    shift = positions - positions[:, :1] - np.einsum("tjab,jb->tja", world, skin.rest_joints)
    blended = np.einsum("vj,tjab->tvab", skin.weights, world)
    moved = np.einsum("tvab,tvb->tva", blended, shaped)
    result: Array = positions[:, :1] + moved + np.einsum("vj,tja->tva", skin.weights, shift)
    return result
