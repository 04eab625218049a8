"""What of a person touches, handed to the native stepper: hulls of the skin, or rigid parts."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.geometry.colliders import part_collider
from halfphysics.motion.skeleton import JOINT_NAMES, PARENTS

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.settings import Settings


def add_person_movers(
    stepper: Any,
    model: Any,
    body: Body,
    settings: Settings,
    *,
    prefix: str,
    index: int,
    name: Callable[[int], int],
) -> list[int]:
    """Add the movers of person `index`; returns their joints.

    `name` says where the pairings have a part; `prefix` is that of the person's bodies in the
    `mujoco.MjModel`.
    """
    add = _add_skin if settings.contact == "skin" else _add_parts
    return add(stepper, model, body, prefix, index, name)


def _add_parts(
    stepper: Any, model: Any, body: Body, prefix: str, index: int, name: Callable[[int], int]
) -> list[int]:
    joints = []
    for part in body.variant.parts:
        if len(part.vertices) == 0:
            continue
        at = model.body(prefix + part.name).id
        collider = part_collider(part)
        stepper.add_mover(at, name(part.index), index, part.index, *collider.arrays)
        joints.append(part.index)
    return joints


def _add_skin(
    stepper: Any, model: Any, body: Body, prefix: str, index: int, name: Callable[[int], int]
) -> list[int]:
    skin = stepper.add_skin(
        np.array([model.body(prefix + j).id for j in JOINT_NAMES], dtype=np.int32),
        np.ascontiguousarray(PARENTS, dtype=np.int32),
        np.ascontiguousarray(body.rest_joints),
        np.ascontiguousarray(body.rest_vertices),
        *body.skin.sparse_weights,
        np.zeros((0, 3, 0)) if body.posedirs is None else body.posedirs,
    )
    hulls = body.skin_corners
    for h, part in enumerate(hulls.part):
        vertices = hulls.vertex[hulls.first[h] : hulls.first[h + 1]]
        stepper.add_skin_mover(
            skin, name(int(part)), index, int(part), np.ascontiguousarray(vertices, dtype=np.int32)
        )
    return [int(part) for part in hulls.part]
