"""Distances of a person's parts, and of objects, from what they touch, pose by pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics import rotations as rot
from halfphysics import skinning
from halfphysics.colliders import ConvexCollider, convex_collider
from halfphysics.metrics.inputs import Array
from halfphysics.metrics.part_gaps import part_gaps
from halfphysics.metrics.things import links_of
from halfphysics.shapes import Mesh, Plane

if TYPE_CHECKING:
    from halfphysics.motion import Motion
    from halfphysics.result import ObjectTrack, Result
    from halfphysics.things import Static

#: Distances are measured up to this, beyond it they are infinite [m].
RANGE = 0.1
_NONE = np.zeros((0, 3))
_CHUNK = 32  # poses skinned at a time


@dataclass(frozen=True)
class Triangles:
    """Triangles in the world: corners (F, 3, 3) [m]."""

    corners: Array

    @cached_property
    def boxes(self) -> tuple[Array, Array]:
        """Smallest and largest coordinates (F, 3) of every triangle."""
        return self.corners.min(axis=1), self.corners.max(axis=1)


#: What stands or moves is made of: half-spaces (normal (3,), offset), hulls and triangles.
Solid = tuple[Array, float] | ConvexCollider | Triangles


@dataclass(frozen=True, eq=False)
class Poses:
    """The poses of a result at some times: motions of the people, tracks of the objects."""

    result: Result
    motions: Sequence[Motion]
    tracks: Mapping[str, ObjectTrack]

    def distances(self, rows: NDArray[np.intp], at: NDArray[np.intp]) -> Array:
        """Distances (n,) [m] between the two sides of contacts `rows` (n,) in poses `at` (n,).

        0 or less where they meet; inf beyond `RANGE`.
        """
        contacts, found = self.result.contacts, np.full(len(rows), np.inf)
        plain = (contacts.part[rows] >= 0) & (contacts.other_part[rows] < 0)
        rest = np.flatnonzero(~plain)
        found[rest] = self._one_by_one(rows[rest], at[rest])
        for who, person in enumerate(self.result.people):
            for other in np.unique(contacts.other[rows[plain]]):
                mine = plain & (contacts.person[rows] == who) & (contacts.other[rows] == other)
                some, name = np.flatnonzero(mine), self.result.names[other]
                found[some] = part_gaps(
                    person.body,
                    self.motions[who],
                    self._is_skin,
                    self._gap_thing(name),
                    None if name in self._statics else self.tracks[name],
                    contacts.part[rows[some]],
                    at[some],
                    RANGE,
                )
        return found

    def _gap_thing(self, name: str) -> Any:
        """What touches of a static, an object or a link, for the core; worked out once."""
        if name not in self._gap_things:
            from halfphysics import _native

            thing = _native.GapThing()
            still = name in self._statics
            for solid in [self._statics[name]] if still else self._colliders(name):
                if isinstance(solid, ConvexCollider):
                    thing.add_hull(*solid.arrays)
                elif isinstance(solid, Triangles):
                    corners = np.ascontiguousarray(solid.corners.reshape(-1, 3))
                    thing.add_mesh(corners, np.arange(len(corners), dtype=np.int32).reshape(-1, 3))
                else:
                    thing.add_half_space(*solid)
            self._gap_things[name] = thing
        return self._gap_things[name]

    def _one_by_one(self, rows: NDArray[np.intp], at: NDArray[np.intp]) -> Array:
        """The same of whatever two sides, hull by hull."""
        contacts, found = self.result.contacts, np.full(len(rows), np.inf)
        order = np.argsort(at, kind="stable")
        frames, first = np.unique(at[order], return_index=True)
        ends = np.append(first[1:], len(order))
        for i in range(0, len(frames), _CHUNK):
            chunk = frames[i : i + _CHUNK]
            here = rows[order[first[i] : ends[min(i + _CHUNK, len(frames)) - 1]]]
            of_people = (contacts.part[here] >= 0) | (contacts.other_part[here] >= 0)
            skins = self._skins(chunk) if of_people.any() else []
            for k, frame in enumerate(chunk):
                for place in order[first[i + k] : ends[i + k]]:
                    row = rows[place]
                    part, other_part = int(contacts.part[row]), int(contacts.other_part[row])
                    mine = (
                        self._person(skins, k, int(contacts.person[row]), part)
                        if part >= 0
                        else self._object(self.result.names[contacts.subject[row]], int(frame))
                    )
                    other = int(contacts.other[row])
                    its = (
                        self._person(skins, k, other - self._first_person, other_part)
                        if other_part >= 0
                        else self._thing(self.result.names[other], int(frame))
                    )
                    found[place] = min((_distance(a, b) for a in mine for b in its), default=np.inf)
        return found

    @property
    def _first_person(self) -> int:
        return len(self.result.names) - len(self.result.people)

    @cached_property
    def _is_skin(self) -> bool:
        return self.result.settings.contact == "skin"

    def _skins(self, frames: NDArray[np.intp]) -> list[Any]:
        """Of everybody, in some frames: the skin (t, V, 3), or the joints' frames."""
        out: list[Any] = []
        for person, motion in zip(self.result.people, self.motions, strict=True):
            body = person.body
            if self._is_skin:
                out.append(body.vertices(motion, frames))
                continue
            root = motion.translation[frames] + motion.axes @ body.rest_joints[0]
            out.append(skinning.kinematics(motion.rotations[frames], root, body.rest_joints))
        return out

    def _person(self, skins: list[Any], k: int, who: int, part: int) -> list[ConvexCollider]:
        """The hulls of a person's part in the k-th of some frames."""
        body = self.result.people[who].body
        if not self._is_skin:
            positions, quaternions = skins[who]
            vertices = body.variant.parts[part].vertices
            placed = rot.rotate(quaternions[k, part], vertices) + positions[k, part]
            return [_hull(placed)] if len(vertices) else []
        hulls = body.skin_hulls
        pieces = [
            hulls.vertex[hulls.first[h] : hulls.first[h + 1]]
            for h in np.flatnonzero(hulls.part == part)
        ]
        return [_hull(skins[who][k][piece]) for piece in pieces]

    def _thing(self, name: str, frame: int) -> Sequence[Solid]:
        """What touches of a static, an object or a link, at a frame."""
        return [self._statics[name]] if name in self._statics else self._object(name, frame)

    def _object(self, name: str, frame: int) -> list[ConvexCollider]:
        """What touches of an object or a link, at a frame."""
        turn = rot.to_matrix(rot.normalize(self.tracks[name].quaternion[frame]))
        position = self.tracks[name].position[frame]
        return [collider.moved(turn, position) for collider in self._colliders(name)]

    def _colliders(self, name: str) -> list[ConvexCollider]:
        """The convex pieces of an object or a link, in its frame; worked out once."""
        if name not in self._known:
            scene = self.result.scene
            if name in scene.objects:
                pieces = [convex_collider(piece) for piece in scene.objects[name].pieces]
            else:
                pieces = [geom.collider() for geom in links_of(scene)[name][1].geoms]
            self._known[name] = pieces
        return self._known[name]

    @cached_property
    def _gap_things(self) -> dict[str, Any]:
        return {}

    @cached_property
    def _known(self) -> dict[str, list[ConvexCollider]]:
        return {}

    @cached_property
    def _statics(self) -> dict[str, Solid]:
        return {name: _placed(static) for name, static in self.result.scene.statics.items()}


