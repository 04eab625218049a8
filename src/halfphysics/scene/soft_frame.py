"""The hard frame under a soft layer: the shape that nothing enters.

The shape that a user gives is the surface, unloaded. Of a box, sphere, capsule or cylinder the
frame is the same kind, smaller by the thickness on all sides; of a plane it is lower; of a mesh
every vertex moves inward (`halfphysics.geometry.inset`), less where the mesh is thin.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError
from halfphysics.geometry.inset import OPPOSITE, SHARE, inset
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shape_base import Array, Shape
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.geometry.subdivision import subdivided
from halfphysics.geometry.surface_samples import surface_samples
from halfphysics.scene.soft import LEAST_THICKNESS, Soft

#: Faces of a mesh that is thin somewhere are cut to edges of this length [m], so that the frame is
#: the same however coarse the mesh is; longer ones where that were more than `MOST_FACES`.
EDGE = 0.05
MOST_FACES = 60_000
#: Thickness over the sharpest tips of a mesh [m]: none would be no layer.
LEAST = 1e-4
#: A layer that half of a mesh has this share of fits it.
SETTLED = 0.99


@dataclass(frozen=True, eq=False)
class SoftFrame:
    """A layer's two surfaces, in the shape's frame.

    Attributes:
        frame: The hard shape beneath.
        surface: Vertices of the unloaded surface (v, 3) [m]. Of a mesh: as given, or more of them.
        inner: The same vertices on the frame (v, 3) [m].
        faces: Of both (f, 3).
        thickness: Over each vertex (v,) [m].
    """

    frame: Shape
    surface: Array
    inner: Array
    faces: NDArray[np.int32]
    thickness: Array

    def corner_thickness(self) -> Array:
        """Thickness at the corners of the faces of a frame that is a mesh (f, 3) [m]."""
        return self._on_frame[self.frame.triangles()[1]]

    @property
    def _on_frame(self) -> Array:
        """Thickness at the frame's own vertices: fewer, as equal ones are one."""
        vertices = self.frame.triangles()[0]
        order = np.lexsort(self.inner.T[::-1])
        found: dict[tuple[float, ...], float] = {}
        for i in order:
            key = tuple((self.inner[i] + 0.0).tolist())
            found[key] = min(found.get(key, np.inf), float(self.thickness[i]))
        return np.array([found[tuple(v)] for v in vertices.tolist()])


_known: WeakKeyDictionary[Mesh, dict[float, SoftFrame]] = WeakKeyDictionary()


def soft_frame(shape: Shape, soft: Soft) -> SoftFrame:
    """The frame of a soft shape; of a mesh, made once per mesh and thickness.

    Raises:
        InputError: The layer is too thick for a primitive shape.
    """
    if not isinstance(shape, Mesh):
        return _of_primitive(shape, soft.thickness)
    known = _known.setdefault(shape, {})
    if soft.thickness not in known:
        known[soft.thickness] = _of_mesh(shape, soft.thickness)
    return known[soft.thickness]


def most_thickness(shape: Shape) -> float:
    """The thickest layer that a shape can have [m]; inf: any, as planes and meshes."""
    if isinstance(shape, Box):
        return float(SHARE * min(shape.size))
    if isinstance(shape, Sphere | Capsule):
        return 2.0 * SHARE * shape.radius
    if isinstance(shape, Cylinder):
        return SHARE * min(2.0 * shape.radius, shape.length)
    return float("inf")


def fitting(what: str, shape: Shape, soft: Soft, named: bool) -> Soft:
    """The layer as a shape can have it.

    Args:
        what: Begins the message.
        shape: What is soft.
        soft: The layer.
        named: It is a material's usual layer: made thinner where it does not fit.

    Raises:
        InputError: The layer is too thick.
    """
    most = most_thickness(shape)
    if soft.thickness <= most:
        return soft
    if named and most >= LEAST_THICKNESS:
        return soft.of_thickness(most)
    if named:
        raise _too_thin(what, shape, most)
    raise InputError(
        f"{what}: soft: thickness is {soft.thickness:g} m; expected at most {most:g} m, so that a "
        f"hard core of a tenth is left of {shape!r}. Make it thinner, or the shape larger (it may "
        "reach into what it lies on)"
    )


