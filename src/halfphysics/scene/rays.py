"""Ray casts: exact for primitives, against every triangle for meshes and skins."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import shown, vector
from halfphysics.errors import InputError
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.scene.articulated import start_poses

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.geometry.shape_base import Shape
    from halfphysics.motion.pose import Pose
    from halfphysics.scene.articulated import Link
    from halfphysics.scene.items import Object, Static
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]
Found = tuple[float, Array]  # distance and normal

#: Tolerance at a triangle's border, as a share of its size, so that no ray passes between two
#: triangles because their common edge is rounded.
_EDGE = 1e-12


@dataclass(frozen=True)
class Hit:
    """The first hit of a ray.

    Attributes:
        distance: From the origin [m].
        name: Name of the static, object or person.
        position: Position in the world (3,) [m].
        normal: Unit normal of the surface (3,), on the side from which the ray comes.
        part: Name of the joint whose part of a person's skin is hit; None for scene items.
    """

    distance: float
    name: str
    position: Array
    normal: Array
    part: str | None = None


class Ray:
    """A ray and its nearest hit so far."""

    def __init__(self, origin: ArrayLike, direction: ArrayLike) -> None:
        self.origin = vector(origin, "ray: origin", unit="m")
        way = vector(direction, "ray: direction")
        largest = float(np.abs(way).max())
        if largest == 0.0:
            raise InputError("ray: direction has no length, expected one such as (0, 0, -1)")
        self.direction: Array = way / largest / np.linalg.norm(way / largest)
        self.hit: Hit | None = None

    def meet(self, name: str, shape: Shape, position: Array, quaternion: Array) -> None:
        """Keep the hit of a shape if it is the nearest."""
        turn = rot.to_matrix(quaternion)
        found = _of_shape(shape, (self.origin - position) @ turn, self.direction @ turn)
        if found is not None:
            self._keep(name, found[0], turn @ found[1], None)

    def meet_link(self, name: str, link: Link, position: Array, quaternion: Array) -> None:
        """Keep the hit of a link of an articulated object if it is the nearest."""
        for geom in link.geoms:
            place = position + rot.rotate(quaternion, geom.position)
            self.meet(name, geom.shape, place, rot.multiply(quaternion, geom.quaternion))

    def meet_person(self, name: str, body: Body, pose: Pose) -> None:
        """Keep the hit of a person's skin if it is the nearest."""
        vertices = body.vertices(pose)
        found = _of_triangles(vertices, body.faces, self.origin, self.direction)
        if found is not None:
            distance, normal, face = found
            part = int(body.skin.weights[body.faces[face]].sum(axis=0).argmax())
            self._keep(name, distance, normal, JOINT_NAMES[part])

    def _keep(self, name: str, distance: float, normal: Array, part: str | None) -> None:
        if self.hit is not None and self.hit.distance <= distance:
            return
        if normal @ self.direction > 0.0:
            normal = -normal
        place = self.origin + distance * self.direction
        self.hit = Hit(float(distance), name, place, normal, part)


def checked_names(ignore: Collection[str], known: Collection[str]) -> set[str]:
    """The names that a ray passes through.

    Raises:
        InputError: Text instead of a list of names, or an unknown name.
    """
    if isinstance(ignore, str):
        raise InputError(
            f"ray: ignore: found {shown(ignore)}, expected a list such as [{ignore!r}]"
        )
    if not isinstance(ignore, Iterable):
        raise InputError(f"ray: ignore: found {shown(ignore)}, expected a list of names")
    names = list(ignore)
    for name in names:
        if not isinstance(name, str) or name not in known:
            hint = did_you_mean(name, known, form=repr, otherwise=".")
            raise InputError(
                f"ray: ignore: there is nothing called {shown(name)}{hint} "
                f"There are: {', '.join(known) or 'none'}"
            )
    return set(names)


def scene_ray(
    scene: Scene, origin: ArrayLike, direction: ArrayLike, ignore: Collection[str]
) -> Hit | None:
    """The work behind `Scene.ray`."""
    ray = Ray(origin, direction)
    links = [name for item in scene.articulated.values() for name in item.link_names]
    skipped = checked_names(ignore, (*scene.statics, *scene.objects, *links))
    items: list[Static | Object] = [*scene.statics.values(), *scene.objects.values()]
    for item in items:
        if item.name not in skipped:
            ray.meet(item.name, item.shape, item.position, item.quaternion)
    for jointed in scene.articulated.values():
        places = zip(jointed.link_names, jointed.links, start_poses(jointed), strict=True)
        for name, link, place in places:
            if name not in skipped:
                ray.meet_link(name, link, *place)
    return ray.hit


