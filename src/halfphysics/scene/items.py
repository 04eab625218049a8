"""Items of a scene, statics and objects, and the checks of the arguments that make them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base.copying import ReadOnly
from halfphysics.base.short_repr import short_repr
from halfphysics.base.validation import number, quaternion, shown, vector
from halfphysics.errors import InputError
from halfphysics.geometry.contact_pieces import joined
from halfphysics.geometry.convex_decomposition import USUAL, Cut, Decomposition
from halfphysics.geometry.mesh import Mesh, MeshSource
from halfphysics.geometry.shape_base import Shape, Triangles
from halfphysics.scene.material_pairs import PERSON
from halfphysics.scene.soft import Soft, checked_soft
from halfphysics.scene.soft_frame import SoftFrame, fitting, soft_frame

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: Default coefficients of Coulomb friction; a pair has the smaller of its two.
PERSON_FRICTION = 1.0
STATIC_FRICTION = 1.0
OBJECT_FRICTION = 0.8


@dataclass(frozen=True, kw_only=True, eq=False)
class Static(ReadOnly):
    """Static geometry; `position` (3,), `quaternion` (4,) of its frame in the world.

    `shape` is what is seen; with a layer, `soft`, what nothing enters is the `frame` beneath.
    """

    name: str
    shape: Shape
    position: Array
    quaternion: Array
    friction: float = STATIC_FRICTION
    restitution: float = 0.0
    source: MeshSource | None = None
    soft: Soft | None = None

    __repr__ = short_repr

    @property
    def soft_frame(self) -> SoftFrame | None:
        """The layer's two surfaces, in its own frame; None: it is hard."""
        return None if self.soft is None else soft_frame(self.shape, self.soft)

    @property
    def true_shape(self) -> Shape:
        """The shape as given: that of objects may be cut into convex pieces."""
        return self.shape

    @property
    def frame(self) -> Shape:
        """The hard shape: its own, or what is left of it under the layer."""
        return self.shape if (made := self.soft_frame) is None else made.frame

    def mesh(self) -> Triangles:
        """Vertices (V, 3) [m] and faces (F, 3) in its own frame; a plane is a large square."""
        return self.shape.triangles()


@dataclass(frozen=True, kw_only=True, eq=False)
class Object(ReadOnly):
    """A rigid body that moves by contact and gravity alone.

    `pieces` are the convex shapes that collide: one primitive or mesh, or the pieces of a divided
    mesh, whose error is in `decomposition` (None for a convex shape). `shape` is the one piece, or
    the solid that several pieces replace; `visual` is the mesh as given (None for a primitive).
    With a layer, `soft`, these are its surface, and the pieces are those of the `frame` beneath.
    `mass` [kg], `com` (3,) centre of mass [m] and `inertia` (3, 3) about it [kg m^2] are in the
    object's frame; `position` (3,) and `quaternion` (4,) of that frame, `velocity` (3,) of its
    origin [m/s] and `angular_velocity` (3,) [rad/s] are those at the start, in the world. `start`:
    "awake", or "asleep": held in place until a moving body touches it.
    """

    name: str
    shape: Shape
    mass: float
    com: Array
    inertia: Array
    friction: float = OBJECT_FRICTION
    restitution: float = 0.0
    position: Array
    quaternion: Array
    velocity: Array
    angular_velocity: Array
    source: MeshSource | None = None
    visual: Mesh | None = None
    start: str = "awake"
    cut: Cut = USUAL
    decomposition: Decomposition | None = None
    soft: Soft | None = None

    __repr__ = short_repr

    @property
    def soft_frame(self) -> SoftFrame | None:
        """The layer's two surfaces, in the object's frame; None: it is hard."""
        return None if self.soft is None else soft_frame(self.true_shape, self.soft)

    @property
    def frame(self) -> Shape:
        """The hard solid: its shape, or what is left of it under the layer."""
        return self.shape if (made := self.soft_frame) is None else made.frame

    @property
    def pieces(self) -> tuple[Shape, ...]:
        """The convex pieces that collide, in the object's frame."""
        return (self.frame,) if self.decomposition is None else self.decomposition.pieces

    def mesh(self) -> Triangles:
        """Vertices (V, 3) [m] and faces (F, 3) of the colliding pieces, in the object's frame."""
        return self.shape.triangles() if len(self.pieces) == 1 else joined(self.pieces).triangles()

    @property
    def true_shape(self) -> Shape:
        """The shape as given: the mesh where convex pieces replace it, in the object's frame."""
        cut = self.decomposition is not None
        return self.visual if cut and self.visual is not None else self.shape

    @property
    def filling(self) -> Shape:
        """The solid of uniform density from which mass, centre and inertia come."""
        given = self.visual
        return given if given is not None and given.closed else self.shape