def even(what: str, mesh: Mesh, soft: Soft) -> Soft:
    """The layer of a closed mesh that moves, which has one thickness all over.

    Where the mesh is too thin for the layer, that is what half of its surface has at least (by
    area), of the same foam: a thicker one would stand above what is seen. What comes back comes
    back again as it is.

    Raises:
        InputError: It is too thin for any layer; `what` begins the message.
    """
    while (usual := _usual_thickness(mesh, soft)) < SETTLED * soft.thickness:
        if usual < LEAST_THICKNESS:
            raise _too_thin(what, mesh, usual)
        soft = soft.of_thickness(usual)
    return soft


def _usual_thickness(mesh: Mesh, soft: Soft) -> float:
    """What half of a mesh's surface has at least of a layer (by area) [m]."""
    made = soft_frame(mesh, soft)
    a, b, c = np.moveaxis(made.surface[made.faces], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    thickness = made.thickness[made.faces].mean(axis=1)
    order = np.argsort(thickness, kind="stable")
    half = int(np.searchsorted(np.cumsum(area[order]), 0.5 * area.sum()))
    return float(thickness[order[min(half, len(order) - 1)]])


def _too_thin(what: str, shape: Shape, most: float) -> InputError:
    return InputError(
        f"{what}: soft: {shape!r} is too thin for a layer: found room for {most:g} m, expected "
        f"at least {LEAST_THICKNESS:g} m. Make the shape larger, or leave soft out"
    )


def _of_primitive(shape: Shape, t: float) -> SoftFrame:
    frame: Shape
    if isinstance(shape, Plane):
        frame = Plane(shape.normal, shape.offset - t)
    elif isinstance(shape, Box):
        frame = Box([size - 2.0 * t for size in shape.size])
    elif isinstance(shape, Sphere):
        frame = Sphere(shape.radius - t)
    elif isinstance(shape, Capsule):
        frame = Capsule(shape.radius - t, shape.length)
    elif isinstance(shape, Cylinder):
        frame = Cylinder(shape.radius - t, shape.length - 2.0 * t)
    else:
        raise InputError(f"soft: found {type(shape).__name__}, expected a shape of halfphysics")
    surface, faces = shape.triangles()
    inner = frame.triangles()[0]
    return SoftFrame(frame, surface, inner, faces, np.full(len(surface), t))


def _of_mesh(mesh: Mesh, t: float) -> SoftFrame:
    mesh = mesh.outward
    vertices, faces = mesh.vertices, mesh.faces
    made = inset(vertices, faces, t)
    if made.thickness.min() < 0.999 * t or _thin_between(mesh, t):
        vertices, faces = _finer(vertices, faces)
        made = inset(vertices, faces, t)
    for array in (vertices, made.vertices, faces):
        array.setflags(write=False)
    thickness = np.maximum(made.thickness, LEAST)
    frame = Mesh(made.vertices, faces)
    return SoftFrame(frame, vertices, made.vertices, faces, thickness)


def _thin_between(mesh: Mesh, t: float) -> bool:
    """Whether a mesh is thinner than its layer at places between its vertices."""
    samples = surface_samples(mesh, EDGE)
    places = samples.points - t * samples.normals
    far, face, _ = mesh.query.closest(places)
    if mesh.closed and not mesh.query.inside(places).all():
        return True
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces[face]], 1, 0)
    across = np.cross(b - a, c - a)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    opposite = np.einsum("ij,ij->i", across, samples.normals) < -OPPOSITE
    return bool((opposite & (far < t)).any())


def _finer(vertices: Array, faces: NDArray[np.int32]) -> tuple[Array, NDArray[np.int32]]:
    """The same surface with its longer edges cut in halves, until none is longer than `EDGE`."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    area = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    edge = max(EDGE, float(np.sqrt(8.0 * area / MOST_FACES)))
    finer, cut = subdivided(vertices, faces, edge, MOST_FACES)
    return finer, cut.astype(np.int32)
