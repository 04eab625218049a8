"""When recorded hands hold a recorded thing."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.adaptation.hands import SIDES, Hand
from halfphysics.adaptation.recorded_holds import recorded_holds
from halfphysics.adaptation.thing import Thing
from halfphysics.results.result import ObjectTrack

#: The first move is found to this [s]: a thing that is lifted least jerk starts slowly.
FOUND = 0.35


def found(recording, name, **changes):
    body = recording.body
    track = changes.get("track", recording.recorded[name])
    thing = Thing.of(recording.scene.objects[name], track)
    motion = changes.get("motion", recording.motion)
    return recorded_holds(motion, body, [Hand.of(body, side) for side in SIDES], thing)


def test_both_hands_hold_the_suitcase_from_its_lift_to_the_end(carry):
    (hold,) = found(carry, "suitcase")
    assert [hand.side for hand in hold.hands] == ["left", "right"]
    height = carry.recorded["suitcase"].position[:, 2]
    rises = np.flatnonzero(height > height[0] + 0.002)[0]
    assert abs(hold.first - rises) < FOUND * carry.motion.fps
    assert hold.kept
    assert hold.last == len(carry.motion) - 1
    assert all(arrives <= hold.first for arrives in hold.arrives)


def test_one_hand_holds_the_glass(grasp):
    (hold,) = found(grasp, "glass")
    assert [hand.side for hand in hold.hands] == ["right"]


def test_a_thing_that_rests_is_not_held(carry):
    still = carry.recorded["suitcase"]
    still = ObjectTrack(
        position=np.repeat(still.position[:1], len(still), axis=0),
        quaternion=np.repeat(still.quaternion[:1], len(still), axis=0),
    )
    assert found(carry, "suitcase", track=still) == []


def test_a_thing_that_moves_by_itself_is_not_held(carry):
    """It goes the same way, but five metres away from the hands."""
    track = carry.recorded["suitcase"]
    away = ObjectTrack(
        position=track.position + np.array([0.0, 5.0, 0.0]), quaternion=track.quaternion
    )
    assert found(carry, "suitcase", track=away) == []


def test_hands_that_pass_are_not_hands_that_hold(carry):
    """The thing moves while the person stands: hands at a belt that runs by."""
    frames = 90
    motion = carry.motion[:frames]
    times = np.arange(frames)[:, None] / motion.fps
    start = carry.recorded["suitcase"]
    track = ObjectTrack(
        position=start.position[0] + times * [0.0, 0.0, 0.6],
        quaternion=np.repeat(start.quaternion[:1], frames, axis=0),
    )
    still = hp.Motion(
        np.repeat(motion.translation[:1], frames, axis=0),
        np.repeat(motion.rotations[:1], frames, axis=0),
        fps=motion.fps,
    )
    assert found(carry, "suitcase", track=track, motion=still) == []
