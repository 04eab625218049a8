"""Fingers that close around a thing."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.adaptation import fingers
from halfphysics.adaptation.grips import Place
from halfphysics.adaptation.hands import Hand
from halfphysics.adaptation.thing import Thing
from halfphysics.body.joint_ranges import JointRanges
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS
from halfphysics.results.result import ObjectTrack

#: Fingers come as near as this without going in deeper than that [m].
NEAR, INSIDE = 0.004, 0.001


def cylinder(radius):
    scene = hp.Scene()
    scene.add_object("can", hp.Cylinder(radius, 0.3), mass=0.3)
    track = ObjectTrack(position=np.zeros((2, 3)), quaternion=np.tile([1.0, 0, 0, 0], (2, 1)))
    return Thing.of(scene.objects["can"], track)


def around(radius, side="right"):
    """A hand whose palm is at a cylinder along the hand's z axis, fingers straight."""
    body = hp.Body.default()
    hand = Hand.of(body, side)
    way = float(
        np.linalg.norm(
            body.rest_joints[JOINT_INDEX[f"{side}_middle1"]] - body.rest_joints[hand.wrist]
        )
    )
    # The knuckles are over the axis, the palm's skin as far from it as the radius and 8 mm.
    wrist = -way * hand.ahead + [0.0, radius + 0.008 - hand.palm[1], 0.0]
    point = wrist + hand.palm
    normal = np.array([0.0, 1.0, 0.0])
    place = Place(hand, point, normal, -normal, np.eye(3), point, np.eye(3), grasps=True)
    thing = cylinder(radius)
    return body, thing, place, fingers.closed(body, thing, place, np.zeros((15, 3)), known=False)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("radius", [0.025, 0.035, 0.045])
def test_fingers_and_thumb_touch_and_do_not_go_in(radius, side):
    body, thing, place, found = around(radius, side)
    hand = fingers._Hand(body, thing, place)
    angles = np.zeros((1, N_JOINTS, 3))
    angles[0, found.joints] = found.angles
    part = body.weights.argmax(axis=1)
    for name in ("index", "middle", "ring", "thumb"):
        joints = [JOINT_INDEX[f"{side}_{name}{k}"] for k in (1, 2, 3)]
        skin = np.flatnonzero(np.isin(part, joints)).astype(np.int32)
        gaps = thing.gaps(hand.seen(angles, skin))
        assert -INSIDE < gaps.min() < NEAR, name


def test_nothing_closes_beyond_its_range():
    body, _, _, found = around(0.025)
    ranges = JointRanges.of(body)
    assert np.all(found.angles >= ranges.lower[found.joints] - 1e-12)
    assert np.all(found.angles <= ranges.upper[found.joints] + 1e-12)


def test_the_thumb_presses_against_the_fingers():
    body, thing, place, found = around(0.035)
    hand = fingers._Hand(body, thing, place)
    angles = np.zeros((1, N_JOINTS, 3))
    angles[0, found.joints] = found.angles
    part = body.weights.argmax(axis=1)
    middles = []
    for name in ("middle", "thumb"):
        tip = np.flatnonzero(part == JOINT_INDEX[f"right_{name}3"]).astype(np.int32)
        skin = hand.seen(angles, tip)[0]
        middles.append(skin[thing.gaps(skin).argmin()] * [1.0, 1.0, 0.0])
    a, b = (m / np.linalg.norm(m) for m in middles)
    assert a @ b < 0.6  # not from the same side


def test_what_is_out_of_reach_is_not_touched():
    body = hp.Body.default()
    hand = Hand.of(body, "right")
    point = np.array([0.0, 1.0, 0.0])
    place = Place(hand, point, point, -point, np.eye(3), point, np.eye(3), grasps=True)
    found = fingers.closed(body, cylinder(0.03), place, np.zeros((15, 3)), known=False)
    assert not found.presses.any()


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("radius", [0.025, 0.035, 0.045])
def test_an_open_hand_bends_no_joint_backwards(radius, side):
    """Only the thumb's root opens, within its range, and by more than fingers do."""
    body, _, _, found = around(radius, side)
    root = list(found.joints).index(JOINT_INDEX[f"{side}_thumb1"])
    flexion = np.delete(found.opened[:, 1], root)
    assert flexion.min() > -1e-12
    assert np.all(flexion <= np.delete(found.angles[:, 1], root) + 1e-12)
    lower = JointRanges.of(body).lower[found.joints[root], 1]
    assert lower - 1e-12 <= found.opened[root, 1] < found.angles[root, 1] - 0.3


def on_a_bar(width, known=False):
    """A right palm flat on a board under its index and middle fingers only; flexions by name."""
    body = hp.Body.default()
    hand = Hand.of(body, "right")
    scene = hp.Scene()
    scene.add_object("board", hp.Box((0.6, 0.04, width)), mass=0.3)
    track = ObjectTrack(position=np.zeros((2, 3)), quaternion=np.tile([1.0, 0, 0, 0], (2, 1)))
    ring = body.rest_joints[JOINT_INDEX["right_ring1"]] - body.rest_joints[hand.wrist]
    # The board's side is between middle and ring.
    middle = body.rest_joints[JOINT_INDEX["right_middle1"]] - body.rest_joints[hand.wrist]
    side = 0.5 * (ring[2] + middle[2])
    point = np.array([0.0, 0.02, -0.5 * width - side + hand.palm[2]])
    normal = np.array([0.0, 1.0, 0.0])
    place = Place(hand, point, normal, -normal, np.eye(3), point, np.eye(3))
    found = fingers.closed(
        body, Thing.of(scene.objects["board"], track), place, np.zeros((15, 3)), known
    )
    names = ("index", "middle", "ring", "pinky")
    rows = [
        [list(found.joints).index(JOINT_INDEX[f"right_{n}{k}"]) for k in (1, 2, 3)] for n in names
    ]
    return found.angles[rows, 1], found.presses[rows, 1]


def test_fingers_that_meet_nothing_are_bent_like_those_that_touch():
    flexion, presses = on_a_bar(0.2)
    assert presses[:2].any(axis=1).all()
    assert not presses[3].any()
    assert np.all(np.abs(flexion[3] - flexion[:2].mean(axis=0)) < 0.3)


def test_recorded_fingers_that_meet_nothing_stay_as_recorded():
    flexion, presses = on_a_bar(0.2, known=True)
    assert not presses[3].any()
    assert np.all(flexion[3] == 0.0)
