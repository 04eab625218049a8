"""The rigid variant of a body: 55 convex parts with a person's mass.

A part's frame is its joint's frame, with the axes of the SMPL-X rest frame (x to the body's left,
y up, z forward): a pose with all rotations zero is the rest pose. "Half-Physics", section 3.1.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Any, Protocol
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.copying import ReadOnly
from halfphysics.base.short_repr import short_repr
from halfphysics.body.mass import Solid, solid_parts
from halfphysics.body.part_hull import PartHull, part_hull
from halfphysics.body.symmetry import FLIP, symmetry_of
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.geometry.colliders import ConvexCollider, hull_collider
from halfphysics.motion.skeleton import JOINT_NAMES, MIRRORED, N_JOINTS, PARENTS

Array = NDArray[np.float64]

#: Density of a human body [kg/m^3]: 1 litre weighs a little under 1 kg.
DENSITY = 985.0
#: Mass [kg] and radius [m] of the small ball that replaces the part of a joint without skin, so
#: that the inertia matrix is regular.
EMPTY_MASS, EMPTY_RADIUS = 1e-6, 0.01
#: Largest extent of a skin [m]; larger ones are in centimetres or millimetres.
MAX_EXTENT = 10.0
#: Parts with smaller hulls [m^3] get denser samples for their mass: hands, toes, jaw, eyes.
FINE_VOLUME = 3e-4


class Skin(Protocol):
    """Attributes of a body that `build_variant` reads: a skin of 55 joints, in the rest pose."""

    @property
    def rest_vertices(self) -> Array: ...  # (V, 3) [m]
    @property
    def rest_joints(self) -> Array: ...  # (55, 3) [m]
    @property
    def faces(self) -> NDArray[Any]: ...  # (F, 3)
    @property
    def weights(self) -> NDArray[Any]: ...  # (V, 55)


@dataclass(frozen=True, kw_only=True, eq=False)
class Part(ReadOnly):
    """One rigid part, in its joint's frame.

    Attributes:
        name: One of `JOINT_NAMES`.
        index: Its index there.
        vertices: Corners of the convex hull (n, 3) [m]; (0, 3) for a joint without skin.
        faces: Outward triangles of the hull (m, 3).
        mass: Mass [kg], > 0.
        com: Centre of mass (3,) [m].
        inertia: Inertia about the centre of mass (3, 3) [kg m^2], positive definite.
    """

    name: str
    index: int
    vertices: Array
    faces: NDArray[np.int32]
    mass: float
    com: Array
    inertia: Array

    __repr__ = short_repr


@dataclass(frozen=True, kw_only=True, eq=False)
class Variant(ReadOnly):
    """The rigid parts of one body shape.

    Attributes:
        parts: 55 parts in the order of `JOINT_NAMES`.
        joint_offsets: Rest joint minus its parent's (55, 3) [m]; row 0 is zero.
        volume: Volume inside the skin [m^3].
        mass: Sum over the parts [kg].
    """

    parts: tuple[Part, ...]
    joint_offsets: Array
    volume: float
    mass: float

    __repr__ = short_repr

    @property
    def standing_height(self) -> float:
        """Height of the pelvis joint over the lowest point, upright in the rest pose [m]."""
        joints = np.zeros((N_JOINTS, 3))
        for i in range(1, N_JOINTS):
            joints[i] = joints[PARENTS[i]] + self.joint_offsets[i]
        lows = [joints[p.index, 1] + p.vertices[:, 1].min() for p in self.parts if len(p.vertices)]
        return -float(min(lows, default=0.0))

    def weighing(self, mass: float) -> Variant:
        """The same parts with their masses and inertias scaled evenly to a whole `mass` [kg]."""
        factor = mass / self.mass
        parts = tuple(
            replace(part, mass=factor * part.mass, inertia=_fixed(factor * part.inertia))
            for part in self.parts
        )
        return replace(self, parts=parts, mass=float(sum(part.mass for part in parts)))


def build_variant(body: Skin, *, density: float = DENSITY, mass: float | None = None) -> Variant:
    """Rigid parts of a body: convex hulls of its skin, cut by largest weight, with mass.

    Hull k holds the skin vertices whose largest skinning weight is joint k's. Mass, centre of mass
    and inertia come from the volume inside the skin, not from the hulls, which overlap.

    Args:
        body: Skin and joints in the rest pose (`halfphysics.Body`).
        density: Density of the flesh [kg/m^3].
        mass: Mass of the whole person [kg]; overrides `density`.

    Raises:
        InputError: arrays of impossible shape or value, or a skin without volume.

    Warns:
        HalfPhysicsWarning: some parts were too flat to be solid and were thickened.
    """
    skin, joints, faces, weights = _checked(body)
    for name, value in (("density", density), ("mass", mass)):
        if value is not None and not (np.isfinite(value) and value > 0.0):
            raise InputError(f"variant: {name} is {value}, expected a number > 0")
    labels = weights.argmax(axis=1)
    hulls = [part_hull(skin[labels == i] - joints[i], JOINT_NAMES[i]) for i in range(N_JOINTS)]
    thickened = [JOINT_NAMES[i] for i, hull in enumerate(hulls) if hull.thickened]
    if thickened:
        warnings.warn(
            f"variant: the skin of {', '.join(thickened)} is flat or has under four vertices; "
            "thickened to a millimetre",
            HalfPhysicsWarning,
            stacklevel=2,
        )
    fine = [i for i, hull in enumerate(hulls) if hull.volume < FINE_VOLUME]
    solid = solid_parts(skin, faces, labels, N_JOINTS, fine)
    if _is_mirrored(skin, joints, faces, labels):
        hulls, solid = _mirrored_hulls(hulls), _even(solid)
    if mass is not None:
        density = mass / solid.total
    parts = []
    for i, hull in enumerate(hulls):
        if solid.volume[i] > 0.0:
            weight, com = density * solid.volume[i], solid.centroid[i] - joints[i]
            inertia = density * solid.moment[i]
        else:
            weight, com, inertia = _ball(hull, density)
        part = Part(
            name=JOINT_NAMES[i],
            index=i,
            vertices=_fixed(hull.vertices),
            faces=_fixed(hull.faces),
            mass=float(weight),
            com=_fixed(com),
            inertia=_fixed(inertia),
        )
        parts.append(part)
    offsets = joints - joints[np.maximum(PARENTS, 0)]
    return Variant(
        parts=tuple(parts),
        joint_offsets=_fixed(offsets),
        volume=solid.total,
        mass=float(sum(part.mass for part in parts)),
    )


def _is_mirrored(
    skin: Array, joints: Array, faces: NDArray[np.int64], labels: NDArray[np.int64]
) -> bool:
    """Whether a body is its own mirror image, to the last bit."""
    symmetry = symmetry_of(faces, skin)
    return (
        symmetry is not None
        and symmetry.is_exact(skin)
        and bool((joints[MIRRORED] * FLIP == joints).all())
        and bool((labels[symmetry.vertex] == MIRRORED[labels]).all())
    )


def _mirrored_hulls(hulls: list[PartHull]) -> list[PartHull]:
    """The same hulls, those of the right as images of the left: hulls' rounding has no side."""
    return [
        hull
        if i <= k
        else replace(
            hulls[k],
            vertices=hulls[k].vertices * FLIP,
            faces=np.ascontiguousarray(hulls[k].faces[:, ::-1]),
        )
        for i, (k, hull) in enumerate(zip(MIRRORED.tolist(), hulls, strict=True))
    ]


