"""A kick: momentum is exchanged exactly, and the ball flies the same at every frame rate."""

from __future__ import annotations

import numpy as np
import pytest
from people import along_x

from halfphysics import reference
from halfphysics.body import Body
from halfphysics.scene import Scene
from halfphysics.settings import Settings
from halfphysics.shapes import Plane, Sphere
from halfphysics.simulator import Simulator

DRIVES = {"time constant": 0.02, "algorithm 1": None}


@pytest.fixture(scope="module")
def body():
    return Body.default()


def swing(body, fps, back=True):
    """One second: the right leg swings forward by 1.2 rad in 0.2 s and back, or stays there."""
    n = round(fps) + 1
    t = np.clip((np.arange(n) / fps - 0.3) / 0.4, 0.0, 1.0)
    forward = np.sin(np.pi * t) if back else 0.5 - 0.5 * np.cos(np.pi * np.clip(2 * t, 0.0, 1.0))
    motion = along_x(0.0, n, start=0.0, fps=fps)
    rotations = motion.rotations.copy()
    rotations[:, 2, 0] = 0.4 - 1.2 * forward
    return motion.with_frames(motion.translation, rotations).grounded(body, 0.002)


def before_the_foot(body, mass, radius=0.3, ahead=0.5, height=None, **material):
    """A ball `ahead` of the toe: on the floor, or weightless with its centre at `height` [m]."""
    toe = body.joints(swing(body, 30.0))[0, 11]
    scene = Scene(gravity=9.81 if height is None else 0.0)
    if height is None:
        scene.add_static("floor", Plane())
    position = (toe[0] + ahead + radius, toe[1], radius if height is None else height)
    scene.add_object("ball", Sphere(radius), mass=mass, position=position, **material)
    return scene


def kick(body, scene, motion, settings=None):
    """The ball's speed after every frame."""
    simulator = Simulator(scene, body=body, settings=settings, fps=motion.fps)
    simulator.reset(motion[0])
    d, speed = simulator.world.things[0].dof, []
    for t in range(1, len(motion)):
        simulator.step(motion[t])
        speed.append(np.linalg.norm(simulator.world.stepper.qvel()[d : d + 3]))
    return np.array(speed)


def peaks(body, mass, back, settings=None, **ball):
    """Peak speeds at 30, 60 and 120 fps."""
    scene = before_the_foot(body, mass, **ball)
    motions = (swing(body, fps, back) for fps in (30.0, 60.0, 120.0))
    return np.array([kick(body, scene, m, settings).max() for m in motions])


# On the floor a ball as high as the knee: under a small heavy one the foot wedges itself, and a
# millimetre then decides how it comes out. Weightless at the height of the ankle it may be small.
BALLS = {
    "on the floor": {"radius": 0.3},
    "weightless": {"radius": 0.11, "ahead": 0.39, "height": 0.2},
}


@pytest.mark.parametrize("mass", [0.5, 5.0, 200.0])
@pytest.mark.parametrize("back", [True, False], ids=["out and back", "held out"])
@pytest.mark.parametrize("ball", BALLS)
def test_a_kick_is_as_strong_at_every_frame_rate(body, ball, back, mass):
    speed = peaks(body, mass, back, **BALLS[ball])
    assert speed.max() <= 1.1 * speed.min()


@pytest.mark.parametrize("back", [True, False], ids=["out and back", "held out"])
def test_a_light_ball_flies_five_times_as_fast_as_a_heavy_one(body, back):
    light = peaks(body, 0.5, back, **BALLS["on the floor"])
    heavy = peaks(body, 200.0, back, **BALLS["on the floor"])
    assert light.min() >= 5.0 * heavy.max()


def test_algorithm_1_kicks_harder_at_a_higher_frame_rate(body):
    """What the time constant is for: setting the velocity every frame adds momentum every frame."""
    settings = Settings(drive_time=None)
    speed = peaks(body, 200.0, True, settings, **BALLS["weightless"])
    assert speed[2] > 1.5 * speed[0]


@pytest.mark.parametrize("stiffness", [0.0, 1.0])
@pytest.mark.parametrize("drive", DRIVES)
def test_momentum_of_body_and_ball(body, drive, stiffness):
    """Nothing else is near: what the ball gains in a solve the body loses, over a whole kick too.

    With a time constant the drive makes the body s times heavier, and it loses 1/s of it.
    """
    fps = 240.0  # one substep a frame, so that every one can be looked at
    settings = Settings(drive_time=DRIVES[drive], stiffness=stiffness)
    scene = before_the_foot(body, 5.0, **BALLS["weightless"])
    motion = swing(body, 30.0).resample(fps)
    simulator = Simulator(scene, body=body, settings=settings, fps=fps)
    simulator.reset(motion[0])
    stepper, model = simulator.world.stepper, simulator.world.model
    stepper.keep_trace(True)
    person, ball = simulator.world.people[0], simulator.world.things[0].dof
    root = int(model.jnt_dofadr[model.body_jntadr[person.root]])
    scale = 1.0
    if settings.drive_time is not None:
        scale = (1.0 + 1.0 / fps / settings.drive_time) ** 2
    lost, gained, reported = np.zeros(3), np.zeros(3), np.zeros(3)
    solves = 0
    for t in range(1, len(motion)):
        frame = simulator.step(motion[t])
        trace = stepper.trace()
        if not len(trace["contacts"]["dist"]):
            continue
        solves += 1
        # The root's rows of M v are the linear momentum of the whole body.
        rows = reference.inertia_matrix(model, trace["qpos"])[root : root + 3]
        change = trace["v"] - trace["v_free"]
        change_of_ball, change_of_body = 5.0 * change[ball : ball + 3], rows @ change
        size = np.abs(rows * trace["v"]).sum() + 5.0 * np.abs(trace["v"][ball : ball + 3]).sum()
        assert np.abs(scale * change_of_body + change_of_ball).max() <= 1e-9 * size
        gained, lost = gained + change_of_ball, lost + scale * change_of_body
        reported = reported + frame.contacts.impulse[frame.contacts.person == 0].sum(axis=0)
    assert solves >= 3
    assert np.linalg.norm(gained) > 5.0  # [N s]: it was a kick
    np.testing.assert_allclose(gained, 5.0 * stepper.qvel()[ball : ball + 3], atol=1e-9)
    np.testing.assert_allclose(lost, -gained, atol=1e-9 * np.linalg.norm(gained))
    np.testing.assert_allclose(reported, -gained, atol=1e-9 * np.linalg.norm(gained))
