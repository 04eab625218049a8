"""What a person walks or is thrown into."""

from __future__ import annotations

import numpy as np
import trimesh

from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.scene.scene import Scene
from support.attacks import meshes
from support.attacks.registry import family
from support.attacks.stage import MARGIN, Attack, body, clear_of_start, person


def _ahead(motion, shape, at=(MARGIN, 0.0, 0.0), **settings):
    scene = Scene()
    scene.add_static("it", shape, position=at)
    return Attack([motion], scene, settings)


@family
def thin_shell(rng):
    """A closed shell 2 mm thick, finely cut on both sides, bulging towards the person."""

    def bump(a, b):
        return 0.1 * ((2 * a - 1) ** 2 + (2 * b - 1) ** 2)

    front = meshes.wall(90, bump=bump)
    back = meshes.wall(90, bump=lambda a, b: bump(a, b) + 0.002)
    return _ahead(person(rng, speed=2.0, seconds=0.8, flail=0.3), meshes.joined([front, back]))


@family
def soup(rng):
    """Triangles of all sizes, around and before the person."""
    motion = person(rng, speed=1.5, seconds=0.8, flail=0.4)
    cloud = np.concatenate(
        [
            meshes.scattered(rng, 1500, (-0.6, -1, 0), (1.2, 1, 1.8), 0.05),
            meshes.scattered(rng, 3000, (-0.6, -1, 0), (1.2, 1, 1.8), 0.01),
        ]
    )
    clear = clear_of_start(motion, cloud)
    return _ahead(motion, meshes.loose(clear), (0.0, 0.0, 0.0))


@family
def limp_soup(rng):
    """The same with limp joints by Algorithm 1."""
    attack = soup(rng)
    attack.settings.update(drive_time=None, stiffness=0.0)
    return attack


@family
def foam(rng):
    """A wall of small dents: a thousand concave cells of 4 cm."""

    def bump(a, b):
        return 0.03 * np.sin(50 * np.pi * a) * np.sin(50 * np.pi * b) + 0.03

    return _ahead(person(rng, speed=2.0, seconds=0.7, flail=0.3), meshes.wall(200, bump=bump))


@family
def brush(rng):
    """Bristles towards the person, a centimetre apart."""
    y, z = np.meshgrid(np.arange(-0.5, 0.5, 0.025), np.arange(0.2, 1.6, 0.025), indexing="ij")
    middle = np.stack([np.zeros(y.size), y.ravel(), z.ravel()], axis=1)
    tips = middle + rng.uniform((0.0, -0.01, -0.01), (0.03, 0.01, 0.01), middle.shape)
    bristles = meshes.spikes(tips, middle + np.array([0.2, 0.0, 0.0]), 0.001)
    return _ahead(person(rng, speed=1.5, seconds=0.7, flail=0.2), bristles)


@family
def fine_ball(rng):
    """A ball of 80,000 triangles at the hip."""
    ball = trimesh.creation.icosphere(subdivisions=6, radius=0.4)
    return _ahead(person(rng, speed=2.0, seconds=0.7, flail=0.3), ball, (0.4 + MARGIN, 0.0, 0.9))


@family
def coarse_turns(rng):
    """One substep a frame at 15 frames a second, joints at 10 rad/s, beside a fine wall."""
    motion = person(rng, speed=1.5, seconds=1.5, flail=1.2, fps=15.0)
    return _ahead(motion, meshes.wall(60, (0.0, -1.5, -0.5), (3.0, 3.0)), substeps=1)


@family
def teleport(rng):
    """The motion jumps half a metre between two frames, into and out of a fine wall."""
    motion = person(rng, speed=1.0, seconds=1.0, flail=0.2)
    path = motion.translation.copy()
    path[10:20, 0] += rng.uniform(0.3, 0.8)
    path[20:, 1] += rng.uniform(-0.5, 0.5)
    motion = motion.with_frames(path, motion.rotations)
    return _ahead(motion, meshes.wall(50, (0.0, -2.0, -0.5), (4.0, 3.0)), (0.15, 0.0, 0.0))


