"""Contact turns no joint beyond its range, or beyond what the motion itself asks."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import Settings
from halfphysics.body.joint_ranges import JointRanges
from halfphysics.geometry.shapes import Box, Plane
from halfphysics.motion.skeleton import JOINT_INDEX
from support.people import along_x, violent

#: Joints may be so far beyond max(range, reference) [degrees].
EXCESS = 2.0
KINDS = {
    "default": {},
    "lambda 0": {"stiffness": 0.0},
    "lambda 10": {"stiffness": 10.0},
    "human": {"strength": "human"},
    "algorithm 1": {"drive_time": None},
    "limp": {"drive_time": None, "stiffness": 0.0},
}


@pytest.fixture(scope="module")
def body():
    return hp.Body.default()


def excess(result, body):
    """Largest excess of any joint [degrees]."""
    person = result.people[0]
    angles = JointRanges.of(body).excess(person.motion.rotations, person.reference.rotations)
    return float(np.degrees(angles[:, 1:]).max())


@pytest.mark.parametrize("drive_time", [0.02, None])
@pytest.mark.parametrize("substeps", [None, 1])
def test_free_motion_is_the_same_to_the_bit(body, drive_time, substeps):
    """However far beyond the ranges, even where something is near."""
    motion = violent(20)
    assert JointRanges.of(body).excess(motion.rotations, np.zeros((20, 55, 3))).max() > 1.0
    scene = hp.Scene()
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(3.0, 0.0, 0.0))
    runs = [
        hp.simulate(
            motion,
            scene,
            body=body,
            settings=Settings(drive_time=drive_time, substeps=substeps, joint_limits=limits),
        )
        for limits in (False, True)
    ]
    np.testing.assert_array_equal(runs[0].motion.rotations, runs[1].motion.rotations)
    assert excess(runs[1], body) < 1e-9


@pytest.mark.parametrize("kind", KINDS)
def test_walking_into_a_wall(body, kind):
    """Hands, feet and head meet it, and toes the floor."""
    motion = along_x(1.5, 24, start=-0.2).grounded(body, 0.0005)
    scene = hp.Scene()
    scene.add_static("wall", Box((0.1, 6.0, 6.0)), position=(0.6, 0.0, 0.0))
    scene.add_static("floor", Plane())
    result = hp.simulate(
        motion, scene, body=body, settings=Settings(joint_limits=True, **KINDS[kind])
    )
    assert excess(result, body) < EXCESS
    assert result.clearance.min() > 0.0
    assert sum(result.lost_time) == 0.0


def test_a_hand_that_pushes_stops_at_its_range(body):
    """Without limits a flat hand folds onto the forearm."""
    motion = hand_forward(body)
    scene = hp.Scene()
    wrist = body.joints(motion)[0, JOINT_INDEX["left_middle3"]]
    scene.add_static("wall", Box((2.0, 0.1, 2.0)), position=(wrist[0], wrist[1] + 0.12, wrist[2]))
    bent = {}
    for limits in (False, True):
        settings = Settings(joint_limits=limits)
        bent[limits] = excess(hp.simulate(motion, scene, body=body, settings=settings), body)
    assert bent[False] > 10.0
    assert bent[True] < EXCESS


def test_a_motion_beyond_the_ranges_is_the_range(body):
    """Contact stops a joint where the motion has it, if that is farther than people's joints go."""
    motion = hand_forward(body, back=110.0)
    scene = hp.Scene()
    wrist = body.joints(motion)[0, JOINT_INDEX["left_wrist"]]
    scene.add_static("wall", Box((2.0, 0.1, 2.0)), position=(wrist[0], wrist[1] + 0.2, wrist[2]))
    result = hp.simulate(motion, scene, body=body, settings=Settings(joint_limits=True))
    angles = np.degrees(JointRanges.of(body).angles(result.motion.rotations))
    assert excess(result, body) < EXCESS
    assert angles[:, JOINT_INDEX["left_wrist"], 1].min() < -105.0


def hand_forward(body, back=0.0):
    """The left arm stretched to the side, along y, in 30 frames 0.5 m farther; the wrist bent back
    by `back` degrees."""
    motion = along_x(0.0, 30, start=0.0)
    rotations = np.array(motion.rotations)
    rotations[:, JOINT_INDEX["left_wrist"]] = (0.0, 0.0, np.radians(back))
    path = np.array(motion.translation)
    path[:, 1] += np.linspace(0.0, 0.5, 30)
    return motion.with_frames(path, rotations)


def test_the_squeezed_are_never_held(body):
    """Two plates close on a hand that cannot bend so far: it comes to no overlap all the same."""
    motion = along_x(0.0, 40, start=0.0)
    tip = body.joints(motion)[0, JOINT_INDEX["left_middle3"]]
    scene = hp.Scene()
    scene.add_static("wall", Box((2.0, 0.1, 2.0)), position=(tip[0], tip[1] + 0.1, tip[2]))
    times = np.linspace(0.0, 1.0, 40)
    positions = np.tile([tip[0] - 0.6, tip[1] - 0.1, tip[2] - 0.45], (40, 1))
    positions[:, 2] += 0.35 * times
    scene.add_moving("plate", Box((0.9, 0.5, 0.05)), positions, fps=30)
    result = hp.simulate(motion, scene, body=body, settings=Settings(joint_limits=True))
    assert result.clearance.min() > 0.0
    assert len(result.breaches) == 0


def test_a_state_taken_over_gives_the_same_bits(body):
    motion = along_x(1.5, 24, start=-0.2)
    scene = hp.Scene()
    scene.add_static("wall", Box((0.1, 6.0, 6.0)), position=(0.6, 0.0, 0.0))
    simulator = hp.Simulator(scene, body=body, settings=Settings(joint_limits=True), fps=30)
    simulator.reset(motion[0])
    for t in range(1, 16):
        simulator.step(motion[t])
    state = simulator.get_state()
    first = [simulator.step(motion[t]).pose.rotations for t in range(16, 24)]
    simulator.set_state(state)
    again = [simulator.step(motion[t]).pose.rotations for t in range(16, 24)]
    np.testing.assert_array_equal(first, again)


def test_off_for_the_paper():
    assert not Settings.paper().joint_limits
    assert Settings.paper(joint_limits=True).joint_limits
