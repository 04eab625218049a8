"""Proximity of vertices: of the skin to the items of a scene, of an object to the skin.

Parts whose bounding spheres are far from an item are not tested against it, and parts whose
spheres are far from all items are not skinned.
`tests/support/references/labels.py` has the same in plain numpy; the tests hold both equal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.progress import over
from halfphysics.base.short_repr import short_repr
from halfphysics.body import skinning
from halfphysics.labels.bounding_spheres import PartBalls, part_balls
from halfphysics.labels.item_solids import ItemSolids
from halfphysics.labels.sampling import ObjectSurface
from halfphysics.labels.soft_overlap import close_inside, with_sunk, with_swallowed

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]
Ints = NDArray[np.int32]

_CHUNK = 128  # frames skinned at a time


@dataclass(frozen=True, eq=False)
class Near:
    """Vertices near a surface: rows (n,), ordered by frame and vertex.

    Attributes:
        frame: Frame (n,).
        vertex: Vertex of the skin, or of the object (n,).
        distance: Distance [m] (n,).
        nearest: Vertex of the skin nearest to `point` (n,); empty for rows about the skin itself.
        point: Point of the skin nearest to an object's vertex (n, 3), in the world [m]; likewise.
    """

    frame: Ints
    vertex: Ints
    distance: Array
    nearest: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    point: Array = field(default_factory=lambda: np.zeros((0, 3)))

    __repr__ = short_repr

    def within(self, threshold: float) -> Near:
        """The rows with at most a distance [m]."""
        keep = self.distance <= threshold
        both = len(self.nearest) == len(keep)
        return Near(
            self.frame[keep],
            self.vertex[keep],
            self.distance[keep],
            self.nearest[keep] if both else self.nearest,
            self.point[keep] if both else self.point,
        )

    def __len__(self) -> int:
        return len(self.frame)

    @staticmethod
    def joined(rows: Sequence[Near]) -> Near:
        """Rows one after the other."""
        if not rows:
            return Near(*(np.zeros(0, dtype=np.int32),) * 2, np.zeros(0))
        return Near(
            *(
                np.concatenate([getattr(row, name) for row in rows])
                for name in ("frame", "vertex", "distance", "nearest", "point")
            )
        )


@dataclass(frozen=True, eq=False)
class Target:
    """An item whose proximity is computed.

    Attributes:
        item: Its collision geometry.
        reach: Largest distance of the skin's vertices from it [m].
        surface: Its own vertices, to be found within the same distance of the skin; None: none.
    """

    item: ItemSolids
    reach: float
    surface: ObjectSurface | None = None


def near(body: Body, motion: Motion, targets: Sequence[Target]) -> list[tuple[Near, Near]]:
    """For each target: the skin's vertices near it, and its own vertices near the skin."""
    if not targets:
        return []
    balls = part_balls(body)
    positions, quaternions = body.joint_frames(motion)
    centres, radii = balls.parts.at(motion.rotations, positions, quaternions)
    there = radii > -np.inf
    parts = [_close(t, there & t.item.parts, centres, radii) for t in targets]
    wanted = np.any(parts, axis=0)
    busy = np.flatnonzero(wanted.any(axis=1))
    some = _Some.of(body, balls, wanted.any(axis=0))
    found: list[tuple[list[Near], list[Near]]] = [([], []) for _ in targets]
    for first in over(range(0, len(busy), _CHUNK), "labels of contact", "frame", size=_CHUNK):
        frames = busy[first : first + _CHUNK]
        now = motion.rotations[frames], positions[frames], quaternions[frames]
        centres, radii = balls.clusters.at(*now, wanted[frames][:, balls.of])
        close = [
            _close(target, c[frames][:, balls.of], centres, radii, frames)
            for target, c in zip(targets, parts, strict=True)
        ]
        posed = skinning.skin(
            body.skin,
            *now,
            indices=some.vertex,
            wanted=(some.first, np.any(close, axis=0)),
        )
        for target, c, out in zip(targets, close, found, strict=True):
            if c.any():
                skin, surface = _asked(target, some, posed, frames, c, (body, motion))
                out[0].append(skin)
                out[1].append(surface)
    return [(Near.joined(a), Near.joined(b)) for a, b in found]


def _close(
    target: Target,
    asked: NDArray[np.bool_],
    centres: Array,
    radii: Array,
    frames: NDArray[np.intp] | None = None,
) -> NDArray[np.bool_]:
    """Whether groups (t, g) may be near an item, at some frames (t,)."""
    item, reach = target.item, target.reach
    if target.surface is not None:
        reach += target.surface.off
    close = np.array(asked, dtype=np.uint8, order="C")
    item.native.close(centres, radii, close, *item.at(frames), reach)
    found = close.view(np.bool_)
    if item.filled:
        every = np.arange(len(centres)) if frames is None else frames
        found = close_inside(item, centres, found, asked, every)
    return found


@dataclass(frozen=True, eq=False)
class _Some:
    """Some parts of a skin: their vertices (n,), cluster by cluster, where each cluster starts,
    and the faces (f, 3) of these vertices, by their place."""

    vertex: Ints
    first: Ints
    faces: Ints

    @staticmethod
    def of(body: Body, balls: PartBalls, parts: NDArray[np.bool_]) -> _Some:
        mine = parts[balls.of]
        vertex = balls.order[mine[balls.cluster[balls.order]]].astype(np.int32)
        first = np.searchsorted(balls.cluster[vertex], np.arange(len(mine) + 1)).astype(np.int32)
        place = np.zeros(len(balls.part), dtype=np.int32)
        place[vertex] = np.arange(len(vertex))
        a, b, c = mine[balls.corners]
        faces = place[body.faces[a & b & c]]
        return _Some(vertex, first, np.ascontiguousarray(faces))


def _asked(
    target: Target,
    some: _Some,
    posed: Array,
    frames: NDArray[np.intp],
    close: NDArray[np.bool_],
    whole: tuple[Body, Motion],
) -> tuple[Near, Near]:
    """Rows near an item: of vertices (t, n, 3) at some frames (t,) in close clusters (t, c).

    `whole`: the person, of whom the vertices are a part.
    """
    item, surface = target.item, target.surface
    position, turn = item.at(frames)
    skin, points = item.native.near(
        posed,
        some.first,
        np.ascontiguousarray(close, dtype=np.uint8),
        position,
        turn,
        target.reach,
        None if surface is None else surface.grid,
        0.0 if surface is None else surface.off,
        some.faces,
    )
    if item.filled:
        wanted = np.repeat(close, np.diff(some.first), axis=1)
        skin = with_sunk(item, posed, wanted, frames, skin)
    frame, vertex = frames[skin[0]].astype(np.int32), some.vertex[skin[1]]
    order = np.lexsort((vertex, frame))
    of_skin = Near(frame[order], vertex[order], skin[2][order])
    k, vertex, distance, nearest, point = points
    nearest = some.vertex[nearest]
    if item.soft and surface is not None:
        rows = k, vertex, distance, nearest, point
        skins = whole[0].vertices(whole[1], frames)
        k, vertex, distance, nearest, point = with_swallowed(
            item, surface.vertices, whole[0], skins, frames, rows
        )
    at = np.zeros_like(k) if item.still else k
    world = np.einsum("nij,nj->ni", turn[at], point) + position[at]
    of_points = Near(frames[k].astype(np.int32), vertex, distance, nearest, world)
    return of_skin, of_points
