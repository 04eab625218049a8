"""Collision shapes of a person, handed to the core: hulls of the skin, or rigid parts."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.body.rigid_parts import part_collider
from halfphysics.motion.skeleton import JOINT_NAMES, PARENTS

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.settings import Settings


def add_person_shapes(
    core: Any,
    model: Any,
    body: Body,
    settings: Settings,
    *,
    prefix: str,
    index: int,
    row: Callable[[int], int],
) -> list[int]:
    """Add the shapes of person `index` to the core; returns the joint of each.

    Args:
        core: The native stepper.
        model: The `mujoco.MjModel` with the person's bodies.
        body: The person's body.
        settings: `Settings.contact` chooses between skin and parts.
        prefix: Of the person's bodies in the model.
        index: Of the person.
        row: The row that material pairs have for a part, given its joint.
    """
    add = _add_skin if settings.contact == "skin" else _add_parts
    return add(core, model, body, prefix, index, row)


def _add_parts(
    core: Any, model: Any, body: Body, prefix: str, index: int, row: Callable[[int], int]
) -> list[int]:
    joints = []
    for part in body.variant.parts:
        if len(part.vertices) == 0:
            continue
        at = model.body(prefix + part.name).id
        collider = part_collider(part)
        core.add_shape(at, row(part.index), index, part.index, *collider.arrays)
        joints.append(part.index)
    return joints


def _add_skin(
    core: Any, model: Any, body: Body, prefix: str, index: int, row: Callable[[int], int]
) -> list[int]:
    skin = core.add_skin(
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
        core.add_skin_shape(
            skin, row(int(part)), index, int(part), np.ascontiguousarray(vertices, dtype=np.int32)
        )
    return [int(part) for part in hulls.part]
