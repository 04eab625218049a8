"""Feet that push: moved onto the thing, and back to the recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.adaptation import feet
from halfphysics.adaptation.feet import Foot
from halfphysics.adaptation.recorded_holds import recorded_holds
from halfphysics.adaptation.thing import Thing
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX
from support.carries.pushes import PushCase, push
from support.carries.takes import PARTS

#: The foot's skin is this near to the surface while it pushes [m].
TOUCHES = 2e-3
LEG = [JOINT_INDEX[f"right_{name}"] for name in ("hip", "knee", "ankle")]


@pytest.fixture(scope="module", params=["gap", "inside"])
def take(request):
    return push(PushCase("box", "toe", "right", 0.3, request.param))


def held(take):
    body, motion = take.bodies[0], take.motions[0]
    thing = Thing.of(take.sequence().scene.objects[take.name], take.track)
    both = [Foot.of(body, side) for side in ("left", "right")]
    return recorded_holds(motion, body, both, thing)


def test_one_foot_pushes_the_box(take):
    (hold,) = held(take)
    assert [part.name for part in hold.parts] == ["right_ankle"]
    first, last = take.span
    assert first <= hold.first < first + 12  # least jerk starts slowly
    assert abs(hold.last - last) <= 3
    assert feet.direction(hold) == pytest.approx([1.0, 0.0, 0.0], abs=0.05)


def test_its_skin_is_on_the_surface_while_the_thing_moves(take):
    (hold,) = held(take)
    foot = Foot.of(take.bodies[0], "right")
    motion, away = feet.kept(take.motions[0], take.bodies[0], foot, hold, hold.arrives[0])
    made = replace(take, motions=(motion,))
    frames = np.arange(hold.first + 10, hold.last - 10, 4)
    gap = made.distances(0, PARTS["right_ankle"], frames).min(axis=1)
    assert np.abs(gap).max() < TOUCHES
    before = take.distances(0, PARTS["right_ankle"], frames).min(axis=1)
    assert np.abs(before).min() > 3.0 * TOUCHES
    assert away < 0.05


def test_only_the_leg_moves_and_only_then(take):
    (hold,) = held(take)
    foot = Foot.of(take.bodies[0], "right")
    was = take.motions[0]
    motion, _ = feet.kept(was, take.bodies[0], foot, hold, hold.arrives[0])
    motion = feet.pushed(motion, take.bodies[0], foot, hold, 50.0, stiffness=1.0, time=0.02)
    joints = np.flatnonzero((motion.rotations != was.rotations).any(axis=(0, 2)))
    assert set(joints) <= {*LEG, JOINT_INDEX["right_foot"]}
    frames = np.flatnonzero((motion.rotations != was.rotations).any(axis=(1, 2)))
    assert frames[0] >= hold.first - 30
    assert frames[-1] <= hold.last + 30
    assert np.array_equal(motion.translation, was.translation)
    # The foot's rotation stays.
    turns = [take.bodies[0].joint_frames(m)[1][:, LEG[2]] for m in (was, motion)]
    assert np.abs(np.sum(turns[0] * turns[1], axis=1)).min() > 1.0 - 1e-4


def test_a_foot_pushes_farther_than_it_stands(take):
    (hold,) = held(take)
    foot, body = Foot.of(take.bodies[0], "right"), take.bodies[0]
    motion, _ = feet.kept(take.motions[0], body, foot, hold, hold.arrives[0])
    beyond = [
        body.joints(feet.pushed(motion, body, foot, hold, f, stiffness=1.0, time=0.02))
        - body.joints(motion)
        for f in (40.0, 80.0)
    ]
    ahead = [b[hold.middle, foot.toe, 0] for b in beyond]
    assert 0.001 < ahead[0] < ahead[1] < 0.04


def test_a_carried_thing_is_no_matter_of_feet_and_a_ridden_one_is_told(take):
    sequence = take.sequence()
    made = hp.adapt(take.motions[0], sequence.scene, take.bodies[0], sequence.recorded)
    assert [hold.parts for hold in made.holds] == [("right_ankle",)]
    assert "with the right foot" in made.summary()
    assert made.holds[0].moved[0] < 0.05
    assert 20.0 < made.holds[0].force < 150.0


def test_what_a_thing_did_before_it_is_pushed_changes_nothing():
    """It was tumbled over in its first frames; the foot is put where it is put otherwise."""
    take = push(PushCase("box", "toe", "right", 0.3, "aside"))
    body, motion = take.bodies[0], take.motions[0]
    item, foot = take.sequence().scene.objects[take.name], Foot.of(body, "right")
    turned = np.array(take.track.quaternion)
    turned[:2] = rot.multiply(rot.exp(np.array([np.pi / 2, 0.0, 0.0])), turned[:2])
    made = []
    for quaternion in (take.track.quaternion, turned):
        thing = Thing(take.name, item, take.track.position, quaternion)
        both = [Foot.of(body, side) for side in ("left", "right")]
        hold = recorded_holds(motion, body, both, thing)[-1]
        made.append(feet.kept(motion, body, foot, hold, hold.arrives[-1]))
    frames = slice(hold.first, hold.last + 1)
    a, b = (body.joints(m)[frames, foot.limb[2]] for m, _ in made)
    assert np.abs(a - b).max() < TOUCHES
