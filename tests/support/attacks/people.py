"""People against themselves and each other."""

from __future__ import annotations

import numpy as np

from halfphysics.geometry.shapes import Plane, Sphere
from halfphysics.scene.scene import Scene
from support.attacks import meshes
from support.attacks.registry import family
from support.attacks.stage import MARGIN, Attack, person, turned


def _two(rng, speed=1.2, flail=0.0, apart=1.0, lower=0.0, seconds=1.2):
    """Two people who walk into each other."""
    first, second = (
        person(rng, speed=speed, seconds=seconds, flail=flail, lower=lower) for _ in range(2)
    )
    return [
        turned(first, 0.0, (0, 0, 0)),
        turned(second, np.pi, (apart, rng.uniform(-0.2, 0.2), 0)),
    ]


@family
def self_contact(rng):
    """One person with self-contact who flails with all joints."""
    motion = person(rng, speed=0.5, seconds=1.2, flail=rng.uniform(0.5, 1.2))
    return Attack([motion], Scene(), {"self_contact": True})


@family
def self_contact_limp(rng):
    """The same, limp by Algorithm 1, on a floor of triangles."""
    motion = person(rng, (0.0, 0.0, -1.0), 1.0, 1.0, flail=0.6)
    scene = Scene()
    scene.add_static("floor", meshes.floor(60, (-1.5, -1.5, -MARGIN), (3.0, 3.0)))
    return Attack([motion], scene, {"self_contact": True, "drive_time": None, "stiffness": 0.0})


@family
def two_clearance(rng):
    """Two people with self-contact and a clearance of 5 mm."""
    motions = _two(rng, flail=0.2, apart=0.9, lower=rng.uniform(0, 0.6))
    return Attack(motions, Scene(), {"self_contact": True, "clearance": 0.005})


@family
def two_flailing(rng):
    """Two people who flail into each other at speed."""
    return Attack(_two(rng, 3.0, 0.6, 1.6), Scene())


@family
def two_in_soup(rng):
    """Two people who meet in a cloud of loose triangles."""
    scene = Scene()
    cloud = meshes.scattered(rng, 800, (0.42, -0.8, 0.0), (0.58, 0.8, 1.8), 0.02)
    scene.add_static("cloud", meshes.loose(cloud))
    return Attack(_two(rng, 1.5, 0.0, 1.0, seconds=0.8), scene)


@family
def two_and_things(rng):
    """Two people with a heap of balls between them."""
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, -MARGIN))
    for k in range(10):
        at = (0.5 + rng.uniform(-0.02, 0.02), rng.uniform(-0.05, 0.05), 0.1 + 0.17 * k)
        scene.add_object(
            f"ball{k}", Sphere(0.08), mass=float(10 ** rng.uniform(-1, 2)), position=at
        )
    return Attack(_two(rng, 1.5, 0.1, 1.0), scene)


@family
def wide_clearance(rng):
    """A clearance of 50 mm before a fine wall."""
    scene = Scene()
    scene.add_static("wall", meshes.wall(80), position=(0.1, 0.0, 0.0))
    motion = person(rng, speed=1.5, seconds=0.8, flail=0.2)
    return Attack([motion], scene, {"clearance": 0.05})


@family
def many_substeps(rng):
    """Ten thousand steps a second, flailing on a floor of triangles."""
    scene = Scene()
    scene.add_static("floor", meshes.floor(40, (-1.5, -1.5, -MARGIN), (3.0, 3.0)))
    motion = person(rng, (0.0, 0.0, -1.0), 1.5, 0.4, flail=0.4)
    return Attack([motion], scene, {"substeps": 64})