def fixed(array: Array) -> Array:
    result = np.array(array, dtype=np.float64)
    result.setflags(write=False)
    return result


def checked_name(scene: Scene, name: object, kind: str) -> str:
    """KIND 'NAME', to begin messages with.

    Raises:
        InputError: Another type than text, a character that names cannot hold, or a name in use.
    """
    if not isinstance(name, str) or not name.strip() or "/" in name or not name.isprintable():
        raise InputError(
            f"{kind}: found name {shown(name)}, expected text without '/' or line breaks"
        )
    if name == PERSON:
        raise InputError(f"{kind} {name!r}: this name means the people; choose another")
    groups: tuple[tuple[str, Mapping[str, Any]], ...] = (
        ("a static", scene.statics),
        ("an object", scene.objects),
        ("an articulated object", scene.articulated),
    )
    for group, items in groups:
        if name in items:
            raise InputError(
                f"{kind} {name!r}: the scene has {group} of this name already; "
                "names are unique among statics and objects together"
            )
    return f"{kind} {name!r}"


def checked_pose(what: str, position: ArrayLike, turn: ArrayLike) -> dict[str, Any]:
    return {
        "position": vector(position, f"{what}: position", unit="m"),
        "quaternion": quaternion(turn, f"{what}: quaternion"),
    }


def checked_material(what: str, friction: float, restitution: float) -> dict[str, Any]:
    return {
        "friction": number(friction, f"{what}: friction", least=0.0),
        "restitution": number(restitution, f"{what}: restitution", least=0.0, most=1.0),
    }


def checked_layer(what: str, given: Any, shape: Shape) -> Soft | None:
    """The layer that a caller gave, as the shape can have it.

    Raises:
        InputError: No layer, an unknown material, an impossible value, or too thick for the shape.
    """
    soft = checked_soft(what, given)
    if soft is None:
        return None
    usual = isinstance(given, str) or (isinstance(given, Mapping) and "thickness" not in given)
    return fitting(what, shape, soft, named=usual)


def checked_shape(
    what: str, given: Any, scale: float, up: str | None
) -> tuple[Shape, MeshSource | None]:
    """The shape, and its file if it came from one."""
    from halfphysics.geometry import mesh_files as meshes

    scale = number(scale, f"{what}: scale", above=0.0)
    if not (up is None or (isinstance(up, str) and up in ("y", "z"))):
        raise InputError(f"{what}: up: expected 'y', 'z' or None, found {shown(up)}")
    if isinstance(given, str | os.PathLike):
        return meshes.load_mesh(given, scale=scale, up=up)
    if isinstance(given, Shape) and not isinstance(given, Mesh):
        if scale != 1.0 or up is not None:
            name = type(given).__name__
            raise InputError(f"{what}: scale and up are for meshes; give the {name} its size")
        return given, None
    if not isinstance(given, Mesh):
        try:
            if hasattr(given, "graph") and hasattr(given, "geometry"):
                given = Mesh(*meshes.flatten(given))
            elif hasattr(given, "vertices") and hasattr(given, "faces"):
                given = Mesh(given.vertices, given.faces)
        except InputError as error:
            raise InputError(f"{what}: {error}") from None
    if not isinstance(given, Mesh):
        raise InputError(
            f"{what}: found {shown(given)} as shape, expected Plane, Box, Sphere, Capsule, "
            "Cylinder, Mesh, the path of a mesh file or a trimesh.Trimesh"
        )
    return meshes.turned(given, scale=scale, up=up or "z"), None