def _of_shape(shape: Shape, o: Array, d: Array) -> Found | None:
    """Distance to the surface of a shape, and its normal, all in the shape's frame."""
    if isinstance(shape, Mesh):
        found = _of_triangles(shape.vertices, shape.faces, o, d)
        return None if found is None else found[:2]
    ways = {
        Plane: _plane,
        Box: _box,
        Sphere: _sphere,
        Capsule: _capsule,
        Cylinder: _cylinder,
    }
    return min(ways[type(shape)](shape, o, d), key=lambda f: f[0], default=None)  # type: ignore[operator]


def _plane(shape: Plane, o: Array, d: Array) -> Iterator[Found]:
    normal = np.asarray(shape.normal)
    yield from _flat(normal, shape.offset, o, d)


def _flat(normal: Array, offset: float, o: Array, d: Array) -> Iterator[Found]:
    closing = float(normal @ d)
    if closing != 0.0:
        t = (offset - float(normal @ o)) / closing
        if t >= 0.0:
            yield t, normal


def _box(shape: Box, o: Array, d: Array) -> Iterator[Found]:
    half = 0.5 * np.asarray(shape.size)
    for axis in range(3):
        others = [i for i in range(3) if i != axis]
        for sign in (-1.0, 1.0):
            for t, normal in _flat(sign * np.eye(3)[axis], half[axis], o, d):
                if (np.abs(o + t * d)[others] <= half[others]).all():
                    yield t, normal


def _sphere(shape: Sphere, o: Array, d: Array) -> Iterator[Found]:
    yield from _ball(np.zeros(3), shape.radius, o, d)


def _ball(centre: Array, radius: float, o: Array, d: Array) -> Iterator[Found]:
    for t in _crossings(o - centre, d, radius):
        yield t, (o + t * d - centre) / radius


def _crossings(o: Array, d: Array, radius: float) -> Iterator[float]:
    """Where |o + t d| = radius, t >= 0; of a circle with two components, of a ball with three."""
    a = float(d @ d)
    if a == 0.0:
        return
    middle = -float(o @ d) / a
    nearest = o + middle * d  # relative to the nearest point: precise also far away
    height = radius**2 - float(nearest @ nearest)
    if height < 0.0:
        return
    reach = math.sqrt(height / a)
    for t in (middle - reach, middle + reach):
        if t >= 0.0:
            yield t


def _side(radius: float, half: float, o: Array, d: Array) -> Iterator[Found]:
    for t in _crossings(o[:2], d[:2], radius):
        p = o + t * d
        if abs(p[2]) <= half:
            yield t, np.array([p[0], p[1], 0.0]) / radius


def _capsule(shape: Capsule, o: Array, d: Array) -> Iterator[Found]:
    half = 0.5 * shape.length
    yield from _side(shape.radius, half, o, d)
    for sign in (-1.0, 1.0):
        for t, normal in _ball(np.array([0.0, 0.0, sign * half]), shape.radius, o, d):
            if sign * normal[2] >= 0.0:
                yield t, normal


def _cylinder(shape: Cylinder, o: Array, d: Array) -> Iterator[Found]:
    half = 0.5 * shape.length
    yield from _side(shape.radius, half, o, d)
    for sign in (-1.0, 1.0):
        for t, normal in _flat(np.array([0.0, 0.0, sign]), half, o, d):
            if np.hypot(*(o + t * d)[:2]) <= shape.radius:
                yield t, normal


def _of_triangles(
    vertices: Array, faces: NDArray[np.integer], o: Array, d: Array
) -> tuple[float, Array, int] | None:
    """Distance, normal and triangle (Moeller and Trumbore 1997), both sides of them."""
    a = vertices[faces[:, 0]] - o
    u, v = vertices[faces[:, 1]] - o - a, vertices[faces[:, 2]] - o - a
    p = np.cross(d, v)
    volume = np.einsum("ij,ij->i", u, p)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = -np.einsum("ij,ij->i", a, p) / volume
        q = np.cross(-a, u)
        r = (q @ d) / volume
        t = np.einsum("ij,ij->i", v, q) / volume
        inside = (s >= -_EDGE) & (r >= -_EDGE) & (s + r <= 1.0 + _EDGE) & (t >= 0.0)
    inside &= volume != 0.0
    if not inside.any():
        return None
    face = int(np.where(inside, t, np.inf).argmin())
    normal = np.cross(u[face], v[face])
    return float(t[face]), normal / np.linalg.norm(normal), face
