"""When recorded hands hold a recorded thing."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.adaptation.hands import SIDES, Hand
from halfphysics.adaptation.recorded_holds import _velocity, recorded_holds
from halfphysics.adaptation.thing import Thing
from halfphysics.base import rotations as rot
from halfphysics.results.result import ObjectTrack

#: The first move is found to this [s]: a thing that is lifted least jerk starts slowly.
FOUND = 0.35
#: Rounding of slopes [m/s].
EXACT = 1e-9


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


def at_rate(recording, name, fps, noise):
    """The recording at another rate: motion, and track with white noise [m] on its place."""
    motion, track = recording.motion, recording.recorded[name]
    if fps != motion.fps:
        motion = motion.resample(fps)
    time = np.arange(len(motion)) * recording.motion.fps / fps
    low = np.minimum(np.floor(time + 1e-9).astype(int), len(track) - 1)
    high = np.minimum(low + 1, len(track) - 1)
    share = time - low
    position = (1.0 - share)[:, None] * track.position[low] + share[:, None] * track.position[high]
    position += np.random.default_rng(1).normal(0.0, noise, position.shape)
    quaternion = rot.slerp(track.quaternion[low], track.quaternion[high], share)
    return motion, ObjectTrack(position=position, quaternion=quaternion)


@pytest.mark.parametrize("fps", [30.0, 120.0])
@pytest.mark.parametrize("noise", [0.001, 0.003])
@pytest.mark.parametrize("what", ["carry", "grasp"])
def test_noise_of_a_sensor_ends_no_hold(what, noise, fps, request):
    """Differences of neighbours at 120 fps and 1 mm are 0.3 m/s: no hand would hold anything."""
    recording = request.getfixturevalue(what)
    (name,) = (n for n in recording.recorded if n in ("suitcase", "glass"))
    clean = found(recording, name)
    motion, track = at_rate(recording, name, fps, noise)
    holds = found(recording, name, motion=motion, track=track)
    assert [h.parts[0].side for h in holds] == [h.parts[0].side for h in clean]
    assert len(holds[0].parts) == len(clean[0].parts)
    assert holds[0].kept
    assert holds[0].last == len(motion) - 1


def test_a_hand_that_moves_off_has_let_go(carry):
    """The thing stops, and a second later the hands go, along its sides: the gap stays."""
    motion, track = carry.motion, carry.recorded["suitcase"]
    (hold,) = found(carry, "suitcase")
    stop = 90
    rest = np.minimum(np.arange(len(motion)), stop)
    still = ObjectTrack(position=track.position[rest], quaternion=track.quaternion[rest])
    place = motion.translation[rest].copy()
    since = np.maximum(np.arange(len(motion)) - stop - 30, 0) / motion.fps
    place[:, 2] += 0.5 * since
    motion = motion.with_frames(place, motion.rotations[rest])
    (hold,) = found(carry, "suitcase", motion=motion, track=still)
    # The speed is known over 0.3 s: the hold ends within the half of it.
    assert abs(hold.last - (stop + 30)) <= 0.15 * motion.fps
    assert not hold.kept


@pytest.mark.parametrize("frames", [1, 2, 3, 9, 40])
def test_velocities_of_steady_ways_are_exact_to_the_ends(frames):
    way = np.array([[0.3, -0.2, 0.1], [0.0, 0.5, 0.0]])
    time = np.arange(frames)[:, None, None] / 30.0
    expected = way if frames > 1 else 0.0 * way
    assert np.abs(_velocity(1000.0 + time * way, 30.0) - expected).max() < EXACT
