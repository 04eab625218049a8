"""People who reach: hands go where they are told, row by row."""

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.envs.reachers import HASTE, Reachers
from halfphysics.envs.worlds import Plan, Worlds
from halfphysics.geometry.shapes import Plane
from halfphysics.scene.scene import Scene

DT = 1.0 / 30.0


def people(count):
    body, scene = Body.default(), Scene()
    scene.add_static("floor", Plane())
    watched = ("person/right_wrist", "person/right_middle1")
    worlds = Worlds(Plan(scene=scene, bodies=(body,), watched=watched), count, dt=DT)
    made = Reachers(body, worlds)
    for i in range(count):
        worlds.start(i, [made.start(i, np.array([0.3 * i, -0.2 * i]), 0.5 * i)])
    return made, worlds


def reach(made, worlds, goal, seconds=2.0):
    """Where the wrists are told to be and where they are simulated, in the world (N, 3)."""
    on = np.ones(worlds.count, dtype=bool)
    for _ in range(round(seconds / DT)):
        made.tell(4.0 * (goal - made.wrist), np.zeros(worlds.count), DT, on)
        worlds.step(made.targets(), np.zeros((worlds.count, 0)))
    return made.point_to_world(made.wrist), worlds.place("person/right_wrist")[:, :3]


def test_the_wrist_comes_where_it_is_told():
    made, worlds = people(3)
    goal = np.array([[0.33, -0.15, 1.12], [0.32, -0.02, 1.2], [0.25, -0.35, 1.1]])
    told, there = reach(made, worlds, goal)
    assert made.wrist == pytest.approx(goal, abs=5e-3)
    assert there == pytest.approx(told, abs=5e-3)


def test_the_palm_is_up_in_front_and_the_arm_hangs_before():
    made, worlds = people(1)
    hangs = worlds.place("person/right_wrist")[0, :3]
    assert made.point_to_world(made.wrist)[0] == pytest.approx(hangs, abs=1e-6)
    reach(made, worlds, np.array([[0.33, -0.15, 1.15]]))
    wrist = worlds.place("person/right_wrist")
    palm = made.palms(wrist)[0] - wrist[0, :3]
    ahead = worlds.place("person/right_middle1")[0, :3] - wrist[0, :3]
    assert ahead[0] > 0.07  # fingers away from the person
    assert palm[2] > ahead[2] + 0.01  # the palm's skin on top
    assert made.from_world(made.to_world(palm[None]))[0] == pytest.approx(palm)


def test_what_is_out_of_reach_is_approached_with_bounded_haste():
    made, _ = people(1)
    on, before = np.ones(1, dtype=bool), np.zeros((1, 3))
    for _ in range(60):
        made.tell(np.array([[9.0, 0.0, 3.0]]), np.zeros(1), DT, on)
        change = made.speed - before
        if np.linalg.norm(made.wrist[0] - made._shoulder) < 0.9 * made._arm.length:
            assert np.linalg.norm(change) <= HASTE * DT + 1e-9
        before = made.speed
    assert np.linalg.norm(made.wrist[0] - made._shoulder) <= made._arm.length


def test_no_row_depends_on_the_others():
    goal = np.array([[0.33, -0.15, 1.12], [0.28, 0.05, 1.2], [0.25, -0.35, 1.1]])
    many, one = people(3), people(1)
    reach(*many, goal, 0.5)
    reach(*one, goal[:1], 0.5)
    assert np.array_equal(many[0].targets()[:1], one[0].targets())
    assert np.array_equal(many[1].poses[:1], one[1].poses)
