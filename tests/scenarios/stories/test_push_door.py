"""A hand pushes a door open: it turns about its hinge, and the person does not pass through it."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.results.result import ObjectTrack


@pytest.fixture(scope="module")
def opened():
    sequence = hp.scenarios.load("push_door")
    result = hp.simulate(
        sequence.motion, sequence.scene, body=sequence.body, settings=sequence.settings
    )
    return sequence, result


def test_the_hand_opens_it_and_the_walk_goes_on(opened):
    sequence, result = opened
    angle = result.joints["door/hinge"]
    assert angle[0] == 0.0
    assert angle.max() > np.radians(80.0)
    assert (angle >= 0.0).all()
    assert (angle <= np.radians(110.0)).all()
    door = result.names.index("door/panel")
    first = result.contacts.part[result.contacts.other == door][0]
    assert hp.JOINT_NAMES[first].startswith("right_")
    # A door of 20 kg hardly slows a person.
    apart = np.linalg.norm(result.motion.translation - sequence.motion.translation, axis=1)
    assert apart.max() < 0.02


def test_nobody_is_in_the_door(opened):
    sequence, result = opened
    asked = hp.metrics.penetration(
        sequence.motion, sequence.body, sequence.scene, objects=closed(result)
    )
    found = hp.metrics.penetration(
        result.motion, sequence.body, sequence.scene, objects=result.objects
    )
    assert asked.depth_max_mm > 10.0
    assert found.rate_percent == 0.0
    assert result.lost_time.sum() == 0.0


def closed(result):
    """The objects' motions without any contact."""
    return {
        name: ObjectTrack(
            position=np.repeat(track.position[:1], len(track.position), axis=0),
            quaternion=np.repeat(track.quaternion[:1], len(track.quaternion), axis=0),
        )
        for name, track in result.objects.items()
    }


def test_a_heavy_door_opens_more_slowly():
    def angle(mass):
        sequence = hp.scenarios.load("push_door", mass=mass)
        settings = hp.Settings(strength="human")
        done = hp.simulate(sequence.motion, sequence.scene, body=sequence.body, settings=settings)
        return done.joints["door/hinge"]

    light, heavy = angle(20.0), angle(2000.0)
    assert heavy.sum() < light.sum()


def test_impossible_doors_are_refused():
    with pytest.raises(InputError, match="mass: found 0"):
        hp.scenarios.load("push_door", mass=0.0)
    with pytest.raises(InputError, match="damping: found -1"):
        hp.scenarios.load("push_door", damping=-1.0)
