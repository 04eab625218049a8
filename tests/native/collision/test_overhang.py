"""Objects on the edge of static geometry tip exactly when their centre of mass is beyond it."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Cylinder
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator

FPS, FRAMES = 30.0, 45
GRAVITY = 9.81
CLEARANCE = Settings.paper().clearance
#: The top of the table is at z = 0, its edge at x = 0 (both in the table's frame) [m].
TABLE = (1.0, 1.0, 0.1)
#: So far on either side of the edge a centre of mass decides [m].
NEAR_EDGE = 1e-3
#: What stays put tilts less [rad] and moves less [m]; what tips tilts more [rad].
STILL_TILT, STILL, TIPPED = 2e-4, 1e-4, 0.1
#: So that nothing slides off [-].
FRICTION = 1.0
#: Of the energy: differences of poses that are 33 ms apart, and the clearance of the edge [-].
PENDULUM = 0.03


def prism() -> trimesh.Trimesh:
    """A convex mesh of 21 corners, its centre of mass off the middle of its base."""
    around = np.linspace(0, 2 * np.pi, 14)[:-1]
    base = np.stack([0.15 * np.cos(around), 0.15 * np.sin(around), 0 * around], axis=1)
    top = np.stack([0.03 + 0.1 * np.cos(around[::2]), 0.1 * np.sin(around[::2])], axis=1)
    return trimesh.PointCloud(
        np.concatenate([base, np.column_stack([top, np.full(len(top), 0.2)])])
    ).convex_hull


#: Name -> shape, height of its centre over its base, centre of mass in its own frame [m].
PRISM = prism()
OBJECTS = {
    "box": (Box((0.3, 0.3, 0.3)), 0.15, np.zeros(3)),
    "board": (Box((0.6, 0.3, 0.02)), 0.01, np.zeros(3)),
    "cylinder": (Cylinder(0.1, 0.3), 0.15, np.zeros(3)),
    "prism": (PRISM, 0.0, PRISM.center_mass),
}


def table(kind: str):
    """A table as a convex hull, or as a mesh of 12 or of thousands of triangles."""
    if kind == "hull":
        return Box(TABLE)
    mesh = trimesh.creation.box(TABLE)
    return mesh.subdivide_to_size(0.03) if kind == "fine mesh" else mesh


def at_edge(kind, name, beyond, yaw=0.0, frames=FRAMES):
    """Poses of an object whose centre of mass is `beyond` the edge of a table: positions (n, 3)
    from the edge, quaternions (n, 4); and the time that was lost [s]."""
    turn = rot.exp([0.0, 0.0, yaw])
    scene = Scene()
    shape, height, centre = OBJECTS[name]
    middle = np.array([-0.5 * TABLE[0], 0.0, -0.5 * TABLE[2]])
    place = np.array([beyond, 0.0, height + CLEARANCE]) - centre * [1, 1, 0]
    placed = {"quaternion": turn, "friction": FRICTION}
    scene.add_static("table", table(kind), position=rot.rotate(turn, middle), **placed)
    scene.add_object("object", shape, mass=2.0, position=rot.rotate(turn, place), **placed)
    simulator = Simulator(scene, body=[], settings=Settings.paper(), fps=FPS)
    simulator.reset([])
    poses = [simulator.world.stepper.qpos()]
    lost = 0.0
    for _ in range(frames):
        lost += simulator.step([]).lost_time
        poses.append(simulator.world.stepper.qpos())
    poses = np.stack(poses)
    return rot.rotate(rot.conjugate(turn), poses[:, :3]), poses[:, 3:7], lost


def tilt(quaternion):
    """Of an object's own vertical (n,) [rad]."""
    return np.arccos(np.clip(rot.to_matrix(quaternion)[:, 2, 2], -1, 1))


@pytest.mark.parametrize("kind", ["hull", "mesh", "fine mesh"])
@pytest.mark.parametrize("name", OBJECTS)
@pytest.mark.parametrize("yaw", [0.0, 0.7])
def test_tips_when_its_centre_of_mass_is_beyond_the_edge(kind, name, yaw):
    place, quaternion, lost = at_edge(kind, name, -NEAR_EDGE, yaw)
    assert tilt(quaternion).max() < STILL_TILT
    assert np.abs(place - place[0]).max() < STILL
    assert lost == 0
    _, quaternion, lost = at_edge(kind, name, NEAR_EDGE, yaw)
    assert tilt(quaternion).max() > TIPPED
    assert lost == 0


@pytest.mark.parametrize("kind", ["hull", "mesh", "fine mesh"])
def test_turns_about_the_edge_as_a_pendulum_does(kind):
    """Its energy about the edge: I w^2 / 2 = m g (fall of its centre), while friction holds it."""
    beyond, half = 0.05, 0.15
    place, quaternion, _ = at_edge(kind, "box", beyond)
    angle = tilt(quaternion)
    arm2 = beyond**2 + half**2
    w = np.gradient(angle, 1 / FPS)
    fall = place[0, 2] - place[:, 2]
    energy = 0.5 * (2 / 3 * half**2 + arm2) * w**2
    turning = np.arange(len(angle)) < np.argmax(angle > 0.5)
    turning &= angle > 0.1
    assert turning.sum() >= 4
    np.testing.assert_allclose(energy[turning], GRAVITY * fall[turning], rtol=PENDULUM)
    far = np.linalg.norm(place[turning][:, [0, 2]], axis=1)
    np.testing.assert_allclose(far, np.sqrt(arm2), atol=2 * CLEARANCE)


def test_a_board_on_a_block_is_a_seesaw():
    """A weight on the end of a board on a block takes it down; over the block it does not."""
    for beyond, goes in ((0.1, False), (0.3, True)):
        scene = Scene()
        scene.add_static("block", Box((0.4, 0.6, 0.4)), position=(0.0, 0.0, -0.2))
        scene.add_object("board", Box((2.0, 0.6, 0.1)), mass=10.0, position=(0.0, 0.0, 0.051))
        scene.add_object("weight", Box((0.2, 0.2, 0.2)), mass=60.0, position=(beyond, 0.0, 0.203))
        simulator = Simulator(scene, body=[], settings=Settings.paper(), fps=FPS)
        simulator.reset([])
        for _ in range(FRAMES):
            simulator.step([])
        assert (tilt(simulator.world.stepper.qpos()[None, 3:7])[0] > TIPPED) == goes
