"""What a person falls on or walks over."""

from __future__ import annotations

import numpy as np

from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.scene.scene import Scene
from support.attacks import meshes
from support.attacks.registry import family
from support.attacks.stage import MARGIN, Attack, person

DOWN = (0.0, 0.0, -1.0)


def _under(motion, shape, depth=MARGIN, **options):
    scene = Scene()
    scene.add_static("ground", shape, position=(0.0, 0.0, -depth), **options)
    return Attack([motion], scene)


@family
def terrain(rng):
    """A height field of 2 cm cells, fallen and walked on."""
    rough = rng.normal(size=(161, 161))

    def bump(a, b):
        return -0.06 * np.abs(rough[np.rint(a * 160).astype(int), np.rint(b * 160).astype(int)])

    motion = person(rng, (0.6, 0.0, -0.8), 1.5, 1.0, flail=0.3, far=1.2)
    return _under(motion, meshes.floor(160, (-1.6, -1.6, 0.0), (3.2, 3.2), bump))


@family
def fine_terrain(rng):
    """Waves of 5 mm cells under somebody who lies down on them with the whole body."""
    phase = rng.uniform(0, 6, 2)

    def bump(a, b):
        return -0.01 - 0.01 * np.sin(60 * a + phase[0]) * np.sin(60 * b + phase[1])

    motion = person(rng, DOWN, 1.0, 1.0, flail=0.2, lower=0.4)
    return _under(motion, meshes.floor(300, (-0.75, -0.75, 0.0), (1.5, 1.5), bump))


@family
def loose_stairs(rng):
    """A stair of triangles that share no vertex and leave gaps."""
    parts = []
    for k in range(6):
        x, z = 0.05 + 0.25 * k, 0.12 * (k + 1)
        parts += [
            np.array([[x, -1, 0], [x, 1, 0], [x, 1, z]]),
            np.array([[x, -1, 0.002], [x, 0.998, z], [x, -1, z]]),
            np.array([[x, -1, z], [x, 1, z], [x + 0.25, 1, z]]),
            np.array([[x, -1, z + 0.001], [x + 0.25, 1, z], [x + 0.25, -1, z]]),
        ]
    motion = person(rng, (1.0, 0.0, 0.0), rng.uniform(1, 4), 0.8, flail=0.2)
    return _under(motion, meshes.loose(parts), 0.0)


@family
def needles(rng):
    """A bed of needles, 3 cm apart, 2 mm thick."""
    x, y = np.meshgrid(np.arange(-1.0, 1.0, 0.05), np.arange(-1.0, 1.0, 0.05), indexing="ij")
    middle = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    tips = middle + rng.uniform((-0.01, -0.01, -0.03), (0.01, 0.01, 0.0), middle.shape)
    needles = meshes.spikes(tips, middle - np.array([0.0, 0.0, 0.25]), 0.002)
    return _under(person(rng, DOWN, 1.5, 0.8, flail=0.2), needles)


@family
def leaves(rng):
    """Thousands of loose leaves on the ground, some on edge."""
    cloud = meshes.scattered(rng, 3000, (-1, -1, -0.25), (1, 1, -0.08), 0.02)
    motion = person(rng, (0.4, 0.0, -0.9), 1.5, 0.8, flail=0.3)
    scene = Scene()
    scene.add_static("leaves", meshes.loose(cloud))
    scene.add_static("floor", Plane(), position=(0.0, 0.0, -0.4))
    return Attack([motion], scene)


@family
def sheet_stack(rng):
    """Parallel sheets of triangles, a millimetre apart, that the person is pushed into."""
    sheets = [meshes.floor(12, (-1, -1, -0.001 * k), (2, 2)) for k in range(12)]
    return _under(person(rng, DOWN, 2.0, 0.7, flail=0.3), meshes.joined(sheets))


@family
def stones(rng):
    """Hundreds of primitive boxes and balls close together."""
    scene = Scene()
    for k in range(300):
        at = (*rng.uniform(-0.8, 0.8, 2), -0.15 - rng.uniform(0, 0.1))
        shape = Box(rng.uniform(0.03, 0.1, 3)) if k % 2 else Sphere(rng.uniform(0.02, 0.06))
        scene.add_static(f"stone{k}", shape, position=at)
    return Attack([person(rng, DOWN, 1.5, 0.7, flail=0.3)], scene)


@family
def slivers(rng):
    """A floor cut into triangles a thousand times longer than wide."""
    y = np.linspace(-1.0, 1.0, 800)
    z = -0.002 * rng.random(800)
    ends = [np.stack([np.full(800, x), y, z], axis=1) for x in (-1.5, 1.5)]
    k = np.arange(799)
    faces = np.concatenate(
        [np.stack([k, k + 800, k + 801], axis=1), np.stack([k, k + 801, k + 1], axis=1)]
    )
    motion = person(rng, DOWN, 1.5, 0.8, flail=0.3)
    return _under(motion, meshes.mesh(np.concatenate(ends), faces))