def _even(solid: Solid) -> Solid:
    """The mean of volumes and their mirror image: samples along rays are not mirrored to a bit."""
    flip = np.outer(FLIP, FLIP)
    return replace(
        solid,
        volume=0.5 * (solid.volume + solid.volume[MIRRORED]),
        centroid=0.5 * (solid.centroid + solid.centroid[MIRRORED] * FLIP),
        moment=0.5 * (solid.moment + solid.moment[MIRRORED] * flip),
    )


def _checked(body: Skin) -> tuple[Array, Array, NDArray[np.int64], Array]:
    skin = np.asarray(body.rest_vertices, dtype=np.float64)
    joints = np.asarray(body.rest_joints, dtype=np.float64)
    weights = np.asarray(body.weights, dtype=np.float64)
    faces = np.asarray(body.faces).astype(np.int64)
    expected = {
        "rest_vertices": (skin, (len(skin), 3)),
        "rest_joints": (joints, (N_JOINTS, 3)),
        "weights": (weights, (len(skin), N_JOINTS)),
        "faces": (faces, (len(faces), 3)),
    }
    for name, (array, shape) in expected.items():
        if array.shape != shape:
            raise InputError(f"variant: {name} of the body is {array.shape}, expected {shape}")
        if not np.isfinite(array).all():
            raise InputError(f"variant: {name} of the body holds NaN or infinity")
    extent = float(np.ptp(skin, axis=0).max()) if len(skin) else 0.0
    if extent > MAX_EXTENT:
        raise InputError(
            f"variant: the skin of the body is {extent:g} m across, expected under "
            f"{MAX_EXTENT:g}; is it in metres?"
        )
    if len(faces) and not (faces.min() >= 0 and faces.max() < len(skin)):
        raise InputError(
            f"variant: faces of the body name vertices {faces.min()} to {faces.max()}, "
            f"but there are {len(skin)}"
        )
    return skin, joints, faces, weights


def _ball(hull: PartHull, density: float) -> tuple[float, Array, Array]:
    """Mass, centre and inertia of a part that holds no volume of the skin."""
    points = hull.vertices if len(hull.vertices) else np.zeros((1, 3))
    mass = max(EMPTY_MASS, density * hull.volume)
    radius = max(EMPTY_RADIUS, 0.5 * float(np.ptp(points, axis=0).max()))
    return mass, points.mean(axis=0), 0.4 * mass * radius**2 * np.eye(3)


def _fixed(array: NDArray[Any]) -> NDArray[Any]:
    array = np.ascontiguousarray(array)
    array.setflags(write=False)
    return array


#: Colliders of rigid parts, kept as long as the parts exist.
_colliders: WeakKeyDictionary[Part, ConvexCollider] = WeakKeyDictionary()


def part_collider(part: Part) -> ConvexCollider:
    """Collider of a rigid part that has vertices; computed once per part."""
    collider = _colliders.get(part)
    if collider is None:
        collider = _colliders[part] = hull_collider(part.vertices)
    return collider
