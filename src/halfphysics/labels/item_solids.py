"""Collision geometry of a scene's items as solids, and distances of points from them.

An object collides by its convex pieces, a static by its own shape; round shapes are exact, not
triangulated. The distance from a solid is 0 inside it. A static mesh is a surface without an
inside, as in the simulation, but for a closed mesh that is soft: skin sinks into it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.copying import ReadOnly
from halfphysics.base.short_repr import short_repr
from halfphysics.errors import InputError
from halfphysics.geometry.shape_base import Shape
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere
from halfphysics.motion.skeleton import JOINT_NAMES, N_JOINTS
from halfphysics.scene.material_pairs import PERSON

if TYPE_CHECKING:
    from halfphysics.results.result import ObjectTrack
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Solid:
    """A shape that collides; `position` (3,) and `turn` (3, 3) of its frame in its item's frame.

    `surface`: a mesh collides by its triangles; else by its convex hull. `filled`: such a mesh has
    an inside.
    """

    shape: Shape
    position: Array
    turn: Array
    surface: bool = False
    filled: bool = False

    def inside(self, points: Array) -> NDArray[np.bool_]:
        """Whether points (n, 3) of its item's frame are inside a `filled` mesh (n,)."""
        if not self.filled or not isinstance(self.shape, Mesh):
            return np.zeros(len(points), dtype=bool)
        local = (points - self.position) @ self.turn
        low, high = self.shape.query.bounds
        found: NDArray[np.bool_] = ((local >= low) & (local <= high)).all(axis=1)
        found[found] = self.shape.query.enclosed(local[found])
        return found

    def add_to(self, item: Any) -> None:
        """Add it to a `TouchingThing` of the core."""
        turn, place = np.ascontiguousarray(self.turn), np.ascontiguousarray(self.position)
        shape = self.shape
        if isinstance(shape, Plane):
            item.add_plane(turn, place, np.array(shape.normal), shape.offset)
        elif isinstance(shape, Box):
            item.add_box(turn, place, 0.5 * np.array(shape.size))
        elif isinstance(shape, Sphere):
            item.add_capsule(turn, place, shape.radius, 0.0)
        elif isinstance(shape, Capsule):
            item.add_capsule(turn, place, shape.radius, 0.5 * shape.length)
        elif isinstance(shape, Cylinder):
            item.add_cylinder(turn, place, shape.radius, 0.5 * shape.length)
        elif isinstance(shape, Mesh):
            mesh = shape if self.surface else shape.hull
            planes = np.zeros((0, 4)) if self.surface else face_planes(mesh)
            item.add_triangles(turn, place, mesh.query.tree, planes)
        else:
            raise InputError(f"labels: found a {type(shape).__name__}, expected a known shape")


@dataclass(frozen=True, eq=False)
class ItemSolids(ReadOnly):
    """A static, an object or a link: its collision geometry and its poses.

    Attributes:
        name: As in `Result.names`.
        solids: The collision geometry in its frame.
        position: Of its frame in the world (T, 3) [m]; (1, 3) if it never moves.
        turn: World from its frame (T, 3, 3) or (1, 3, 3).
        stands: Whether it is a static, or a link that no joint moves.
        parts: Parts of a person that collide with it (55,): all but those the scene ignores.
        soft: Whether it gives way: its solids are the surface that nothing presses.
    """

    _REBUILT: ClassVar[frozenset[str]] = frozenset({"native"})

    name: str
    solids: tuple[Solid, ...]
    position: Array
    turn: Array
    stands: bool
    parts: NDArray[np.bool_]
    soft: bool = False

    __repr__ = short_repr

    @property
    def still(self) -> bool:
        """Whether it has one pose for all frames."""
        return len(self.position) == 1

    def at(self, frames: NDArray[np.integer] | None = None) -> tuple[Array, Array]:
        """Position (t, 3) and turn (t, 3, 3) at some frames, None: all; one row if `still`."""
        some = slice(None) if self.still or frames is None else frames
        return np.ascontiguousarray(self.position[some]), np.ascontiguousarray(self.turn[some])

    @cached_property
    def native(self) -> Any:
        """The same for the core: `TouchingThing`."""
        from halfphysics import _native

        found = _native.TouchingThing()
        for solid in self.solids:
            solid.add_to(found)
        return found

    def distance(self, points: Array) -> Array:
        """Distances (n,) [m] of points (n, 3) in its frame; 0 inside, inf without a solid."""
        found = np.array(self.native.distance(np.ascontiguousarray(points)))
        if self.filled:
            found[self.inside(points)] = 0.0
        return found

    @property
    def filled(self) -> bool:
        """Whether it has meshes with an inside that the core does not know."""
        return any(solid.filled for solid in self.solids)

    def inside(self, points: Array) -> NDArray[np.bool_]:
        """Whether points (n, 3) in its frame are inside a filled mesh (n,)."""
        found = np.zeros(len(points), dtype=bool)
        for solid in self.solids:
            found |= solid.inside(points)
        return found


