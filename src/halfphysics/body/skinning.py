"""Forward kinematics and linear blend skinning.

`kinematics` and `skin` run in the native core (native/geometry/skinning.cpp);
`tests/support/references/skinning.py` has the same in plain numpy. The tests hold both equal.

With R_j, x_j the world rotation and position of joint j, j_j its place at rest, w_vj the skin's
weights and B_v the pose blend shapes of vertex v (SMPL, Loper et al. 2015, equations 2 to 9)::

    xbar_v = rest_v + B_v vec(R_local - I)                    local rotations of joints 1 to 54
    x_v    = sum_j w_vj (R_j (xbar_v - j_j) + x_j)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

import halfphysics._native as _native
from halfphysics.base.arrays import as_array
from halfphysics.base.copying import ReadOnly
from halfphysics.base.short_repr import short_repr
from halfphysics.base.validation import is_whole, shown
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import PARENTS

Array = NDArray[np.float64]
Ints = NDArray[np.int32]

_NO_POSEDIRS = np.zeros((0, 3, 0))
_NO_SUBSET = np.zeros(0, dtype=np.int32)


@dataclass(frozen=True, kw_only=True, eq=False)
class Skin(ReadOnly):
    """The arrays of a shaped body for skinning, C-contiguous float64.

    Args:
        rest_vertices: Skin at rest [m], rest frame, shape (V, 3).
        rest_joints: Joints at rest [m], rest frame, shape (55, 3).
        weights: Of every vertex on every joint, rows sum to one, shape (V, 55).
        posedirs: Pose blend shapes [m], shape (V, 3, 486), or None. Column 9 (j - 1) + k belongs
            to entry k (row by row) of the local rotation matrix of joint j, minus the identity.
    """

    rest_vertices: Array
    rest_joints: Array
    weights: Array
    posedirs: Array | None

    __repr__ = short_repr

    @cached_property
    def sparse_weights(self) -> tuple[Ints, Ints, Array]:
        """The weights row by row: first entry of each vertex (V + 1,), joints, values (n,)."""
        vertex, joint = np.nonzero(self.weights)
        first = np.searchsorted(vertex, np.arange(len(self.weights) + 1))
        return first.astype(np.int32), joint.astype(np.int32), self.weights[vertex, joint]


def kinematics(rotations: Array, root: Array, rest_joints: Array) -> tuple[Array, Array]:
    """World frames of the joints.

    Args:
        rotations: Axis-angle [rad] in the parents' frames, shape (T, 55, 3).
        root: World position of the pelvis [m], shape (T, 3).
        rest_joints: Joints at rest [m], shape (55, 3).

    Returns:
        Positions (T, 55, 3) [m] and unit quaternions (T, 55, 4), wxyz, world from joint.
    """
    rotations = np.ascontiguousarray(rotations, dtype=np.float64)
    root = np.ascontiguousarray(root, dtype=np.float64)
    positions = np.empty(rotations.shape)
    quaternions = np.empty((*rotations.shape[:2], 4))
    _native.kinematics(rotations, root, rest_joints, PARENTS, positions, quaternions)
    return positions, quaternions


def skin(
    skin: Skin,
    rotations: Array,
    positions: Array,
    quaternions: Array,
    *,
    indices: Ints | None = None,
    wanted: tuple[Ints, NDArray[np.bool_]] | None = None,
    threads: int = 1,
) -> Array:
    """Posed vertices.

    Args:
        skin: The shaped body.
        rotations: Axis-angle [rad] in the parents' frames, shape (T, 55, 3).
        positions: Joints in the world [m], shape (T, 55, 3), as `kinematics` returns them.
        quaternions: World from joint, shape (T, 55, 4), as is this.
        indices: The vertices to compute, shape (n,); None: all of them.
        wanted: Of vertices that come in groups: where each group starts, (g + 1,) int32, and in
            which frames it is wanted (T, g). Where it is not, what comes out means nothing.
        threads: How many threads share the work. The result is the same to the last bit.

    Returns:
        Vertices in the world [m], shape (T, n, 3).

    Raises:
        InputError: `indices` are not vertices of the body, or `threads` is under 1.
    """
    count = len(skin.rest_vertices)
    subset = _NO_SUBSET if indices is None else checked_indices(indices, count)
    if not is_whole(threads, least=1, plain=False):
        raise InputError(f"threads: found {shown(threads)}, expected 1 or more")
    out = np.empty((len(positions), count if indices is None else len(subset), 3))
    _native.skin(
        skin.rest_vertices,
        skin.rest_joints,
        *skin.sparse_weights,
        _NO_POSEDIRS if skin.posedirs is None else skin.posedirs,
        np.ascontiguousarray(rotations, dtype=np.float64),
        np.ascontiguousarray(positions),
        np.ascontiguousarray(quaternions),
        subset,
        indices is None,
        int(threads),
        out,
        *(() if wanted is None else (wanted[0], wanted[1].view(np.uint8))),
    )
    return out


def checked_indices(indices: Ints, count: int) -> Ints:
    """Vertex indices as the native core takes them.

    Raises:
        InputError: Not whole numbers from 0 to `count` - 1.
    """
    try:
        array = as_array(indices)
    except (TypeError, ValueError):
        raise InputError(f"indices: found {shown(indices)}, expected whole numbers (n,)") from None
    if array.size == 0:
        return _NO_SUBSET
    if array.ndim != 1 or array.dtype.kind not in "iu":
        raise InputError(
            f"indices: found {array.dtype} of shape {array.shape}, expected whole numbers (n,)"
        )
    if array.min() < 0 or array.max() >= count:
        raise InputError(
            f"indices: found {array.min()} to {array.max()}, expected vertices 0 to {count - 1}"
        )
    return np.ascontiguousarray(array, dtype=np.int32)
