"""A short text that differs where people or items do: it says which states fit a simulator."""

from __future__ import annotations

import zlib
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.geometry.mesh import Mesh

if TYPE_CHECKING:
    from collections.abc import Sequence

    from halfphysics.body.body import Body
    from halfphysics.geometry.shapes import Shape
    from halfphysics.scene.scene import Scene
    from halfphysics.scene.soft import Soft


def fingerprint(bodies: Sequence[Body], scene: Scene) -> str:
    """Of what moves and what it meets: names, places, geometry and masses, not of settings."""
    from halfphysics.scene.trajectories import KinematicObject

    number = 0

    def add(*values: Any) -> None:
        nonlocal number
        for value in values:
            data = value.encode() if isinstance(value, str) else np.asarray(value).tobytes()
            number = zlib.crc32(data, number)

    def add_shape(shape: Shape) -> None:
        add(type(shape).__name__)
        if isinstance(shape, Mesh):
            add(shape.vertices, shape.faces)
        elif is_dataclass(shape):
            add(*(np.asarray(getattr(shape, f.name), dtype=float) for f in fields(shape)))

    def add_soft(soft: Soft | None) -> None:
        if soft is not None:
            add(*map(str, soft.document.values()))

    for static in scene.statics.values():
        add(static.name, static.position, static.quaternion)
        add_shape(static.shape)
        add_soft(static.soft)
    for item in scene.objects.values():
        add(item.name, item.com, item.inertia, np.float64(item.mass))
        for piece in item.pieces:
            add_shape(piece)
        add_soft(item.soft)
        if isinstance(item, KinematicObject):
            add(item.positions, item.quaternions, np.float64(item.fps), np.float64(item.loop))
        elif item.start == "asleep":
            add(item.start)
    for jointed in scene.articulated.values():
        add(jointed.name, jointed.position, jointed.quaternion)
        for link in jointed.links:
            add(link.name, link.position, link.quaternion, link.com, link.inertia)
            add(np.float64(link.mass))
            for joint in link.joints:
                add(joint.name, joint.kind, joint.position, joint.axis)
                add(np.array([joint.lower, joint.upper, joint.damping, joint.stiffness]))
            for geom in link.geoms:
                add(geom.position, geom.quaternion)
                add_shape(geom.shape)
    for body in bodies:
        add(body.rest_joints, *(part.vertices for part in body.variant.parts))
    return f"{len(scene.statics)} statics, {len(scene.objects)} objects, {number:08x}"
