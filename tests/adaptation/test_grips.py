"""Where hands hold a thing."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.adaptation.fingers import thumb_aside
from halfphysics.adaptation.grips import fingers_at, fingers_known, places
from halfphysics.adaptation.hands import SIDES, Hand
from halfphysics.adaptation.recorded_holds import recorded_holds
from halfphysics.adaptation.thing import Thing
from halfphysics.motion.skeleton import JOINT_INDEX
from support.carries.recordings import Case, recording

#: Points are on the surface, and palms flat on it, to this [m] and [rad].
ON, FLAT = 1e-9, 1e-6
#: A palm rolls off the ball of its thumb by at most this [rad]; then both sides are level to this
#: [m]: half a degree at 4 cm, and what a suitcase's side is cut off.
ROLLED, LEVEL = np.radians(12.5), 1e-3
FRICTION = 0.8


def held(recording, name):
    body = recording.body
    thing = Thing.of(recording.scene.objects[name], recording.recorded[name])
    hands = [Hand.of(body, side) for side in SIDES]
    (hold,) = recorded_holds(recording.motion, body, hands, thing)
    return hold, places(recording.motion, body, hold, FRICTION)


def palm_skin(body, hand):
    """Skin of a palm in the wrist's frame (n, 3) [m]."""
    part = np.argmax(body.weights[hand.inner], axis=1)
    own = hand.inner[part == hand.wrist]
    return body.rest_vertices[own] - body.rest_joints[hand.wrist]


def test_two_palms_lie_flat_on_opposite_sides(carry):
    hold, its = held(carry, "suitcase")
    for place in its:
        palm = place.wrist + palm_skin(carry.body, place.hand) @ place.turn.T
        assert abs(hold.thing.gaps(palm).min()) < ON
        # It is rolled about its fingers, which lie along the surface.
        faces = place.turn @ [0.0, -1.0, 0.0]
        assert np.arccos(np.clip(-faces @ place.normal, -1.0, 1.0)) < ROLLED
        assert abs(place.turn @ [1.0, 0.0, 0.0] @ place.normal) < FLAT
        assert np.abs(place.turn @ place.turn.T - np.eye(3)).max() < 1e-12
    a, b = its
    assert a.presses @ b.presses == pytest.approx(-1.0)


def test_a_palm_bears_on_both_of_its_sides(carry):
    """The ball of the thumb and the little finger's side are level on a suitcase's flat side."""
    _, its = held(carry, "suitcase")
    body, vertices = carry.body, np.asarray(carry.body.rest_vertices)
    part = np.argmax(body.weights, axis=1)
    for place in its:
        side = place.hand.side
        root = JOINT_INDEX[f"{side}_thumb1"]
        rotations = np.zeros((2, 55, 3))
        rotations[:, root] = thumb_aside(body, side)
        skin = body.vertices(hp.Motion(np.zeros((2, 3)), rotations, fps=30.0), frames=0)
        out = (skin - body.rest_joints[place.hand.wrist]) @ place.turn.T @ place.normal
        ball = out[part == root].min()
        flat = vertices[:, 2] < body.rest_joints[place.hand.wrist][2] + place.hand.palm[2]
        other = out[(part == place.hand.wrist) & flat].min()
        assert abs(ball - other) < LEVEL


def test_the_line_between_two_palms_is_in_both_cones(carry):
    _, its = held(carry, "suitcase")
    for place in its:
        assert -place.presses @ place.normal > np.cos(np.arctan(FRICTION))


def test_hands_below_a_tray_go_on_until_its_weight_is_above_them():
    """Recorded at its near edge, 12 cm short of the middle, where finger tips alone would bear.

    On until the fingers bear, and no farther: a forearm from above would meet the edge.
    """
    made = recording(Case("tray", way="up", ends="air"))
    sequence = made.sequence()
    body, thing = sequence.body, Thing.of(sequence.scene.objects["tray"], made.track)
    motion = sequence.motion
    motion = motion.with_frames(motion.translation - [0.03, 0.0, 0.0], motion.rotations)
    (hold,) = recorded_holds(motion, body, [Hand.of(body, side) for side in SIDES], thing)
    for place in places(motion, body, hold, FRICTION):
        assert not place.presses.any()
        short = thing.item.com[0] - place.point[0]
        assert -0.02 < short < 0.10 < thing.item.com[0] - place.seen[0]


def test_palms_stay_where_they_were_recorded(carry):
    """Off by 2 cm of noise, moved by no more than that and what a palm is from its own middle."""
    _, its = held(carry, "suitcase")
    for place in its:
        assert np.linalg.norm(place.point - place.seen) < 0.045


def test_a_grasping_hand_is_moved_back_by_the_noise_across_the_glass(grasp):
    """Along a cylinder nothing tells where the hand was."""
    hold, (place,) = held(grasp, "glass")
    assert place.grasps
    moved = place.point - place.seen
    up = hold.thing.turn[hold.middle].T @ [0.0, 0.0, 1.0]
    across = moved - (moved @ up) * up
    assert np.linalg.norm(across) < 0.045
    assert np.allclose(place.turn, place.seen_turn)


def test_fingers_that_were_not_recorded_are_known_not_to_be(carry, grasp):
    body = carry.body
    hand = Hand.of(body, "right")
    assert not fingers_known(carry.motion, hand)
    assert fingers_known(grasp.motion, hand)
    hold, (place,) = held(grasp, "glass")
    kept = grasp.motion.rotations[hold.middle, list(hand.fingers)]
    assert np.array_equal(fingers_at(grasp.motion, place, hold.middle), kept)


def test_a_thumb_aside_is_in_the_plane_of_the_palm(carry):
    from halfphysics.base import rotations as rot

    rest = carry.body.rest_joints
    for side in SIDES:
        first, last = (rest[JOINT_INDEX[f"{side}_thumb{k}"]] for k in (1, 3))
        along = rot.rotvec_to_matrix(thumb_aside(carry.body, side)) @ (last - first)
        assert abs(along[1]) < 1e-9
