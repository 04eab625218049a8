"""What moves as told, whatever is in its way."""

from __future__ import annotations

import numpy as np
import trimesh

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.scene.scene import Scene
from support.attacks import meshes
from support.attacks.registry import family
from support.attacks.stage import MARGIN, Attack, person


def _path(start, way, count):
    return np.asarray(start, float) + np.outer(np.linspace(0.0, 1.0, count), way)


@family
def wall_drive(rng):
    """A wall that drives into a standing person, a fixed wall behind."""
    scene = Scene()
    gap = rng.uniform(0.5, 1.0)
    if rng.random() < 0.7:
        scene.add_static("back", Box((0.1, 4.0, 4.0)), position=(-gap, 0.0, 1.0))
    speed = rng.uniform(0.3, 2.0)
    path = _path((0.05 + MARGIN, 0.0, 1.0), (-speed, 0.0, 0.0), 31)
    scene.add_moving("wall", Box((0.1, 4.0, 4.0)), path, fps=30.0)
    return Attack([person(rng, speed=0.0, seconds=1.0, lower=1.2)], scene)


@family
def press(rng):
    """A plate that presses a person to the floor."""
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, -MARGIN))
    path = _path((-0.1, 0.0, 2.2), (0.0, 0.0, -rng.uniform(0.5, 1.5)), 31)
    scene.add_moving("plate", Box((2.0, 3.0, 0.2)), path, fps=30.0)
    return Attack([person(rng, speed=0.0, seconds=1.0, flail=0.1)], scene)


@family
def stamp(rng):
    """A plate that stamps on an object on the floor, beside and on the person's foot."""
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, -MARGIN))
    scene.add_object("box", Box((0.3, 0.3, 0.2)), mass=2.0, position=(0.25, 0.0, 0.1))
    scene.add_object("ball", Sphere(0.08), mass=0.5, position=(0.25, 0.0, 0.3))
    t = np.linspace(0.0, 1.0, 31)
    path = np.zeros((31, 3))
    path[:, 0], path[:, 2] = 0.3, 0.6 - 0.5 * np.abs(np.sin(2 * np.pi * t))
    scene.add_moving("stamp", Box((0.5, 0.5, 0.1)), path, fps=30.0)
    return Attack([person(rng, speed=0.5, seconds=1.0, flail=0.1)], scene)


@family
def mesh_stamp(rng):
    """A finely cut block that stamps on a fine mesh which the person holds a hand over."""
    scene = Scene()
    scene.add_static("floor", meshes.floor(60, (-1.5, -1.5, -MARGIN), (3.0, 3.0)))
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.12)
    scene.add_object("ball", ball, mass=2.0, position=(0.3, 0.0, 0.12))
    block = trimesh.creation.icosphere(subdivisions=4, radius=0.3)
    t = np.linspace(0.0, 1.0, 31)
    path = np.zeros((31, 3))
    path[:, 0], path[:, 2] = 0.35, 0.9 - 0.5 * np.abs(np.sin(2 * np.pi * t))
    scene.add_moving("block", block, path, fps=30.0)
    return Attack([person(rng, speed=0.6, seconds=1.0, flail=0.2)], scene)


@family
def moving_slab(rng):
    """Thin slabs that pass through the place where the person is, one after the other."""
    scene = Scene()
    for k in range(3):
        at = (1.0 + 0.6 * k, 0.0, rng.uniform(0.3, 1.5))
        path = _path(at, (-rng.uniform(2, 6), 0.0, 0.0), 31)
        scene.add_moving(f"slab{k}", Box((0.4, 2.0, 0.01)), path, fps=30.0)
    return Attack([person(rng, speed=0.0, seconds=1.0, flail=0.1)], scene)


@family
def fan(rng):
    """A rotating blade at the height of the chest, its edge first."""
    scene, count = Scene(), 31
    angle = rng.uniform(4.0, 12.0) * np.linspace(0.0, 1.0, count)
    turns = rot.exp(np.outer(angle, [0.0, 0.0, 1.0]))
    at = np.tile([1.0, 0.0, rng.uniform(0.8, 1.5)], (count, 1))
    scene.add_moving("fan", Box((1.6, 0.1, 0.02)), at, turns, fps=30.0)
    return Attack([person(rng, speed=0.8, seconds=1.0, flail=0.2)], scene)


@family
def turntable(rng):
    """A fine disc under the feet that turns and rises."""
    disc = trimesh.creation.cylinder(1.0, height=0.05, sections=200)
    disc = disc.subdivide()
    count = 31
    turns = rot.exp(np.outer(np.linspace(0, 6, count), [0.0, 0.0, 1.0]))
    path = _path((0.0, 0.0, -0.025 - MARGIN), (0.0, 0.0, 0.3), count)
    scene = Scene()
    scene.add_moving("disc", disc, path, turns, fps=30.0)
    return Attack([person(rng, speed=0.2, seconds=1.0, flail=0.2)], scene)


@family
def shaking_room(rng):
    """A hollow box of thin walls that shakes around the person."""
    scene, count = Scene(), 31
    t = np.linspace(0.0, 1.0, count)
    shake = 0.15 * np.sin(2 * np.pi * rng.uniform(1, 3) * t)
    for k, (size, at) in enumerate(
        (
            ((0.05, 3.0, 3.0), (0.25, 0.0, 1.0)),
            ((0.05, 3.0, 3.0), (-0.65, 0.0, 1.0)),
            ((3.0, 3.0, 0.05), (0.0, 0.0, -0.25)),
            ((3.0, 3.0, 0.05), (0.0, 0.0, 2.1)),
        )
    ):
        path = np.array(at) + np.outer(shake, (1.0, 0.0, 0.5))
        scene.add_moving(f"side{k}", Box(size), path, fps=30.0)
    return Attack([person(rng, speed=0.0, seconds=1.0, flail=0.2)], scene)
