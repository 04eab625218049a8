"""Shapes as MJCF geoms: primitives where MuJoCo has one, else meshes inside the file."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.mjcf_person import text
from halfphysics.errors import InputError
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shape_base import Shape
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere

Array = NDArray[np.float64]
Element = ElementTree.Element

#: A solid is convex if its volume is below its hull's by at most this fraction.
_CONVEX = 1e-6
#: MuJoCo refuses meshes of fewer vertices.
_LEAST_VERTICES = 4
#: Geom groups: MuJoCo's viewer shows 0 to 2.
_SEEN, _HIDDEN = "2", "3"
_COLOUR = "0.72 0.66 0.58 1"
_IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


class Geoms:
    """Adds geoms to bodies, and their meshes to `assets`."""

    def __init__(self, assets: Element) -> None:
        self._assets = assets

    def solid(
        self,
        body: Element,
        name: str,
        shape: Shape,
        friction: float,
        position: Array | None = None,
        quaternion: Array = _IDENTITY,
        *,
        hidden: bool = False,
        convex: bool = False,
    ) -> bool:
        """Add a geom that collides; False: MuJoCo has no such shape, and no geom was added.

        Args:
            body: The body of the geom.
            name: Its name, and that of its mesh if it needs one.
            shape: Any shape; a mesh only if it is convex.
            friction: Coulomb coefficient.
            position, quaternion: Pose of the shape in the body's frame.
            hidden: Put it in a group that viewers do not show.
            convex: The mesh is known to be convex: no test.
        """
        position = np.zeros(3) if position is None else position
        said: dict[str, str] = {}
        if isinstance(shape, Plane):
            normal = np.asarray(shape.normal)
            position = position + rot.rotate(quaternion, shape.offset * normal)
            quaternion = rot.multiply(quaternion, _z_to(normal))
            said = {"type": "plane", "size": "0 0 1"}
        elif isinstance(shape, Box):
            said = {"type": "box", "size": text(0.5 * np.asarray(shape.size))}
        elif isinstance(shape, Sphere):
            said = {"type": "sphere", "size": text([shape.radius])}
        elif isinstance(shape, Capsule | Cylinder):
            kind = type(shape).__name__.lower()
            said = {"type": kind, "size": text([shape.radius, 0.5 * shape.length])}
        elif isinstance(shape, Mesh) and (convex or _is_convex(shape)):
            ElementTree.SubElement(
                self._assets,
                "mesh",
                name=name,
                vertex=text(shape.vertices.ravel()),
                inertia="convex",
            )
            said = {"type": "mesh", "mesh": name}
        else:
            return False
        ElementTree.SubElement(
            body,
            "geom",
            said,
            name=name,
            pos=text(position),
            quat=text(quaternion),
            friction=f"{text([friction])} 0.005 0.0001",
            group=_HIDDEN if hidden else "0",
            rgba=_COLOUR,
        )
        return True

    def drawn(self, body: Element, name: str, shape: Shape) -> None:
        """Add a visual geom without contacts: the triangles of the shape."""
        vertices, faces = shape.triangles()
        if len(vertices) < _LEAST_VERTICES:
            vertices, faces = _finer(vertices, faces)
        ElementTree.SubElement(
            self._assets,
            "mesh",
            name=name,
            vertex=text(vertices.ravel()),
            face=" ".join(map(str, faces.ravel().tolist())),
            inertia="shell",
        )
        ElementTree.SubElement(
            body,
            "geom",
            type="mesh",
            mesh=name,
            contype="0",
            conaffinity="0",
            group=_SEEN,
            rgba=_COLOUR,
        )


def _finer(vertices: Array, faces: NDArray[np.int32]) -> tuple[Array, NDArray[np.int32]]:
    """The same surface with each triangle split in three at its centre."""
    middle = vertices[faces].mean(axis=1)
    new = len(vertices) + np.arange(len(faces))
    a, b, c = faces.T
    thirds = [np.stack(corners, axis=1) for corners in ((a, b, new), (b, c, new), (c, a, new))]
    return np.vstack([vertices, middle]), np.concatenate(thirds).astype(np.int32)


def _is_convex(mesh: Mesh) -> bool:
    if not mesh.closed:
        return False
    try:
        hull = mesh.hull.volume
    except InputError:  # flat
        return False
    return hull - mesh.volume <= _CONVEX * hull


def _z_to(normal: Array) -> Array:
    """A quaternion (4,) that rotates z to a unit vector."""
    half = np.array([1.0 + normal[2], -normal[1], normal[0], 0.0])
    if np.linalg.norm(half) < 1e-9:
        return np.array([0.0, 1.0, 0.0, 0.0])
    return rot.normalize(half)
