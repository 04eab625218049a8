"""The vertices of an object that are labelled: a mesh's own, or points spread over a primitive.

A coarse triangulation of a primitive has no vertices near most contacts, so primitives are covered
evenly, and deterministically.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.copying import ReadOnly
from halfphysics.base.short_repr import short_repr
from halfphysics.errors import InputError
from halfphysics.geometry.shape_base import Shape
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Sphere
from halfphysics.labels.item_solids import ItemSolids

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]
Triangles = tuple[Array, NDArray[np.int32]]

#: Distance between neighbouring points on a primitive [m]; large ones have MOST points or fewer.
SPACING = 0.01
MOST = 20_000


@dataclass(frozen=True, kw_only=True, eq=False)
class ObjectSurface(ReadOnly):
    """The vertices of an object that are labelled.

    Attributes:
        name: As in `Result.names`.
        vertices: In the object's frame (Vo, 3) [m]: a mesh's own, or points over a primitive.
        faces: Triangles of them (Fo, 3), outward.
        off: Largest distance of `vertices` from the collision geometry [m]: 0 except for a mesh
            that convex pieces replace.
    """

    _REBUILT: ClassVar[frozenset[str]] = frozenset({"grid"})

    name: str
    vertices: Array
    faces: NDArray[np.int32]
    off: float

    __repr__ = short_repr

    @cached_property
    def grid(self) -> Any:
        """The vertices for the core: `PointGrid`."""
        from halfphysics import _native

        return _native.PointGrid(np.ascontiguousarray(self.vertices))


def surface_of(scene: Scene, item: ItemSolids) -> ObjectSurface:
    """The vertices of an object or a link.

    For a mesh its own vertices, also if convex pieces replace it.
    """
    vertices, faces = _triangles(scene, item.name)
    given = scene.objects.get(item.name)
    own = given is not None and given.visual is not None
    off = float(item.distance(vertices).max()) if own else 0.0
    return ObjectSurface(name=item.name, vertices=vertices, faces=faces, off=off)


def _triangles(scene: Scene, name: str) -> Triangles:
    if name in scene.objects:
        given = scene.objects[name]
        return covered(given.shape) if given.visual is None else given.visual.triangles()
    vertices, faces, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int32)], 0
    for whole in scene.articulated.values():
        for link_name, link in zip(whole.link_names, whole.links, strict=True):
            for geom in link.geoms if link_name == name else ():
                mesh = isinstance(geom.shape, Mesh)
                v, f = geom.shape.triangles() if mesh else covered(geom.shape)
                vertices.append(rot.rotate(geom.quaternion, v) + geom.position)
                faces.append(f + np.int32(count))
                count += len(v)
    return np.concatenate(vertices), np.concatenate(faces)


@lru_cache(maxsize=16)
def covered(shape: Shape, spacing: float = SPACING) -> Triangles:
    """Vertices (V, 3) [m] and outward faces (F, 3) over a primitive, read-only.

    Neighbours are at most about `spacing` apart, or more if that needs over `MOST` vertices.

    Raises:
        InputError: No primitive of finite size.
    """
    vertices, faces = _covered(shape, spacing)
    vertices.setflags(write=False)
    faces.setflags(write=False)
    return vertices, faces


def _covered(shape: Shape, spacing: float) -> Triangles:
    if isinstance(shape, Box):
        a, b, c = shape.size
        return _box(np.asarray(shape.size), _step(2.0 * (a * b + b * c + c * a), spacing))
    if isinstance(shape, Sphere):
        step = _step(2.0 * np.pi**2 * shape.radius**2, spacing)
        return _revolved(_arc(shape.radius, 0.0, step), shape.radius, step)
    if isinstance(shape, Capsule):
        r = shape.radius
        step = _step(2.0 * np.pi * r * (np.pi * r + shape.length), spacing)
        return _revolved(_arc(r, 0.5 * shape.length, step), r, step)
    if isinstance(shape, Cylinder):
        r, half = shape.radius, 0.5 * shape.length
        step = _step(2.0 * np.pi * r * (2.0 * r + shape.length), spacing)
        bottom, side = _line(0.0, r, step), _line(-half, half, step)
        profile = np.concatenate(
            [
                np.stack([bottom, np.full_like(bottom, -half)], axis=1),
                np.stack([np.full_like(side, r), side], axis=1)[1:-1],
                np.stack([bottom[::-1], np.full_like(bottom, half)], axis=1),
            ]
        )
        return _revolved(profile, r, step)
    raise InputError(
        f"shape: found a {type(shape).__name__}, expected Box, Sphere, Capsule or Cylinder"
    )


def _step(area: float, spacing: float) -> float:
    """The spacing at which `area` [m^2] of a grid has at most `MOST` points."""
    return max(spacing, float(np.sqrt(area / (0.9 * MOST))))


def _line(start: float, end: float, step: float) -> Array:
    return np.linspace(start, end, max(2, int(np.ceil(abs(end - start) / step - 1e-9)) + 1))


def _box(size: Array, step: float) -> Triangles:
    half = 0.5 * size
    axes = [_line(-h, h, step) for h in half]
    vertices, faces, count = [], [], 0
    for axis in range(3):
        u, v = axes[(axis + 1) % 3], axes[(axis + 2) % 3]
        for side in (-1.0, 1.0):
            points = np.empty((len(u), len(v), 3))
            points[..., axis] = side * half[axis]
            points[..., (axis + 1) % 3] = u[:, None]
            points[..., (axis + 2) % 3] = v
            corner = (np.arange(len(u) - 1)[:, None] * len(v) + np.arange(len(v) - 1)).ravel()
            a, b, c, d = corner, corner + len(v), corner + len(v) + 1, corner + 1
            quads = [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
            found = np.concatenate(quads) + count
            vertices.append(points.reshape(-1, 3))
            faces.append(found if side > 0 else found[:, ::-1])
            count += points.size // 3
    # Sides share their edges exactly: a mesh merges them.
    mesh = Mesh(np.concatenate(vertices), np.concatenate(faces))
    return mesh.vertices, mesh.faces


def _arc(radius: float, half: float, step: float) -> Array:
    """Profile (k, 2) of a capsule (half the length of its tube; 0: a ball), south to north."""
    angle = _line(-0.5 * np.pi, 0.0, step / radius)
    r, z = radius * np.cos(angle), radius * np.sin(angle)
    r[0] = 0.0
    south = np.stack([r, z - half], axis=1)
    tube = _line(-half, half, step)[1:-1] if half > 0.0 else np.zeros(0)
    north = south[::-1] * [1.0, -1.0]
    middle = np.stack([np.full_like(tube, radius), tube], axis=1)
    return np.concatenate([south, middle, north if half > 0.0 else north[1:]])


def _revolved(profile: Array, radius: float, step: float) -> Triangles:
    """Closed surface of a profile (k, 2) of radius and height; its ends lie on the axis."""
    around = max(8, int(np.ceil(2.0 * np.pi * radius / step - 1e-9)))
    angle = 2.0 * np.pi * np.arange(around) / around
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    rings = profile[1:-1]
    body = np.empty((len(rings), around, 3))
    body[..., :2] = rings[:, :1, None] * ring
    body[..., 2] = rings[:, 1:]
    poles = [[0.0, 0.0, profile[0, 1]], [0.0, 0.0, profile[-1, 1]]]
    j = np.arange(around)
    k = (j + 1) % around
    low = np.arange(len(rings) - 1)[:, None] * around
    south, last = len(rings) * around, (len(rings) - 1) * around
    bands = [
        np.stack([low + j, low + k, low + around + k], axis=-1).reshape(-1, 3),
        np.stack([low + j, low + around + k, low + around + j], axis=-1).reshape(-1, 3),
    ]
    caps = [
        np.stack([np.full_like(j, south), k, j], axis=-1),
        np.stack([last + j, last + k, np.full_like(j, south + 1)], axis=-1),
    ]
    return np.concatenate([body.reshape(-1, 3), poles]), np.concatenate(bands + caps).astype(
        np.int32
    )
