"""Distances of a person's parts from items, in batches: hulls of the skin, or rigid parts."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.progress import over
from halfphysics.body import skinning
from halfphysics.metrics.argument_checks import Array

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import ObjectTrack

_CHUNK = 64  # poses at a time
Whole = NDArray[np.integer]


def part_gaps(
    body: Body,
    motion: Motion,
    skin: bool,
    item: Any,
    track: ObjectTrack | None,
    part: Whole,
    at: Whole,
    reach: float,
    *,
    still: bool = False,
) -> Array:
    """Distances (n,) [m] of parts (n,) of a person from an item in poses `at` (n,).

    0 or less if they overlap; inf beyond `reach`.

    Args:
        body, motion: Of the person.
        skin: Measure the skin's hulls, not the rigid parts.
        item: The item's collision geometry, made by the core.
        track: Its poses; None: it is static.
        part, at: Parts and poses (n,).
        reach: Largest distance that is measured [m].
        still: Measure in the item's frame: the core moves hulls, but no triangles.
    """
    found = np.full(len(at), np.inf)
    frames = np.unique(at)
    for first in over(range(0, len(frames), _CHUNK), "distances of parts", "frame", size=_CHUNK):
        chunk = frames[first : first + _CHUNK]
        here = np.flatnonzero((at >= chunk[0]) & (at <= chunk[-1]))
        parts, its = np.unique(part[here], return_inverse=True)
        pose = np.searchsorted(chunk, at[here]).astype(np.int32)
        x, q = _joints(body, motion, chunk)
        if skin:
            wanted = np.zeros((len(chunk), len(parts)), dtype=bool)
            wanted[pose, its] = True
            posed, of_part, starts, corner = _skin(
                body, (motion.rotations[chunk], x, q), parts, wanted
            )
        else:
            posed, of_part, starts, corner = _rigid(body, x, q, parts)
        position, turn = np.zeros((len(chunk), 3)), np.tile(np.eye(3), (len(chunk), 1, 1))
        if track is not None:
            position = np.ascontiguousarray(track.position[chunk])
            turn = rot.to_matrix(rot.normalize(track.quaternion[chunk]))
        if still and track is not None:
            posed = np.ascontiguousarray((posed - position[:, None]) @ turn)
            position, turn = np.zeros((len(chunk), 3)), np.tile(np.eye(3), (len(chunk), 1, 1))
        found[here] = item.gaps(
            posed,
            pose,
            np.searchsorted(of_part, part[here], side="left").astype(np.int32),
            np.searchsorted(of_part, part[here], side="right").astype(np.int32),
            starts,
            corner,
            position,
            turn,
            reach,
        )
    return found


#: Points (t, n, 3) in the world, of every hull its part (h,), ascending, where its corners start
#: (h + 1,), and the corners: places among the points.
Posed = tuple[Array, Whole, NDArray[np.int32], NDArray[np.int32]]


def _joints(body: Body, motion: Motion, frames: Whole) -> tuple[Array, Array]:
    root = motion.translation[frames] + motion.axes @ body.rest_joints[0]
    return skinning.kinematics(motion.rotations[frames], root, body.rest_joints)


def _skin(
    body: Body, moved: tuple[Array, Array, Array], parts: Whole, wanted: NDArray[np.bool_]
) -> Posed:
    """The skin's hulls of parts; points are valid where their part is `wanted` (t, parts)."""
    hulls = body.skin_hulls
    vertices, of_part, corners, first = [], [], [], [0]
    for part in parts:
        some = np.flatnonzero(hulls.part == part)
        pieces = [hulls.vertex[hulls.first[h] : hulls.first[h + 1]] for h in some]
        vertex = np.unique(np.concatenate([np.zeros(0, dtype=np.int32), *pieces]))
        corners += [first[-1] + np.searchsorted(vertex, piece) for piece in pieces]
        of_part.append(hulls.part[some])
        vertices.append(vertex)
        first.append(first[-1] + len(vertex))
    posed = skinning.skin(
        body.skin,
        *moved,
        indices=np.concatenate(vertices),
        wanted=(np.array(first, dtype=np.int32), wanted),
    )
    return posed, np.concatenate(of_part), *_listed(corners)


def _rigid(body: Body, x: Array, q: Array, parts: Whole) -> Posed:
    corner: Mapping[int, Array] = {int(p): body.variant.parts[p].vertices for p in parts}
    some = [p for p, vertices in corner.items() if len(vertices)]
    placed = [rot.rotate(q[:, p, None], corner[p]) + x[:, p, None] for p in some]
    posed = np.concatenate([np.zeros((len(x), 0, 3)), *placed], axis=1)
    ends = np.cumsum([0, *(len(corner[p]) for p in some)])
    corners = [np.arange(a, b) for a, b in itertools.pairwise(ends)]
    return posed, np.array(some, dtype=np.int64), *_listed(corners)


def _listed(corners: list[NDArray[Any]]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    starts = np.cumsum([0, *(len(c) for c in corners)]).astype(np.int32)
    return starts, np.concatenate([np.zeros(0, dtype=np.int32), *corners]).astype(np.int32)