def item_solids(scene: Scene, tracks: Mapping[str, ObjectTrack]) -> tuple[ItemSolids, ...]:
    """The statics, objects and links of a scene, in its order.

    Args:
        scene: As simulated.
        tracks: Of objects and links, as in ``result.objects``.
    """
    found: list[tuple[str, str, tuple[Solid, ...], Array, Array, bool]] = []
    for name, static in scene.statics.items():
        solid = _surface(static.shape, static.soft is not None, isinstance(static.shape, Mesh))
        turn = rot.to_matrix(static.quaternion)
        found.append((name, name, (solid,), static.position[None], turn[None], True))
    for name, item in scene.objects.items():
        # What is touched of a soft object is its surface, not the pieces of its frame.
        shapes = item.pieces if item.soft is None else (item.true_shape,)
        soft = item.soft is not None
        pieces = tuple(
            _surface(s, soft, soft and isinstance(s, Mesh) and not s.is_convex) for s in shapes
        )
        found.append((name, name, pieces, *_poses(tracks[name]), False))
    for whole in scene.articulated.values():
        for name, link in zip(whole.link_names, whole.links, strict=True):
            geoms = tuple(
                Solid(geom.shape, np.asarray(geom.position), rot.to_matrix(geom.quaternion))
                for geom in link.geoms
            )
            position, turn = _poses(tracks[name])
            if link.fixed:
                position, turn = position[:1], turn[:1]
            found.append((name, whole.name, geoms, position, turn, link.fixed))
    return tuple(
        ItemSolids(
            name, solids, position, turn, stands, _touched(scene, owner), _is_soft(scene, name)
        )
        for name, owner, solids, position, turn, stands in found
    )


def _surface(shape: Shape, soft: bool, by_triangle: bool) -> Solid:
    """A shape in its item's frame."""
    filled = soft and by_triangle and isinstance(shape, Mesh) and shape.closed
    return Solid(shape, np.zeros(3), np.eye(3), by_triangle, filled)


def _is_soft(scene: Scene, name: str) -> bool:
    item = scene.statics.get(name) or scene.objects.get(name)
    return item is not None and item.soft is not None


def _touched(scene: Scene, owner: str) -> NDArray[np.bool_]:
    if not any(owner in pair for pair in scene.ignored_pairs):
        return np.ones(N_JOINTS, dtype=bool)
    if scene.ignores(owner, PERSON):
        return np.zeros(N_JOINTS, dtype=bool)
    return np.array([not scene.ignores(owner, f"{PERSON}/{joint}") for joint in JOINT_NAMES])


def _poses(track: ObjectTrack) -> tuple[Array, Array]:
    return track.position, rot.to_matrix(rot.normalize(track.quaternion))


def face_planes(hull: Mesh) -> Array:
    """Outward unit normal and offset (F, 4) of every face of a convex mesh."""
    corners = hull.vertices[hull.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = normal[length[:, 0] > 0.0] / length[length[:, 0] > 0.0]
    # The largest offset over all vertices: the hull is behind every plane despite rounding.
    offset = (hull.vertices @ normal.T).max(axis=0)
    return np.ascontiguousarray(np.concatenate([normal, offset[:, None]], axis=1))
