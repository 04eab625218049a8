"""Soft things of every shape and law that are dropped: no energy is made, whatever they fall on."""

from __future__ import annotations

import numpy as np
import pytest
from trimesh.creation import icosphere

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.scene.scene import Scene
from support.soft.scenes import energies, run

#: Energy above that of the start, in units of the weight: a height [m]. Velocities of a frame's end
#: belong to half a substep earlier.
MADE = 1e-4


def ellipsoid(size):
    mesh = icosphere(1)
    mesh.apply_scale(0.5 * size)
    return mesh


#: Shapes of a size (3,) [m], and the distance of their farthest point from the middle.
SHAPES = {
    "box": (lambda s: Box(tuple(s)), lambda s: 0.5 * np.linalg.norm(s)),
    "ball": (lambda s: Sphere(0.5 * s[0]), lambda s: 0.5 * s[0]),
    "capsule": (lambda s: Capsule(s[0] / 3, s[1]), lambda s: s[0] / 3 + 0.5 * s[1]),
    "cylinder": (lambda s: Cylinder(0.5 * s[0], s[1]), lambda s: 0.5 * np.hypot(s[0], s[1])),
    "mesh": (ellipsoid, lambda s: 0.5 * s.max()),
}


def dropped(seed, shape, floor):
    """A soft thing at some height over a hard or soft floor, or over the edge of a table."""
    rng = np.random.default_rng(seed)
    size, thickness = rng.uniform(0.15, 0.6, 3), rng.uniform(0.01, 0.03)
    make, reach = SHAPES[shape]
    if seed % 3:
        layer = hp.Soft.named(
            str(rng.choice(["sofa", "mattress", "pillow", "mat"])), thickness=thickness
        )
    else:
        layer = hp.Soft(thickness=thickness, stiffness=10 ** rng.uniform(4, 6), law="linear")
    scene = Scene()
    scene.add_static("floor", Plane(), soft="mattress" if floor == "soft" else None)
    if floor == "table":
        scene.add_static("table", Box((0.3, 0.3, 0.3)), position=(0.1, 0.05, 0.15))
    height = reach(size) + rng.choice([0.0, 0.1, 1.0]) + (0.3 if floor == "table" else 0.0)
    scene.add_object(
        "thing",
        make(size),
        mass=10 ** rng.uniform(-1, 2),
        position=(0.0, 0.0, height),
        quaternion=rot.exp(rng.choice([0.0, 1.0]) * rng.normal(size=3)),
        soft=layer,
    )
    return scene


@pytest.mark.parametrize("floor", ["hard", "soft", "table"])
@pytest.mark.parametrize("shape", SHAPES)
def test_no_energy_is_made(shape, floor):
    for seed in range(3):
        scene = dropped(seed, shape, floor)
        result = run(scene, 1.5, fps=[30.0, 60.0, 120.0][seed])
        energy = energies(result, scene)
        thing = scene.objects["thing"]
        weight = thing.mass * np.linalg.norm(scene.gravity)
        assert energy.max() <= energy[0] + MADE * weight
