"""The frame's shortcut: what is proved clear is clear all the way, and what is clear is proved."""

from itertools import pairwise

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.scenarios.acting.gait import Walk, walk
from support.as_it_is import as_it_is
from support.people import t_pose

BODY = hp.Body.default()
CLEARANCE = 0.001
#: Places on the way from one frame to the next at which the skin is looked at.
PLACES = 24
HIP, KNEE = (hp.JOINT_NAMES.index(f"left_{name}") for name in ("hip", "knee"))


def swing(rng, fps=30.0):
    """A leg that swings through below the body, at up to 18 rad/s: lowest between two frames."""
    frames, speed = 4, rng.uniform(8.0, 18.0)
    motion = t_pose(np.zeros((frames, 3)), fps)
    rotations = np.array(motion.rotations)
    turn = (np.arange(frames) - rng.uniform(1.2, 1.8)) * speed / fps
    rotations[:, HIP, 0] = -turn
    rotations[:, KNEE, 0] = rng.uniform(0.0, 0.3)
    # The other leg is out of the way.
    rotations[:, hp.JOINT_NAMES.index("right_knee"), 0] = 1.5
    return motion.with_frames(motion.translation, rotations)


def lowest_on_the_way(motion):
    """Lowest height of the skin at PLACES places in every frame (T - 1, PLACES) [m]."""
    quats = rot.exp(motion.rotations)
    share = (np.arange(PLACES) / PLACES)[:, None, None]
    lowest = []
    for a, b in pairwise(quats):
        turn = rot.log(rot.multiply(rot.conjugate(a), b))
        between = rot.log(rot.multiply(a, rot.exp(share * turn)))
        way = hp.Motion(np.zeros((PLACES, 3)), between, motion.fps)
        lowest.append(BODY.vertices(way)[..., 2].min(axis=1))
    return np.array(lowest)


def over(motion, height):
    """The motion over a floor, its lowest point on all of the way `height` above that [m]."""
    scene = hp.Scene()
    scene.add_static(
        "floor", hp.Plane(), position=(0.0, 0.0, lowest_on_the_way(motion).min() - height)
    )
    return hp.simulate(motion, scene, body=BODY, settings=as_it_is())


@pytest.mark.parametrize("case", range(12))
def test_a_leg_that_swings_close_over_the_ground_is_followed(case):
    rng = np.random.default_rng([1, case])
    motion = swing(rng)
    # The hull of a foot is below its skin by less than a millimetre there.
    result = over(motion, CLEARANCE + rng.uniform(0.0025, 0.006))
    assert not result.contacts.impulse.any()
    assert not np.asarray(result.diagnostics["planes"]).any()  # no frame was stepped through
    assert hp.metrics.mpjpe(result.motion, motion, BODY) < 1e-9


@pytest.mark.parametrize("case", range(12))
def test_what_dips_into_the_ground_between_frames_is_stopped(case):
    rng = np.random.default_rng([2, case])
    motion = swing(rng)
    result = over(motion, CLEARANCE - rng.uniform(0.0005, 0.006))
    assert len(result.contacts)
    assert not len(result.breaches)


def test_a_walk_on_the_ground_is_followed():
    """Feet of the default's walks pass 3 mm over the ground: nothing is stepped through."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    result = hp.simulate(walk(BODY, Walk(distance=3.0, speed=1.2), 30.0), scene, body=BODY)
    assert not np.asarray(result.diagnostics["planes"]).any()
    assert not len(result.contacts.part)
