"""Islands: what happens in one changes no bit of another."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.bench.clips import straight
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulate import simulate
from support.as_it_is import as_it_is

FRAMES = 30
#: How far apart the two places are [m]: nothing of one is within reach of the other.
APART = 20.0


@pytest.fixture(scope="module")
def body():
    return Body.default()


def into_the_wall(y: float, start: float = -0.25, turned: float = 0.0):
    """A person who walks along x at `y`, into the wall where `start` is near enough."""
    motion = straight(1.5, (FRAMES - 1) / 30.0, start)
    shift = np.array([0.0, y, 0.0])
    return motion.with_frames(motion.translation + shift, motion.rotations)


def calm(scene: Scene) -> None:
    """A wall and, before it, two boxes that lie on a table, and a ball that drops on another."""
    scene.add_static("wall", Box((0.01, 6.0, 6.0)), position=(0.5, 0.0, 0.0))
    scene.add_static("table", Box((1.0, 1.0, 0.1)), position=(3.0, 0.0, 0.0))
    scene.add_object("under", Box((0.2, 0.2, 0.1)), mass=2.0, position=(3.0, 0.0, 0.101))
    scene.add_object("on", Box((0.1, 0.1, 0.1)), mass=1.0, position=(3.0, 0.01, 0.2021))


def trouble(scene: Scene, kind: str) -> None:
    """What keeps another solver busy, `APART` from there."""
    if kind == "squeezed":  # a tonne comes from behind while a wall is ahead
        scene.add_static("there", Box((0.01, 6.0, 6.0)), position=(0.5, APART, 0.0))
        scene.add_object("tonne", Box((0.5, 1.0, 1.5)), mass=1000.0, velocity=(3.0, 0.0, 0.0),
                         position=(-1.2, APART, 0.0))  # fmt: skip
    if kind == "gap":  # too narrow for the chest: clearances give way and steps are shortened
        for name, side in (("left", 1.0), ("right", -1.0)):
            scene.add_static(name, Box((1.0, 0.2, 4.0)), position=(0.6, APART + side * 0.22, 0.0))
    if kind == "crushed":  # a plate that nothing stops comes from behind
        scene.add_static("there", Box((0.01, 6.0, 6.0)), position=(0.5, APART, 0.0))
        way = np.linspace(-1.2, 0.3, FRAMES)[:, None] * [1.0, 0.0, 0.0] + [0.0, APART, 0.0]
        scene.add_moving("plate", Box((0.5, 2.0, 2.0)), way, fps=30.0)
    if kind == "woken":
        scene.add_object("there", Box((0.5, 1.0, 2.0)), mass=50.0, start="asleep",
                         position=(0.6, APART, 0.0))  # fmt: skip
    if kind == "bouncing":
        scene.add_static("floor", Box((2.0, 2.0, 0.1)), position=(0.0, APART + 3.0, 0.0))
        scene.add_object("ball", Sphere(0.1), mass=1.0, restitution=0.9,
                         position=(0.0, APART + 3.0, 0.4))  # fmt: skip


def run(body, kind: str, **settings):
    scene = Scene()
    calm(scene)
    trouble(scene, kind)
    motions = [into_the_wall(0.0), into_the_wall(APART)]
    return simulate(motions, scene, body=[body, body], settings=as_it_is(substeps=8, **settings))


@pytest.mark.filterwarnings("ignore:no room")  # between the plate and the wall
@pytest.mark.parametrize(
    "settings", [{}, {"self_contact": True}, {"strength": "human"}, {"contact": "parts"}], ids=str
)
@pytest.mark.parametrize("kind", ["squeezed", "crushed", "gap", "woken", "bouncing"])
def test_trouble_elsewhere_changes_no_bit(body, kind, settings):
    alone, beside = run(body, "none", **settings), run(body, kind, **settings)
    # There is contact here, and the other place takes another course.
    assert (alone.contacts.person == 0).sum() > FRAMES
    if kind != "bouncing":
        there = [r.people[1].motion.rotations for r in (alone, beside)]
        assert not np.array_equal(*there)
    for name in ("translation", "rotations"):
        np.testing.assert_array_equal(
            getattr(alone.people[0].motion, name), getattr(beside.people[0].motion, name)
        )
    for name in ("under", "on"):
        for field in ("position", "quaternion"):
            np.testing.assert_array_equal(
                getattr(alone.objects[name], field), getattr(beside.objects[name], field)
            )
