"""Rows of SMPL's 24 joints as our 55: its last two are rigid hands."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.motion_builder import rotations_of
from halfphysics.formats.rotation_forms import checked_matrices
from halfphysics.motion import skeleton

Array = NDArray[np.float64]

JOINTS = 24
_OURS = len(skeleton.SMPL_JOINTS)


def vectors_in(record: Record, key: str) -> Array:
    """Rotations (T, 55, 3) of a field of axis-angle (T, 72); raises `FileError`."""
    rows = record.array(key, None, 3 * JOINTS)
    return rotations_of({skeleton.SMPL_JOINTS: rows[:, : 3 * _OURS]})


def matrices_in(record: Record, key: str) -> Array:
    """Rotations (T, 55, 3) of a field of matrices (T, 24, 3, 3); raises `FileError`."""
    matrices = checked_matrices(record, key, record.array(key, None, JOINTS, 3, 3))
    return rotations_of({skeleton.SMPL_JOINTS: rot.matrix_to_rotvec(matrices[:, :_OURS])})
