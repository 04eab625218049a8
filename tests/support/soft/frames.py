"""The hard frames of soft things as scenes of their own, for judges that know nothing of layers.

A primitive's frame is smaller by the thickness on all sides, and a plane's is lower: worked out
here. A mesh's frame is that of the package.
"""

from __future__ import annotations

import numpy as np

from halfphysics.body.soft_skin import SoftSkin, soft_core
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.scene.soft_frame import soft_frame


def frame_of(shape, layer):
    """The hard shape under a layer (None: the shape itself)."""
    if layer is None:
        return shape
    t = layer.thickness
    if isinstance(shape, Box):
        return Box(tuple(np.asarray(shape.size) - 2.0 * t))
    if isinstance(shape, Sphere):
        return Sphere(shape.radius - t)
    if isinstance(shape, Capsule):
        return Capsule(shape.radius - t, shape.length)
    if isinstance(shape, Cylinder):
        return Cylinder(shape.radius - t, shape.length - 2.0 * t)
    if isinstance(shape, Plane):
        return Plane(shape.normal, shape.offset - t)
    return soft_frame(shape, layer).frame


def hard(scene, frames=True):
    """The scene without layers: every soft thing as its frame, or as its visible surface."""
    out = Scene(gravity=scene.gravity)
    for name, s in scene.statics.items():
        shape = frame_of(s.shape, s.soft) if frames else s.shape
        out.add_static(
            name, shape, position=s.position, quaternion=s.quaternion, friction=s.friction
        )
    for name, o in scene.objects.items():
        shape = frame_of(o.shape, o.soft) if frames else o.shape
        out.add_object(
            name,
            shape,
            mass=o.mass,
            com=o.com,
            position=o.position,
            quaternion=o.quaternion,
            pieces="hull",
        )
    return out


class Seen:
    """A simulator as a judge sees it: its coordinates, another scene, and the people's hard cores
    where their skin is soft."""

    def __init__(self, simulator, scene):
        world, skin = simulator.world, simulator.world.settings.soft_skin
        people = list(world.people)
        if skin:
            skin = skin if isinstance(skin, SoftSkin) else SoftSkin()
            bodies = [_With(p.body, rest_vertices=soft_core(p.body, skin).vertices) for p in people]
            people = [_With(p, body=body) for p, body in zip(people, bodies, strict=True)]
        self.world = _With(world, scene=scene, people=people)
        self.bodies = simulator.bodies


class _With:
    """A thing with other attributes."""

    def __init__(self, thing, **others):
        self.__dict__.update(others, _thing=thing)

    def __getattr__(self, name):
        return getattr(self._thing, name)
