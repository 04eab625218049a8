"""What physically touches of a scene, solid by solid, and how far points are from it.

An object touches by its convex pieces, a static by its own shape: round shapes are round here,
nothing is triangulated. The distance of a solid is 0 inside it; a static mesh is a surface, as it
is for the simulation, and has no inside.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics import rotations as rot
from halfphysics.pairs import PERSON
from halfphysics.shape_base import Shape
from halfphysics.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere
from halfphysics.skeleton import JOINT_NAMES, N_JOINTS

if TYPE_CHECKING:
    from halfphysics.result import ObjectTrack
    from halfphysics.scene import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Solid:
    """A shape that touches; `position` (3,) and `turn` (3, 3) of its frame in its thing's.

    `surface`: a mesh that touches by its triangles as they are; else it is its convex hull.
    """

    shape: Shape
    position: Array
    turn: Array
    surface: bool = False

    def distance(self, points: Array) -> Array:
        """Distances (n,) [m] of points (n, 3) in the thing's frame."""
        return self._measure((points - self.position) @ self.turn)

    @cached_property
    def _measure(self) -> Callable[[Array], Array]:
        shape = self.shape
        if isinstance(shape, Plane):
            normal = np.asarray(shape.normal)
            return lambda p: np.maximum(p @ normal - shape.offset, 0.0)
        if isinstance(shape, Box):
            half = 0.5 * np.asarray(shape.size)
            return lambda p: _length(np.maximum(np.abs(p) - half, 0.0))
        if isinstance(shape, Sphere):
            return lambda p: np.maximum(_length(p) - shape.radius, 0.0)
        if isinstance(shape, Capsule):
            return lambda p: np.maximum(_from_axis(p, 0.5 * shape.length) - shape.radius, 0.0)
        if isinstance(shape, Cylinder):
            return lambda p: _outside_cylinder(p, shape.radius, 0.5 * shape.length)
        if not isinstance(shape, Mesh):
            raise TypeError(f"no distance of a {type(shape).__name__}")
        if self.surface:
            return lambda p: shape.query.closest(p)[0] if len(p) else np.zeros(0)
        return _outside_hull(shape.hull)

    @cached_property
    def ball(self) -> tuple[Array, float]:
        """Centre (3,) in the thing's frame and radius [m] of a ball around it; inf: a plane."""
        if isinstance(self.shape, Plane):
            return self.position, np.inf
        if isinstance(self.shape, Sphere):
            return self.position, self.shape.radius
        if isinstance(self.shape, Capsule):
            return self.position, self.shape.radius + 0.5 * self.shape.length
        if isinstance(self.shape, Cylinder):
            return self.position, float(np.hypot(self.shape.radius, 0.5 * self.shape.length))
        corners = self.shape.triangles()[0]
        low, high = corners.min(axis=0), corners.max(axis=0)
        centre = 0.5 * (low + high)
        radius = float(np.linalg.norm(corners - centre, axis=1).max())
        return self.turn @ centre + self.position, radius


@dataclass(frozen=True, eq=False)
class Thing:
    """A static, an object or a link: what it touches by, and where it is.

    Attributes:
        name: As in `Result.names`.
        solids: In its frame.
        position: Of its frame in the world (T, 3) [m]; (1, 3) of what stands.
        turn: World from its frame (T, 3, 3) or (1, 3, 3).
        stands: A static, or a link that no joint moves.
        parts: Which of a person's parts it touches (55,): all but those the scene excuses.
    """

    name: str
    solids: tuple[Solid, ...]
    position: Array
    turn: Array
    stands: bool
    parts: NDArray[np.bool_]

    def local(self, points: Array, frame: NDArray[np.integer]) -> Array:
        """World points (n, 3) of frames (n,) in the thing's frame."""
        if len(self.position) == 1:
            return (points - self.position[0]) @ self.turn[0]
        return np.einsum("nij,ni->nj", self.turn[frame], points - self.position[frame])

    def distance(self, points: Array) -> Array:
        """Distances (n,) [m] of points (n, 3) in its frame; 0 inside, inf where it has no solid."""
        found = np.full(len(points), np.inf)
        for solid in self.solids:
            np.minimum(found, solid.distance(points), out=found)
        return found


def things_of(scene: Scene, tracks: Mapping[str, ObjectTrack]) -> tuple[Thing, ...]:
    """The statics, objects and links of a scene, in its order.

    Args:
        scene: As simulated.
        tracks: Of objects and links, as in ``result.objects``.
    """
    found: list[tuple[str, str, tuple[Solid, ...], Array, Array, bool]] = []
    for name, static in scene.statics.items():
        solid = Solid(static.shape, np.zeros(3), np.eye(3), isinstance(static.shape, Mesh))
        turn = rot.to_matrix(static.quaternion)
        found.append((name, name, (solid,), static.position[None], turn[None], True))
    for name, thing in scene.objects.items():
        pieces = tuple(Solid(piece, np.zeros(3), np.eye(3)) for piece in thing.pieces)
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
        Thing(name, solids, position, turn, stands, _touched(scene, owner))
        for name, owner, solids, position, turn, stands in found
    )


def _touched(scene: Scene, owner: str) -> NDArray[np.bool_]:
    if scene.ignores(owner, PERSON):
        return np.zeros(N_JOINTS, dtype=bool)
    return np.array([not scene.ignores(owner, f"{PERSON}/{joint}") for joint in JOINT_NAMES])


def _poses(track: ObjectTrack) -> tuple[Array, Array]:
    return track.position, rot.to_matrix(rot.normalize(track.quaternion))


def _length(vectors: Array) -> Array:
    # Column by column: a sum along so short an axis takes several times as long.
    x, y, z = vectors[:, 0], vectors[:, 1], vectors[:, 2]
    return np.sqrt(x * x + y * y + z * z)


def _from_axis(p: Array, half: float) -> Array:
    z = p[:, 2] - np.clip(p[:, 2], -half, half)
    return np.sqrt(p[:, 0] ** 2 + p[:, 1] ** 2 + z * z)


def _outside_cylinder(p: Array, radius: float, half: float) -> Array:
    side = np.maximum(np.hypot(p[:, 0], p[:, 1]) - radius, 0.0)
    return np.hypot(side, np.maximum(np.abs(p[:, 2]) - half, 0.0))


def _outside_hull(hull: Mesh) -> Callable[[Array], Array]:
    def distance(p: Array) -> Array:
        found = np.zeros(len(p))
        outside = ~hull.query.inside(p)
        found[outside] = hull.query.closest(p[outside])[0]
        return found

    return distance


def solids_in_world(things: tuple[Thing, ...], frame: int) -> Iterator[tuple[str, Solid]]:
    """Every solid of things at a frame, as a solid of the world: for references and judges."""
    for thing in things:
        at = min(frame, len(thing.position) - 1)
        for solid in thing.solids:
            place = thing.turn[at] @ solid.position + thing.position[at]
            yield thing.name, Solid(solid.shape, place, thing.turn[at] @ solid.turn, solid.surface)
