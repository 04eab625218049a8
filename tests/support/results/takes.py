"""A small scene with one item of each kind, and a moving person: input of exporters."""

from __future__ import annotations

from functools import cache

import numpy as np

import halfphysics as hp
from halfphysics.base import rotations as rot
from support.files.layouts import movement

#: A cabinet with a door, a drawer in it and a lamp on a ball joint.
CABINET = """
<mujoco>
  <worldbody>
    <body name="case"><geom type="box" size=".2 .2 .3"/>
      <body name="door" pos=".2 -.2 0">
        <joint name="hinge" axis="0 0 1" pos="0 0 .1" range="-100 10" ref="5" damping=".2"/>
        <geom type="box" size=".01 .2 .3" pos=".02 .2 0" mass="2"/>
        <body name="knob"><joint name="knob" axis="1 0 0"/>
          <geom type="sphere" size=".02" pos=".05 .35 0" mass=".1"/></body>
      </body>
      <body name="drawer" pos="0 0 .35"><joint name="slide" type="slide" axis="0 1 0"/>
        <geom type="box" size=".1 .1 .04" mass="1"/></body>
      <body name="lamp" pos="0 0 .5"><joint name="ball" type="ball"/>
        <geom type="capsule" size=".02 .1" pos="0 0 .1" mass=".3"/></body>
    </body>
  </worldbody>
</mujoco>
"""


def wedge(size: float = 0.2) -> hp.Mesh:
    """A convex solid that is no primitive."""
    corners = size * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1], [0, 1, 1.0]])
    faces = [[0, 2, 1], [1, 2, 3], [0, 1, 4], [2, 5, 3], [1, 3, 5], [1, 5, 4], [0, 4, 5], [0, 5, 2]]
    return hp.Mesh(corners, np.array(faces))


#: The two halves of `corner`.
APART = np.array([0.5, 0.0, 0.0])


def sheet() -> hp.Mesh:
    """An open, flat surface of one triangle."""
    return hp.Mesh(np.array([[-3, -3, 0], [3, -3, 0], [0, 3, 0.0]]), np.array([[0, 1, 2]]))


def corner() -> hp.Mesh:
    """Two wedges as one mesh: not convex."""
    a = wedge()
    return hp.Mesh(
        np.vstack([a.vertices, a.vertices + APART]),
        np.vstack([a.faces, a.faces + len(a.vertices)]),
    )


def scene(*, meshes: bool = True) -> hp.Scene:
    """One item of each kind; without `meshes` only shapes that MuJoCo can collide."""
    turn = rot.exp(np.array([0.1, 0.2, 0.3]))
    made = hp.Scene()
    made.add_static("floor", hp.Plane((0.0, 0.1, 1.0), -1.5), quaternion=turn)
    made.add_static("post", hp.Cylinder(0.1, 2.0), position=[1.2, 0, 0], quaternion=turn)
    made.add_static("step", wedge(), position=[-1, -1, -1])
    if meshes:
        made.add_static("room", corner(), position=[-1, 1, -1], quaternion=turn)
        made.add_static("sheet", sheet(), position=[0, 0, -1.8])
    made.add_object("world", hp.Box([0.2, 0.3, 0.1]), mass=1.0, position=[0, 1, 1])
    made.add_object(
        "ball", hp.Sphere(0.1), mass=0.5, position=[0.3, 0.9, 0.2], velocity=[0, -3.0, 1.0]
    )
    pieces = [wedge(), hp.Mesh(wedge().vertices + APART, wedge().faces)]
    made.add_object("pair", corner(), mass=2.0, pieces=pieces, position=[0, -1.5, 1])
    way = np.linspace([1, -1, 0], [1, -1, 0.4], 5)
    turns = rot.exp(np.linspace([0, 0, 0], [0, 0, 1.0], 5))
    made.add_moving("lift", hp.Capsule(0.1, 0.3), way, turns, fps=10)
    made.add_articulated(
        "cabinet", CABINET, position=[-1.5, 0, 0], quaternion=turn, velocities={"hinge": -2.0},
        joints={"slide": 0.1, "ball": rot.exp(np.array([0.3, 0, 0])).tolist()},
    )  # fmt: skip
    made.ignore("person", "post")
    made.ignore("ball", "person/head")
    return made


@cache
def result(people: int = 1) -> hp.Result:
    """A person in that scene, simulated for 0.4 s."""
    motions = []
    for i in range(people):
        translation, rotations = movement(13, seed=i)
        motions.append(hp.Motion(translation + np.array([0, 3.0 * i, 0.2]), rotations, 30.0))
    return hp.simulate(motions if people > 1 else motions[0], scene())
