"""From the arguments of `Scene.add_object` and `Scene.add_moving` to checked, immutable items."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from halfphysics.base.validation import number, shown, vector
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.geometry.contact_pieces import asked, touching
from halfphysics.geometry.convex_decomposition import THRESHOLD, Cut, Decomposition
from halfphysics.geometry.mesh import Mesh, MeshSource
from halfphysics.geometry.mesh_queries import piece_count
from halfphysics.geometry.shape_base import Shape
from halfphysics.geometry.shapes import Plane
from halfphysics.scene.items import (
    Object,
    checked_layer,
    checked_material,
    checked_pose,
    checked_shape,
    fixed,
)
from halfphysics.scene.soft import Soft
from halfphysics.scene.soft_frame import even, soft_frame
from halfphysics.scene.trajectories import KinematicObject, start_velocity, trajectory

#: Volumes by the surface and by the points inside may differ by this share: the latter is sampled.
ODD_PARTS = 0.1


@dataclass(frozen=True, kw_only=True)
class PieceOptions:
    """How a mesh that is not convex is divided into convex pieces; see `Scene.add_object`."""

    pieces: Any = "auto"
    threshold: float = THRESHOLD
    max_pieces: int | None = None


@dataclass(frozen=True)
class _Solid:
    """A shape that can move: as given, and the convex solid and pieces that touch."""

    given: Shape
    solid: Shape
    source: MeshSource | None
    cut: Cut
    decomposition: Decomposition | None
    soft: Soft | None = None

    @property
    def visual(self) -> Mesh | None:
        """The mesh as given; None for a primitive."""
        return self.given if isinstance(self.given, Mesh) else None


def build_object(
    what: str, shape: Any, options: PieceOptions, *, name: str, com: ArrayLike | None, **given: Any
) -> Object:
    """An object from the arguments of `Scene.add_object`; `what` begins the messages.

    Raises:
        InputError: An impossible value. FileError: A mesh file that cannot be used.
    """
    pose = checked_pose(what, given["position"], given["quaternion"])
    material = checked_material(what, given["friction"], given["restitution"])
    filling = _checked_mass(what, given["mass"], given["density"])
    motion = _checked_start(what, given["velocity"], given["angular_velocity"], given["start"])
    solid = _solid(
        what, shape, given["scale"], given["up"], options, filling["density"], given["soft"]
    )
    visual = solid.visual
    filled = solid.given if visual is None or visual.closed else solid.solid
    properties = filled.mass_properties(**filling)
    centre = properties.com if com is None else vector(com, f"{what}: com", unit="m")
    return Object(
        name=name,
        shape=solid.solid,
        mass=properties.mass,
        com=fixed(centre),
        inertia=fixed(properties.inertia),
        source=solid.source,
        visual=visual,
        start=given["start"],
        cut=solid.cut,
        decomposition=solid.decomposition,
        soft=solid.soft,
        **pose,
        **material,
        **motion,
    )


def build_kinematic(
    what: str,
    shape: Any,
    positions: ArrayLike,
    quaternions: ArrayLike | None,
    *,
    name: str,
    loop: bool,
    **given: Any,
) -> KinematicObject:
    """A kinematic object from the arguments of `Scene.add_moving`; `what` begins the messages.

    Raises:
        InputError: An impossible value. FileError: A mesh file that cannot be used.
    """
    material = checked_material(what, given["friction"], given["restitution"])
    places, turns = trajectory(what, positions, quaternions)
    rate = number(given["fps"], f"{what}: fps", above=0.0, unit="1/s")
    if not isinstance(loop, bool):
        raise InputError(f"{what}: loop: expected True or False, found {shown(loop)}")
    solid = _solid(what, shape, given["scale"], given["up"], PieceOptions(), soft=given["soft"])
    velocity, spin = start_velocity(places, turns, rate)
    return KinematicObject(
        name=name,
        shape=solid.solid,
        cut=solid.cut,
        decomposition=solid.decomposition,
        mass=np.inf,
        com=fixed(np.zeros(3)),
        inertia=fixed(np.diag([np.inf] * 3)),
        position=fixed(places[0]),
        quaternion=fixed(turns[0]),
        velocity=fixed(velocity),
        angular_velocity=fixed(spin),
        source=solid.source,
        visual=solid.visual,
        soft=solid.soft,
        positions=places,
        quaternions=turns,
        fps=rate,
        loop=loop,
        **material,
    )


def _solid(
    what: str,
    shape: Any,
    scale: float,
    up: str | None,
    options: PieceOptions,
    density: float | None = None,
    soft: Any = None,
) -> _Solid:
    """The shape that was given and the solid that touches; a density needs a closed mesh.

    Of a soft mesh that is not convex, the pieces are those of its frame.
    """
    given, source = checked_shape(what, shape, scale, up)
    if isinstance(given, Plane):
        raise InputError(
            f"{what}: a Plane has no volume to move, expected Box, Sphere, "
            "Capsule, Cylinder or a mesh; add_static takes planes"
        )
    own, cut = asked(what, given, options.pieces, options.threshold, options.max_pieces)
    if isinstance(given, Mesh) and not given.closed and density is not None:
        raise InputError(
            f"{what}: the mesh is not a closed surface, so it has no volume for a density; "
            "expected mass= [kg], or a mesh without holes"
        )
    if isinstance(given, Mesh) and density is not None:
        _warn_of_parts(what, given)
    layer = checked_layer(what, soft, given)
    if layer is None or not isinstance(given, Mesh):
        solid, decomposition = touching(what, given, cut, own)
        return _Solid(given, solid, source, cut, decomposition, layer)
    if own is not None:
        raise InputError(
            f"{what}: found pieces= and soft=; the pieces of a soft mesh are those of the hard "
            "frame inside, which is made from it. Leave pieces= out"
        )
    if not given.closed:
        raise InputError(
            f"{what}: soft: the mesh is not a closed surface, so no frame can be put inside it; "
            "expected a mesh without holes"
        )
    layer = even(what, given, layer)
    if given.is_convex:
        return _Solid(given, given.hull, source, cut, None, layer)
    _, decomposition = touching(f"{what}: its frame", soft_frame(given, layer).frame, cut, own)
    if decomposition is None:  # the frame of what is nearly convex
        return _Solid(given, given, source, cut, None, layer)
    return _Solid(given, given, source, cut, decomposition, layer)


def _warn_of_parts(what: str, mesh: Mesh) -> None:
    """Where parts overlap or are inside out, the volume by the surface is not what is inside."""
    if piece_count(mesh.faces, len(mesh.vertices)) == 1:
        return
    inside = mesh.solid_volume
    if abs(mesh.volume - inside) > ODD_PARTS * inside:
        warnings.warn(
            f"{what}: parts of the mesh overlap or are inside out: their surfaces bound "
            f"{mesh.volume:.3g} m^3, the points inside are {inside:.3g}. The mass by density, the "
            "centre and the inertia are those of the surfaces. Join the parts to one solid, turn "
            "their faces outward, or give mass= and com=",
            HalfPhysicsWarning,
            stacklevel=5,
        )


def _checked_mass(what: str, mass: Any, density: Any) -> Mapping[str, float | None]:
    """Mass [kg] or density [kg/m^3], exactly one of them."""
    if (mass is None) == (density is None):
        found = "neither" if mass is None else f"both, {shown(mass)} and {shown(density)}"
        raise InputError(f"{what}: expected mass= [kg] or density= [kg/m^3], found {found}")
    if mass is not None:
        mass = number(mass, f"{what}: mass", above=0.0, unit="kg")
    if density is not None:
        density = number(density, f"{what}: density", above=0.0, unit="kg/m^3")
    return {"mass": mass, "density": density}


def _checked_start(what: str, velocity: Any, spin: Any, start: Any) -> dict[str, Any]:
    """Velocities at the start; an object that starts asleep has none."""
    motion: dict[str, Any] = {
        "velocity": vector(velocity, f"{what}: velocity", unit="m/s"),
        "angular_velocity": vector(spin, f"{what}: angular_velocity", unit="rad/s"),
    }
    if not isinstance(start, str) or start not in ("awake", "asleep"):
        raise InputError(f"{what}: start: expected 'awake' or 'asleep', found {shown(start)}")
    if start == "asleep" and any(v.any() for v in motion.values()):
        raise InputError(
            f"{what}: found a velocity and start='asleep'; what is asleep does not move. "
            "Leave one of them out"
        )
    return motion
