"""A short simulation with everything in it, made once: people, objects, a door, contacts of all."""

from __future__ import annotations

from functools import cache

import numpy as np

import halfphysics as hp
from support.people import along_x

FRAMES = 24

DOOR = """
<mujoco><worldbody><body name="leaf" pos="0 0 0">
  <joint name="hinge" type="hinge" axis="0 0 1" damping="0.1"/>
  <geom type="box" size="0.02 0.4 0.9" pos="0 0.4 0" mass="8"/>
</body></worldbody></mujoco>
"""
WEDGE = (
    np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]], dtype=np.float64),
    np.array(
        [[0, 2, 1], [0, 3, 2], [0, 4, 5], [0, 5, 3], [1, 2, 5], [1, 5, 4], [0, 1, 4], [2, 3, 5]]
    ),
)


def scene():
    """A floor, a wall, a mesh, a box on the floor, a platform, a door."""
    made = hp.Scene()
    made.add_static("floor", hp.Plane())
    made.add_static("wall", hp.Box((0.1, 6.0, 6.0)), position=(0.95, 0.0, 0.0))
    made.add_static("ramp", hp.Mesh(*WEDGE), position=(-4.0, 2.0, 0.0))
    made.add_object("box", hp.Box((0.3, 0.3, 0.3)), mass=2.0, position=(0.15, -0.4, 1.3))
    made.add_object("crate", hp.Box((0.4, 0.4, 0.4)), mass=5.0, position=(-2.0, -2.0, 0.2))
    path = np.linspace([-2.6, -2.0, 0.06], [-2.2, -2.0, 0.06], 5)
    made.add_moving("platform", hp.Box((0.5, 0.5, 0.1)), path, fps=10.0)
    made.add_articulated("door", DOOR, position=(0.3, -1.3, 0.92))
    made.friction("box", "person/left_wrist", 0.4)
    made.ignore("crate", "ramp")
    return made


def motions():
    """Two people: one walks at the wall and the door, one stands near and is walked into."""
    first = along_x(1.5, FRAMES, start=-0.3, z=0.95)
    second = along_x(-0.5, FRAMES, start=0.4, z=0.95)
    aside = second.translation + np.array([0.0, 1.15, 0.0])
    return [first, second.with_frames(aside, second.rotations)]


@cache
def result():
    """Both in the scene, with every substep."""
    settings = hp.Settings(record="substeps", blocked="continue", weight=False)
    return hp.simulate(motions(), scene(), settings=settings)


@cache
def alone():
    """One person and one object."""
    made = hp.Scene()
    made.add_static("floor", hp.Plane())
    made.add_object("box", hp.Box((0.3, 0.3, 0.3)), mass=2.0, position=(0.2, -0.4, 1.2))
    return hp.simulate(motions()[0], made, settings=hp.Settings(weight=False))
