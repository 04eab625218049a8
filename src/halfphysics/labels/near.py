"""Which vertices are near what: of the skin to the things of a scene, of an object to the skin.

Parts whose ball is far from a thing are not looked at, frames in which nothing is near are not
skinned. `reference.py` says the same slowly; the tests hold both equal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.labels.part_balls import PartBalls, part_balls
from halfphysics.labels.sampling import ObjectSurface
from halfphysics.labels.solids import Thing

if TYPE_CHECKING:
    from halfphysics.body import Body
    from halfphysics.motion import Motion

Array = NDArray[np.float64]
Ints = NDArray[np.int32]

_CHUNK = 64  # frames skinned at a time

#: An edge of the skin is taken to be never longer than this many times its length at rest.
STRETCH = 2.0


@dataclass(frozen=True, eq=False)
class Near:
    """Vertices near something: rows (n,), ordered by frame and vertex.

    Attributes:
        frame: (n,).
        vertex: Of the skin, or of the object (n,).
        distance: [m] (n,).
        nearest: Vertex of the skin nearest to where an object's vertex is nearest (n,); of rows
            about the skin itself empty.
        point: That nearest point of the skin (n, 3), in the world [m]; likewise.
    """

    frame: Ints
    vertex: Ints
    distance: Array
    nearest: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int32))
    point: Array = field(default_factory=lambda: np.zeros((0, 3)))

    def within(self, threshold: float) -> Near:
        """The rows at most so far away [m]."""
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
    """A thing that vertices may be near to.

    Attributes:
        thing: What touches.
        reach: Vertices of the skin up to this far from it are asked for [m].
        surface: Its own vertices up to this far from the skin are asked for too; None: not.
    """

    thing: Thing
    reach: float
    surface: ObjectSurface | None = None


def near(body: Body, motion: Motion, targets: Sequence[Target]) -> list[tuple[Near, Near]]:
    """Of a person and each target: the vertices of the skin near it, and its own near the skin."""
    balls = part_balls(body)
    centres, radii = balls.at(body, motion)
    skin = _Skin(body, balls)
    # Of a target with vertices more skin is asked for: a face is near where a corner may not be.
    slack = skin.slack.max(initial=0.0)
    asked = [t.reach + (0.0 if t.surface is None else t.surface.off + slack) for t in targets]
    close = [
        _close(target.thing, centres, radii, reach)
        for target, reach in zip(targets, asked, strict=True)
    ]
    found: list[tuple[list[Near], list[Near]]] = [([], []) for _ in targets]
    if not targets:
        return []
    busy = np.flatnonzero(np.any([c.any(axis=1) for c in close], axis=0))
    for first in range(0, len(busy), _CHUNK):
        frames = busy[first : first + _CHUNK]
        parts = np.any([c[frames].any(axis=0) for c in close], axis=0)
        index = skin.around(parts)
        posed = body.vertices(motion, frames, indices=index)
        for target, reach, c, out in zip(targets, asked, close, found, strict=True):
            rows = _skin_rows(target.thing, reach, c[frames], frames, index, posed, balls.part)
            out[0].append(rows.within(target.reach))
            if target.surface is not None and len(rows):
                out[1].extend(skin.faces_near(target, target.surface, rows, frames, index, posed))
    return [(Near.joined(a), Near.joined(b)) for a, b in found]


def _close(thing: Thing, centres: Array, radii: Array, reach: float) -> NDArray[np.bool_]:
    """In which frames (T,) which parts (55,) may be so near a thing."""
    count, parts = radii.shape
    close = (radii > -np.inf) & thing.parts
    # A ball around each solid first: it is a few operations, whatever the shape.
    at = np.zeros((count, parts), dtype=bool)
    for solid in thing.solids:
        middle, radius = solid.ball
        place = np.einsum("tij,j->ti", thing.turn, middle) + thing.position
        apart = np.linalg.norm(centres - place[:, None], axis=2)
        at |= apart <= radii + radius + reach
    close &= at
    frame, part = np.nonzero(close)
    if len(frame):
        distance = thing.distance(thing.local(centres[frame, part], frame))
        close[frame, part] = distance <= radii[frame, part] + reach
    return close


def _skin_rows(
    thing: Thing,
    reach: float,
    close: NDArray[np.bool_],
    frames: NDArray[np.intp],
    index: NDArray[np.intp],
    posed: Array,
    part: NDArray[np.int64],
) -> Near:
    """Vertices `index` (n,) of near parts, posed (t, n, 3), at most `reach` from a thing."""
    k, v = np.nonzero(close[:, part[index]])
    distance = thing.distance(thing.local(posed[k, v], frames[k]))
    keep = distance <= reach
    frame, vertex = frames[k[keep]].astype(np.int32), index[v[keep]].astype(np.int32)
    return Near(frame, vertex, distance[keep])


class _Skin:
    """The faces of a skin, and which are near what."""

    def __init__(self, body: Body, balls: PartBalls) -> None:
        self.faces, self.part = body.faces, balls.part
        count = len(body.rest_vertices)
        corner = self.faces.ravel()
        edges = body.rest_vertices[self.faces] - body.rest_vertices[np.roll(self.faces, 1, axis=1)]
        longest = np.linalg.norm(edges, axis=2).max(axis=1, initial=0.0)
        # No point of a triangle is farther from its corners than its longest edge by root 3.
        self.face_slack = STRETCH * longest / np.sqrt(3.0)
        self.slack = np.zeros(count)
        np.maximum.at(self.slack, corner, np.repeat(self.face_slack, 3))
        order = np.argsort(corner, kind="stable")
        self._first = np.searchsorted(corner[order], np.arange(count + 1))
        self._face = order // 3

    def around(self, parts: NDArray[np.bool_]) -> NDArray[np.intp]:
        """The vertices of some parts, and of faces that reach into them, ascending."""
        mine = parts[self.part]
        every = mine.copy()
        every[self.faces[mine[self.faces].any(axis=1)]] = True
        return np.flatnonzero(every)

    def faces_near(
        self,
        target: Target,
        surface: ObjectSurface,
        rows: Near,
        frames: NDArray[np.intp],
        index: NDArray[np.intp],
        posed: Array,
    ) -> list[Near]:
        """Vertices of an object near faces of which a corner is among `rows`, frame by frame."""
        from halfphysics import _native

        thing, found = target.thing, []
        keep = rows.distance <= target.reach + surface.off + self.slack[rows.vertex]
        rows = Near(rows.frame[keep], rows.vertex[keep], rows.distance[keep])
        place = np.zeros(len(self.part), dtype=np.int32)
        place[index] = np.arange(len(index))
        starts = np.searchsorted(rows.frame, frames, side="left")
        ends = np.searchsorted(rows.frame, frames, side="right")
        for k, frame in enumerate(frames):
            corners = rows.vertex[starts[k] : ends[k]]
            if not len(corners):
                continue
            faces = self.faces[self._faces_of(corners)]
            faces = faces[thing.parts[self.part[faces]].all(axis=1)]
            used, local = np.unique(faces, return_inverse=True)
            skin = posed[k, place[used]]
            skin = thing.local(skin, np.full(len(skin), frame))
            low, high = skin.min(axis=0) - target.reach, skin.max(axis=0) + target.reach
            inside = ((surface.vertices >= low) & (surface.vertices <= high)).all(axis=1)
            vertex = np.flatnonzero(inside)
            if not len(vertex):
                continue
            tree = _native.TriangleTree(
                np.ascontiguousarray(skin), local.reshape(-1, 3).astype(np.int32)
            )
            distance, face, point = tree.distance(np.ascontiguousarray(surface.vertices[vertex]))
            keep = distance <= target.reach
            face, point = faces[face[keep]], point[keep]
            apart = np.linalg.norm(
                skin[np.searchsorted(used, face)] - point[:, None], axis=2
            ).argmin(axis=1)
            at = 0 if len(thing.position) == 1 else frame
            found.append(
                Near(
                    np.full(keep.sum(), frame, dtype=np.int32),
                    vertex[keep].astype(np.int32),
                    distance[keep],
                    face[np.arange(len(face)), apart].astype(np.int32),
                    point @ thing.turn[at].T + thing.position[at],
                )
            )
        return found

    def _faces_of(self, vertices: Ints) -> NDArray[np.intp]:
        """Faces with a corner among some vertices."""
        first, count = self._first[vertices], np.diff(self._first)[vertices]
        offset = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        return np.unique(self._face[np.repeat(first, count) + offset])
