"""A recorded carry: a suitcase between two palms, and the same by a person who stands beside it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import halfphysics as hp

#: The recorded thing is off the hands by this [m], as sensors are.
NOISE = (-0.006, 0.018, 0.008)


@pytest.fixture(scope="session")
def carry():
    """The suitcase as it was carried, the person without fingers and 2 cm beside it."""
    story = hp.scenarios.load("lift_suitcase", shake=0.0, carry=1.0)
    made = hp.simulate(story.motion, story.scene, body=story.body)
    rotations = np.array(made.motion.rotations)
    rotations[:, 25:] = 0.0
    motion = made.motion.with_frames(made.motion.translation + NOISE, rotations)
    return SimpleNamespace(
        motion=motion, scene=story.scene, body=story.body, recorded=dict(made.objects)
    )


@pytest.fixture(scope="session")
def grasp():
    """A glass as it was taken and lifted with one hand, its fingers recorded."""
    story = hp.scenarios.load("grasp_glass", stages=("lift",))
    made = hp.simulate(story.motion, story.scene, body=story.body)
    motion = made.motion.with_frames(made.motion.translation + NOISE, made.motion.rotations)
    return SimpleNamespace(
        motion=motion, scene=story.scene, body=story.body, recorded=dict(made.objects)
    )