@family
def corner(rng):
    """Into the edge where two fine walls meet."""
    one = meshes.wall(70, (0.4, 0.0, 0.0), (1.5, 2.0), lambda a, b: -0.9 * a)
    two = meshes.wall(70, (0.4, 0.0, 0.0), (-1.5, 2.0), lambda a, b: -0.9 * a)
    motion = person(rng, speed=2.0, seconds=0.8, lower=1.2)
    return _ahead(motion, meshes.joined([one, two]), (0.6, 0.0, 0.0))


@family
def behind_hulls(rng):
    """Hundreds of tiny triangles a few millimetres behind the back, a plate before the chest."""
    motion = person(rng, speed=rng.uniform(1, 5), seconds=0.5)
    skin = body().vertices(motion, frames=[0])[0]
    back = skin[np.argsort(skin[:, 0])[: len(skin) // 3]]
    places = back[rng.integers(0, len(back), 1500)].copy()
    places[:, 0] -= rng.uniform(0.004, 0.02, 1500)
    cloud = places[:, None] + 0.0008 * rng.normal(size=(1500, 3, 3))
    cloud = clear_of_start(motion, cloud)
    plate = [[[0.015 + MARGIN, -2, -1], [0.015 + MARGIN, 2, -1], [0.015 + MARGIN, 0, 4]]]
    return _ahead(motion, meshes.loose(np.concatenate([cloud, plate])), (0.0, 0.0, 0.0))


@family
def behind_ball(rng):
    """A ball at 5 m/s with tiny triangles behind it and a plate 15 mm ahead."""
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.1)
    at = np.array([2.0, 0.0, 1.0])
    plate = np.array([[0.115, -0.3, -0.3], [0.115, 0.3, -0.3], [0.115, 0.3, 0.3]])
    plate = np.array([plate, [plate[0], plate[2], [0.115, -0.3, 0.3]]]) + at
    cloud = meshes.behind(rng, int(rng.choice([40, 120, 300])), at, 0.1)
    scene = Scene()
    scene.add_static("cloud", meshes.loose(np.concatenate([cloud, plate])))
    scene.add_object("ball", ball, mass=1.0, position=at, velocity=(5.0, 0.0, 0.0))
    return Attack([person(rng, speed=0.0, seconds=0.5)], scene)


@family
def object_pile(rng):
    """Boxes and balls of a gram to a tonne that fall on each other before the person."""
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, -MARGIN))
    for k in range(14):
        shape = Box(rng.uniform(0.1, 0.25, 3)) if k % 2 else Sphere(0.1)
        at = (0.35 + rng.uniform(-0.05, 0.05), rng.uniform(-0.05, 0.05), 0.15 + 0.32 * k)
        mass = float(10 ** rng.uniform(-3, 3))
        scene.add_object(f"thing{k}", shape, mass=mass, position=at)
    return Attack([person(rng, speed=1.0, seconds=1.2, flail=0.2)], scene)


@family
def heavy_on_light(rng):
    """A tonne on a gram on a plate, and the person walks into them."""
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, -MARGIN))
    for k, mass in enumerate((100.0, 0.001, 1000.0, 0.01)):
        scene.add_object(
            f"thing{k}", Box((0.3, 0.3, 0.2)), mass=mass, position=(0.4, 0.0, 0.08 + 0.205 * k)
        )
    return Attack([person(rng, speed=2.0, seconds=1.0, flail=rng.uniform(0, 0.3))], scene)


@family
def thrown_at(rng):
    """Fine meshes thrown at the person."""
    scene = Scene()
    for k in range(3):
        ball = trimesh.creation.icosphere(subdivisions=4, radius=0.08)
        at = (1.0 + 0.3 * k, rng.uniform(-0.3, 0.3), rng.uniform(0.5, 1.6))
        scene.add_object(f"ball{k}", ball, mass=5.0, position=at, velocity=(-10.0, 0.0, 1.0))
    return Attack([person(rng, speed=1.0, seconds=0.8, flail=0.3)], scene)
