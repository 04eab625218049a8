"""Skinning as in the SMPL paper: the reference for body models and their templates."""

from __future__ import annotations

from typing import Any

import numpy as np

from halfphysics.base import rotations as rot
from support.files.model_files import (
    file_parents,
)


def lbs(
    model: str, content: dict[str, Any], betas: np.ndarray, rotations: np.ndarray
) -> np.ndarray:
    """Skinning as in the SMPL paper, on the file's own joints, one at a time."""
    shaped = content["v_template"] + content["shapedirs"][:, :, : len(betas)] @ betas
    rest = content["J_regressor"] @ shaped
    local = rot.rotvec_to_matrix(rotations)
    world: list[np.ndarray] = []
    for j, parent in enumerate(file_parents(model)):
        step = np.eye(4)
        step[:3, :3] = local[j]
        step[:3, 3] = rest[j] - (rest[parent] if j else 0.0)
        world.append(world[parent] @ step if j else step)
    shaped = shaped + content["posedirs"] @ (local[1:] - np.eye(3)).ravel()
    out = np.zeros_like(shaped)
    for j, transform in enumerate(world):
        moved = (shaped - rest[j]) @ transform[:3, :3].T + transform[:3, 3]
        out += content["weights"][:, j : j + 1] * moved
    return out
