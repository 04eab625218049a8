"""Distances of a person's parts, and of objects, from the items they touch, pose by pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.progress import over
from halfphysics.body import skinning
from halfphysics.geometry.colliders import ConvexCollider, convex_collider
from halfphysics.geometry.shapes import Mesh, Plane
from halfphysics.metrics.argument_checks import Array
from halfphysics.metrics.part_gaps import part_gaps
from halfphysics.metrics.scene_solids import known_contacts, links_of

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import ObjectTrack, Result
    from halfphysics.scene.items import Static

#: Distances are measured up to this, beyond it they are infinite [m].
RANGE = 0.1
_NONE = np.zeros((0, 3))
_CHUNK = 32  # poses skinned at a time


@dataclass(frozen=True)
class Triangles:
    """Triangles in the world: corners (F, 3, 3) [m]."""

    corners: Array


#: Collision geometry: a half-space (normal (3,), offset), a hull or triangles.
Solid = tuple[Array, float] | ConvexCollider | Triangles


@dataclass(frozen=True, eq=False)
class Poses:
    """The poses of a result at some times: motions of the people, tracks of the objects."""

    result: Result
    motions: Sequence[Motion]
    tracks: Mapping[str, ObjectTrack]

    def distances(self, rows: NDArray[np.intp], at: NDArray[np.intp]) -> Array:
        """Distances (n,) [m] between the two sides of contacts `rows` (n,) in poses `at` (n,).

        0 or less if they overlap; inf beyond `RANGE`, and from what the scene does not have.
        """
        contacts, found = self.result.contacts, np.full(len(rows), np.inf)
        item = (contacts.other_part[rows] < 0) & known_contacts(self.result)[rows]
        rest = np.flatnonzero(contacts.other_part[rows] >= 0)
        found[rest] = self._between_people(rows[rest], at[rest])
        # Group the rows by pair: a person or (with a larger index) an object, and an item.
        subject, first = contacts.subject[rows], len(self.result.names)
        mine = np.where(subject >= 0, subject, first + contacts.person[rows])
        for side, other in {*zip(mine[item].tolist(), contacts.other[rows[item]], strict=True)}:
            some = np.flatnonzero(item & (mine == side) & (contacts.other[rows] == other))
            name = self.result.names[other]
            if side < first:
                found[some] = self._between(self.result.names[side], name, at[some])
                continue
            found[some] = part_gaps(
                self.result.people[side - first].body,
                self.motions[side - first],
                self._is_skin,
                self._gap_item(name),
                None if name in self._statics else self.tracks[name],
                contacts.part[rows[some]],
                at[some],
                RANGE,
                still=_is_mesh(self._solids(name)),
            )
            if self._filled(name) is not None:
                apart = some[found[some] > 0.0]
                sunk = self._parts_within(side - first, contacts.part[rows[apart]], name, at[apart])
                found[apart[sunk]] = 0.0
        return found

    def _between(self, name: str, other: str, at: NDArray[np.intp]) -> Array:
        """Distances (n,) of an object from a static, an object or a link in poses `at` (n,)."""
        if _is_mesh(self._solids(name)) and _has_hulls(self._solids(other)):
            name, other = other, name
        mine, its = self._places(name, at), self._places(other, at)
        if other in self.tracks and _is_mesh(self._solids(other)):
            # The core holds a mesh still: the other side moves past it.
            position, turn = its
            back = np.swapaxes(turn, 1, 2)
            place = np.einsum("nij,nj->ni", back, mine[0] - position)
            mine = np.ascontiguousarray(place), np.ascontiguousarray(back @ mine[1])
            its = np.zeros((len(at), 3)), np.tile(np.eye(3), (len(at), 1, 1))
        item = self._gap_item(name, by_triangle=_is_mesh(self._solids(name)))
        found = np.array(item.between(*mine, self._gap_item(other), *its, RANGE))
        for one, another in ((name, other), (other, name)):
            if self._filled(another) is not None:
                apart = np.flatnonzero(found > 0.0)
                found[apart[self._item_within(one, another, at[apart])]] = 0.0
        return found

    def _parts_within(
        self, side: int, part: NDArray[np.integer], name: str, at: NDArray[np.intp]
    ) -> NDArray[np.bool_]:
        """Whether parts (n,) that do not cross a filled mesh are inside it, in poses `at` (n,).

        What does not cross a surface is inside it with any of its points: one of each hull is
        looked at.
        """
        found = np.zeros(len(at), dtype=bool)
        frames = np.unique(at)
        for i in range(0, len(frames), _CHUNK):
            chunk = frames[i : i + _CHUNK]
            here = np.flatnonzero((at >= chunk[0]) & (at <= chunk[-1]))
            skins = self._skins(chunk)
            hulls = [
                self._person(skins, np.searchsorted(chunk, at[n]), side, part[n]) for n in here
            ]
            row = np.repeat(here, [len(its) for its in hulls])
            points = np.array([hull.vertices[0] for its in hulls for hull in its]).reshape(-1, 3)
            found[row[self._within(name, points, at[row])]] = True
        return found

    def _item_within(self, name: str, other: str, at: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Whether an item that does not cross a filled mesh is inside it, in poses `at` (n,)."""
        found = np.zeros(len(at), dtype=bool)
        position, turn = self._places(name, at)
        for solid in self._solids(name):
            if isinstance(solid, tuple):  # a half-space has no end
                continue
            corner = solid.corners[0, 0] if isinstance(solid, Triangles) else solid.vertices[0]
            found |= self._within(other, turn @ corner + position, at)
        return found

    def _within(self, name: str, points: Array, at: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Whether points (n, 3) in the world are inside a filled mesh in poses `at` (n,)."""
        mesh = self._filled(name)
        if mesh is None or not len(points):
            return np.zeros(len(points), dtype=bool)
        static = self.result.scene.statics.get(name)
        if static is None:
            position, turn = self._places(name, at)
        else:
            position, turn = static.position, rot.to_matrix(static.quaternion)[None]
        local = np.einsum("nj,njk->nk", points - position, np.broadcast_to(turn, (len(at), 3, 3)))
        return mesh.query.enclosed(local)

    def _places(self, name: str, at: NDArray[np.intp]) -> tuple[Array, Array]:
        """Positions (n, 3) and turns (n, 3, 3) of an item; the world frame for a static."""
        if name in self._statics:
            return np.zeros((len(at), 3)), np.tile(np.eye(3), (len(at), 1, 1))
        track = self.tracks[name]
        turn = rot.to_matrix(rot.normalize(track.quaternion[at]))
        return np.ascontiguousarray(track.position[at]), np.ascontiguousarray(turn)

    def _gap_item(self, name: str, *, by_triangle: bool = False) -> Any:
        """Collision geometry of a static, an object or a link for the core; computed once.

        `by_triangle`: a mesh as one hull a triangle, since only hulls are measured from others.
        """
        if (name, by_triangle) not in self._gap_items:
            from halfphysics import _native

            item = _native.GapThing()
            for solid in self._solids(name):
                if isinstance(solid, ConvexCollider):
                    item.add_hull(*solid.arrays)
                elif isinstance(solid, Triangles) and by_triangle:
                    for corners in solid.corners:
                        item.add_hull(*_hull(corners).arrays)
                elif isinstance(solid, Triangles):
                    corners = np.ascontiguousarray(solid.corners.reshape(-1, 3))
                    item.add_mesh(corners, np.arange(len(corners), dtype=np.int32).reshape(-1, 3))
                else:
                    item.add_half_space(*solid)
            self._gap_items[name, by_triangle] = item
        return self._gap_items[name, by_triangle]

    def _between_people(self, rows: NDArray[np.intp], at: NDArray[np.intp]) -> Array:
        """Distances (n,) of parts from parts, their own person's or another's, hull by hull."""
        contacts, found = self.result.contacts, np.full(len(rows), np.inf)
        order = np.argsort(at, kind="stable")
        frames, first = np.unique(at[order], return_index=True)
        ends = np.append(first[1:], len(order))
        for i in over(range(0, len(frames), _CHUNK), "distances of people", "frame", size=_CHUNK):
            chunk = frames[i : i + _CHUNK]
            skins = self._skins(chunk)
            for k in range(len(chunk)):
                for place in order[first[i + k] : ends[i + k]]:
                    row = rows[place]
                    other = int(contacts.other[row]) - self._first_person
                    mine = self._person(skins, k, int(contacts.person[row]), contacts.part[row])
                    its = self._person(skins, k, other, contacts.other_part[row])
                    found[place] = min((_distance(a, b) for a in mine for b in its), default=np.inf)
        return found

    @property
    def _first_person(self) -> int:
        return len(self.result.names) - len(self.result.people)

    @cached_property
    def _is_skin(self) -> bool:
        return self.result.settings.contact == "skin"

    def _skins(self, frames: NDArray[np.intp]) -> list[Any]:
        """For all people, in some frames: the skin (t, V, 3), or the joints' frames."""
        out: list[Any] = []
        for person, motion in zip(self.result.people, self.motions, strict=True):
            body = person.body
            if self._is_skin:
                out.append(body.vertices(motion, frames))
                continue
            root = motion.translation[frames] + motion.axes @ body.rest_joints[0]
            out.append(skinning.kinematics(motion.rotations[frames], root, body.rest_joints))
        return out

    def _person(self, skins: list[Any], k: int, side: int, part: int) -> list[ConvexCollider]:
        """The hulls of a person's part in the k-th of some frames."""
        body = self.result.people[side].body
        if not self._is_skin:
            positions, quaternions = skins[side]
            vertices = body.variant.parts[part].vertices
            placed = rot.rotate(quaternions[k, part], vertices) + positions[k, part]
            return [_hull(placed)] if len(vertices) else []
        hulls = body.skin_hulls
        pieces = [
            hulls.vertex[hulls.first[h] : hulls.first[h + 1]]
            for h in np.flatnonzero(hulls.part == part)
        ]
        return [_hull(skins[side][k][piece]) for piece in pieces]

    def _solids(self, name: str) -> Sequence[Solid]:
        """A static in the world; the pieces of an object or a link in its frame.

        Of what is soft, the surface that nothing presses: its hard frame touches nothing.
        """
        if name in self._statics:
            return [self._statics[name]]
        if name not in self._pieces:
            self._pieces[name] = self._solids_of(name)
        return self._pieces[name]

    def _solids_of(self, name: str) -> Sequence[Solid]:
        scene = self.result.scene
        item = scene.objects.get(name)
        if item is None:
            return [geom.collider() for geom in links_of(scene)[name][1].geoms]
        if item.soft is None:
            return [convex_collider(piece) for piece in item.pieces]
        shape = item.true_shape
        if isinstance(shape, Mesh) and not shape.is_convex:
            return [Triangles(shape.vertices[shape.faces])]
        return [convex_collider(shape)]

    def _filled(self, name: str) -> Mesh | None:
        """The closed mesh of something soft that is measured by its triangles; None: it is not."""
        scene = self.result.scene
        item = scene.statics.get(name) or scene.objects.get(name)
        if item is None or item.soft is None or not _is_mesh(self._solids(name)):
            return None
        shape = item.true_shape
        return shape if isinstance(shape, Mesh) and shape.closed else None

    @cached_property
    def _gap_items(self) -> dict[tuple[str, bool], Any]:
        return {}

    @cached_property
    def _pieces(self) -> dict[str, Sequence[Solid]]:
        return {}

    @cached_property
    def _statics(self) -> dict[str, Solid]:
        return {name: _placed(static) for name, static in self.result.scene.statics.items()}


def _is_mesh(solids: Sequence[Solid]) -> bool:
    """Whether an item is measured by its triangles."""
    return any(isinstance(solid, Triangles) for solid in solids)


def _has_hulls(solids: Sequence[Solid]) -> bool:
    return any(isinstance(solid, ConvexCollider) for solid in solids)


def _placed(static: Static) -> Solid:
    """A static in the world: of a soft one the surface that nothing presses."""
    turn, shape = rot.to_matrix(static.quaternion), static.shape
    if isinstance(shape, Plane):
        normal = turn @ np.asarray(shape.normal)
        return normal, float(shape.offset + normal @ static.position)
    if isinstance(shape, Mesh):
        return Triangles((shape.vertices @ turn.T + static.position)[shape.faces])
    return convex_collider(shape).moved(turn, np.asarray(static.position))


def _hull(vertices: Array) -> ConvexCollider:
    return ConvexCollider(vertices=np.ascontiguousarray(vertices), normals=_NONE)


def _distance(a: ConvexCollider, b: ConvexCollider) -> float:
    """Distance of two hulls [m], inf beyond `RANGE`."""
    from halfphysics import _native

    distance = float(_native.convex_distance(*a.arrays, *b.arrays)[0])
    return distance if distance < RANGE else float("inf")
