"""What rests face on face, down to the thickness of paper: it stays flat, however thin it is."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Cylinder, Plane
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulator import Simulator
from support.spins import GAP

#: What was set down flat stays there: metres, and radians.
STILL = 1e-6
#: What fell tilted comes to rest flat to within this [rad], and this high [m].
FLAT, LANDED = 1e-3, 1e-5
#: Height of the table [m].
TABLE = 0.5

THIN = {
    "coin": lambda thickness: Cylinder(0.0125, thickness),
    "card": lambda thickness: Box((0.085, 0.055, thickness)),
}


def table(kind: str) -> Scene:
    """A table that is a static or an object; its top is at TABLE."""
    scene = Scene()
    if kind == "static":
        scene.add_static("table", Box((1, 1, TABLE)), position=(0, 0, TABLE / 2))
    else:
        scene.add_static("floor", Plane())
        size = (1, 1, TABLE - GAP)
        scene.add_object("table", Box(size), mass=50.0, position=(0, 0, TABLE - size[2] / 2))
    return scene


def rest(scene: Scene, seconds: float) -> tuple[np.ndarray, float]:
    """Position of what was added last, and its tilt [rad], after some time."""
    simulator = Simulator(scene, body=[], fps=30)
    simulator.reset([])
    for _ in range(round(seconds * 30)):
        simulator.step([])
    pose = simulator.world.stepper.qpos()[-7:]
    up = rot.rotate(pose[3:], [0.0, 0.0, 1.0])
    return pose[:3], float(np.arctan2(np.hypot(up[0], up[1]), abs(up[2])))


@pytest.mark.parametrize("on", ["static", "object"])
@pytest.mark.parametrize("thickness", [0.0002, 0.001, 0.00175, 0.0019, 0.0021, 0.004])
@pytest.mark.parametrize("name", THIN)
def test_thin_things_stay_flat(name, thickness, on):
    """Both sides of a thing thinner than 2 mm are near the table; the lower one touches it."""
    for turn in ([1.0, 0, 0, 0], rot.exp([0, 0, 0.3]), [0.0, 1, 0, 0], [0.0, 0, 1, 0]):
        scene = table(on)
        at = np.array([0.1, 0.05, TABLE + GAP + thickness / 2])
        scene.add_object("thing", THIN[name](thickness), mass=0.01, position=at, quaternion=turn)
        position, tilt = rest(scene, 1.0)
        assert np.abs(position - at).max() < STILL
        assert tilt < STILL


@pytest.mark.parametrize("on", ["static", "object"])
@pytest.mark.parametrize("name", THIN)
def test_thin_things_fall_flat(name, on):
    for thickness in (0.0005, 0.00175):
        scene = table(on)
        at = (0, 0, TABLE + 0.02)
        turn = rot.exp([0.2, 0.1, 0])
        scene.add_object("thing", THIN[name](thickness), mass=0.01, position=at, quaternion=turn)
        position, tilt = rest(scene, 2.0)
        assert tilt < FLAT
        assert position[2] == pytest.approx(TABLE + GAP + thickness / 2, abs=LANDED)


@pytest.mark.parametrize("thickness", [0.0015, 0.01])
@pytest.mark.parametrize("sides", [129, 1000])
def test_a_pile_of_discs_with_many_sides(sides, thickness):
    """Of their corners some are enough: the upper one stands over the lower one's edge."""
    disc = trimesh.creation.cylinder(0.0125, thickness, sections=sides)
    scene = table("object")
    for k, x in enumerate((0.1, 0.106)):
        at = np.array([x, 0.05, TABLE + (k + 1) * GAP + (k + 0.5) * thickness])
        scene.add_object(f"disc{k}", disc, mass=0.01, position=at)
    position, tilt = rest(scene, 0.5)
    assert np.abs(position - at).max() < STILL
    assert tilt < STILL


def test_a_pile_of_cards_and_coins():
    scene, height = table("static"), TABLE
    for k in range(6):
        name, thickness = ("card", 0.0008) if k % 2 == 0 else ("coin", 0.0016)
        at = (0, 0, height + GAP + thickness / 2)
        scene.add_object(f"thing{k}", THIN[name](thickness), mass=0.01, position=at)
        height = at[2] + thickness / 2
    position, tilt = rest(scene, 1.0)
    assert tilt < FLAT
    assert position[2] == pytest.approx(at[2], abs=LANDED)


@pytest.mark.parametrize("on", ["static", "object"])
@pytest.mark.parametrize("yaw", [0.0, 0.4])
def test_a_wire_lies_on_its_near_side(yaw, on):
    """All of a wire of a millimetre is near; it does not sink by its radius, nor tilt."""
    scene, radius = table(on), 0.0005
    at = np.array([0.1, 0.05, TABLE + GAP + radius])
    turn = rot.multiply(rot.exp([0, 0, yaw]), rot.exp([0, np.pi / 2, 0]))
    scene.add_object("thing", Cylinder(radius, 0.3), mass=0.01, position=at, quaternion=turn)
    position, tilt = rest(scene, 1.0)
    assert np.abs(position - at).max() < STILL
    assert tilt == pytest.approx(np.pi / 2, abs=STILL)