def _placed(static: Static) -> Solid:
    """A static in the world."""
    turn, shape = rot.to_matrix(static.quaternion), static.shape
    if isinstance(shape, Plane):
        normal = turn @ np.asarray(shape.normal)
        return normal, float(shape.offset + normal @ static.position)
    if isinstance(shape, Mesh):
        return Triangles((shape.vertices @ turn.T + static.position)[shape.faces])
    return convex_collider(shape).moved(turn, np.asarray(static.position))


def _hull(vertices: Array) -> ConvexCollider:
    return ConvexCollider(vertices=np.ascontiguousarray(vertices), normals=_NONE)


def _distance(a: ConvexCollider, b: Solid) -> float:
    """Distance of a hull from anything [m], inf beyond `RANGE`."""
    from halfphysics import _native

    if isinstance(b, ConvexCollider):
        distance = float(_native.convex_distance(*a.arrays, *b.arrays)[0])
    elif isinstance(b, Triangles):
        low, high = a.vertices.min(axis=0), a.vertices.max(axis=0)
        reach = RANGE + a.radius + float(np.linalg.norm(a.rim))
        lows, highs = b.boxes
        near = ((lows <= high + reach) & (highs >= low - reach)).all(axis=1)
        if not near.any():
            return float("inf")
        corners = np.ascontiguousarray(b.corners[near].reshape(-1, 3))
        faces = np.arange(len(corners), dtype=np.int32).reshape(-1, 3)
        distance = float(
            _native.triangle_planes(corners, faces, a.vertices, a.radius, a.rim, RANGE)[1]
        )
    else:
        normal, offset = b
        across = float(a.rim @ a.rim - (a.rim @ normal) ** 2)
        lowest = (a.vertices @ normal).min() - a.radius - np.sqrt(max(across, 0.0))
        distance = float(lowest - offset)
    return distance if distance < RANGE else float("inf")
