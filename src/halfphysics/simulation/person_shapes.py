"""Collision shapes of a person, handed to the core: hulls of the skin, or rigid parts."""

from __future__ import annotations

import atexit
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics import _native
from halfphysics.body.mjcf_person import addresses
from halfphysics.body.rigid_parts import part_collider
from halfphysics.body.soft_skin import SoftSkin, soft_core
from halfphysics.motion.skeleton import PARENTS
from halfphysics.simulation.soft_shapes import set_part_samples, set_skin_samples, skin_of

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
    sampled: bool = False,
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
        sampled: Whether something is soft: the person presses on it by samples.
    """
    if settings.contact == "parts":
        return _add_parts(core, model, body, prefix, index, row, sampled)
    joints = _add_skin(core, model, body, prefix, index, row, skin_of(settings))
    if sampled:
        set_skin_samples(core, index, body, settings)
    return joints


def _add_parts(
    core: Any,
    model: Any,
    body: Body,
    prefix: str,
    index: int,
    row: Callable[[int], int],
    sampled: bool,
) -> list[int]:
    joints = []
    for part in body.variant.parts:
        if len(part.vertices) == 0:
            continue
        at = model.body(prefix + part.name).id
        collider = part_collider(part)
        core.add_shape(at, row(part.index), index, part.index, *collider.arrays)
        if sampled:
            set_part_samples(core, part)
        joints.append(part.index)
    return joints


def _add_skin(
    core: Any,
    model: Any,
    body: Body,
    prefix: str,
    index: int,
    row: Callable[[int], int],
    skin: SoftSkin | None,
) -> list[int]:
    joints = [int(part) for part in body.skin_corners.part]
    rows = {part: row(part) for part in set(joints)}
    shapes = _skin_shapes(body, model, addresses(model, prefix).body, skin)
    core.add_skin_shapes(shapes, index, np.array([rows[part] for part in joints], dtype=np.int32))
    return joints


class PersonSkin(_native.SkinShapes):
    """The skin of a person and its hulls as the core has them, with the arrays they are made of.

    Attributes:
        arrays: Arguments of `_native.SkinShapes`, by name.
    """

    def __init__(self, **arrays: Any) -> None:
        super().__init__(**arrays)
        self.arrays: Mapping[str, Any] = arrays


#: Of a body, by where a model has it: as the first person, the second, and so on.
_known: WeakKeyDictionary[Body, dict[bytes, PersonSkin]] = WeakKeyDictionary()
atexit.register(
    _known.clear
)  # the default body lives as long as the interpreter, the core does not
#: Places of one body that are remembered.
_PLACES = 4


def _skin_shapes(
    body: Body, model: Any, ids: NDArray[np.int64], soft: SoftSkin | None
) -> PersonSkin:
    """The skin and its hulls as the core has them, derived once per body and place in a model.

    Of soft skin, they are those of the hard core beneath.
    """
    numbers = np.stack([ids, model.body_dofadr[ids]]).astype(np.int32)
    known = _known.setdefault(body, {})
    key = numbers.tobytes() + (b"" if soft is None else soft.by_part()[0].tobytes())
    shapes = known.get(key)
    if shapes is None:
        while len(known) >= _PLACES:
            known.pop(next(iter(known)), None)
        rest, hulls = body.rest_vertices, body.skin_corners
        if soft is not None:
            rest = soft_core(body, soft).vertices
            # Samples are vertices that the skin's own hulls have.
            hulls = body.skin_hulls
        first, joint, weight = body.skin.sparse_weights
        shapes = known[key] = PersonSkin(
            body=numbers[0],
            dof=numbers[1],
            parent=np.ascontiguousarray(PARENTS, dtype=np.int32),
            joint=np.ascontiguousarray(body.rest_joints),
            rest=np.ascontiguousarray(rest),
            first=first,
            at=joint,
            weight=weight,
            bend=np.zeros((0, 3, 0)) if body.posedirs is None else body.posedirs,
            part=hulls.part.astype(np.int32),
            start=hulls.first.astype(np.int32),
            vertex=np.ascontiguousarray(hulls.vertex, dtype=np.int32),
        )
    return shapes
