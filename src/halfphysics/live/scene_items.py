"""People, statics and objects as the first message describes them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.live.schema import PersonItem, SceneItem

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.scene.scene import Scene

#: Meshes of more triangles are described by the box around them: they would not fit a message.
MOST_FACES = 20_000


def person_item(name: str, body: Body) -> PersonItem:
    """A person."""
    return PersonItem(name, body.stature, body.mass, body.rest_joints.tolist())


def scene_items(scene: Scene) -> tuple[list[SceneItem], list[SceneItem]]:
    """Statics, and objects with those that move on trajectories; links are not among them."""
    return (
        [_item(static) for static in scene.statics.values()],
        [_item(item) for item in scene.objects.values()],
    )


def _item(item: Any) -> SceneItem:
    shape = shape_document(item.shape)
    soft = getattr(item, "soft", None)
    return SceneItem(
        name=item.name,
        shape=shape,
        position=[float(x) for x in item.position],
        quaternion=[float(x) for x in item.quaternion],
        friction=float(item.friction),
        mass=float(getattr(item, "mass", None) or 0.0),
        soft=None if soft is None or shape["kind"] == "bounds" else soft.document,
    )


def shape_document(shape: Any) -> dict[str, Any]:
    """A shape as docs/live.md describes it."""
    kind = type(shape).__name__.lower()
    if isinstance(shape, Plane):
        return {"kind": kind}
    if isinstance(shape, Sphere):
        return {"kind": kind, "radius": shape.radius}
    if isinstance(shape, Box):
        return {"kind": kind, "size": [float(x) for x in shape.size]}
    if kind in ("capsule", "cylinder"):
        return {"kind": kind, "radius": shape.radius, "length": shape.length}
    vertices, faces = shape.triangles()[:2]
    if len(faces) > MOST_FACES:
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        return {"kind": "bounds", "low": low.tolist(), "high": high.tolist()}
    return {"kind": "mesh", "vertices": vertices.tolist(), "faces": faces.tolist()}
