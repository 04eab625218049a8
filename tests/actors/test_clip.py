"""Clips: placed, looped, mirrored, at any speed."""

from __future__ import annotations

import math

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.actors import Clip, Seen
from halfphysics.actors.turns import heading_of
from halfphysics.base import rotations as rot
from support.acted import accelerations, body, frames

DT = 1.0 / 30.0


@pytest.fixture(scope="module")
def walk():
    """Two steps in the middle of a walk, which a loop can repeat."""
    return hp.scenarios.load("walk_into_wall").motion[20:80]


def test_played_as_recorded_it_is_the_motion(walk):
    motion = frames(Clip(walk, body()), len(walk))
    np.testing.assert_allclose(motion.translation, walk.translation, atol=1e-9)
    assert float(rot.angles(motion.rotations, walk.rotations).max()) < 1e-7


def test_it_rests_at_its_end(walk):
    clip = Clip(walk, body(), speed=2.0)
    clip.reset()
    poses = [clip.next(DT, Seen()) for _ in range(60)]
    assert clip.done
    assert clip.duration == pytest.approx(59 / 60)
    np.testing.assert_allclose(poses[-1].translation, walk.translation[-1], atol=1e-12)


def test_it_begins_where_and_as_it_is_told(walk):
    first = Clip(walk, body(), place=(2.0, -1.0), heading=2.5).reset()
    pelvis = body().joints(first)[0]
    np.testing.assert_allclose(pelvis[:2], (2.0, -1.0), atol=1e-12)
    assert heading_of(rot.exp(first.rotations[0])) == pytest.approx(2.5)


def test_a_mirror_image_is_one(walk):
    """Left wrists are where right ones were, mirrored at the plane of the first pose."""
    own = frames(Clip(walk, body(), place=(0, 0), heading=0.0), 50)
    other = frames(Clip(walk, body(), mirror=True, place=(0, 0), heading=0.0), 50)
    for name in ("wrist", "ankle", "shoulder", "index1"):
        left = body().joints(own)[:, hp.JOINT_NAMES.index(f"left_{name}")]
        right = body().joints(other)[:, hp.JOINT_NAMES.index(f"right_{name}")]
        # The default body is not quite symmetrical.
        np.testing.assert_allclose(right, left * [1.0, -1.0, 1.0], atol=0.01)


def test_a_loop_goes_on_without_a_jump(walk):
    clip = Clip(walk, body(), loop=True, place=(0, 0), heading=1.0)
    motion = frames(clip, 200)
    once = frames(Clip(walk, body(), place=(0, 0), heading=1.0), len(walk))
    joints = hp.JOINT_NAMES[:22]
    assert accelerations(motion, joints) < 1.5 * accelerations(once, joints)
    way = once.translation[-1, :2] - once.translation[0, :2]
    np.testing.assert_allclose(
        motion.translation[186, :2] - motion.translation[9, :2], 3.0 * way, atol=1e-3
    )


def test_a_loop_that_turns_goes_in_a_circle(walk):
    turned = np.array(walk.rotations)
    ends = [heading_of(rot.exp(turned[k, 0])) for k in (0, -1)]
    angles = np.linspace(0.0, 0.5 * math.pi + ends[0] - ends[1], len(walk))
    root = rot.multiply(
        rot.exp(np.stack([0 * angles, 0 * angles, angles], 1)), rot.exp(turned[:, 0])
    )
    turned[:, 0] = rot.log(root)
    curve = walk.with_frames(np.array(walk.translation), turned)
    clip = Clip(curve, body(), loop=True, fade=0.0)
    clip.reset()
    around = [clip._at(k * (len(walk) - 1) / 30.0) for k in range(5)]
    np.testing.assert_allclose(around[4].translation, around[0].translation, atol=1e-9)
    assert np.linalg.norm(around[2].translation - around[0].translation) > 1.0


def test_equal_bits_every_time(walk):
    clip = Clip(walk, body(), loop=True, speed=1.3)
    first, again = (frames(clip, 150) for _ in range(2))
    assert first.rotations.tobytes() == again.rotations.tobytes()


def test_impossible_clips_are_refused(walk):
    with pytest.raises(hp.errors.InputError, match="Clip: speed: expected a number above 0"):
        Clip(walk, body(), speed=0.0)
    with pytest.raises(hp.errors.InputError, match="Clip: place: expected 2 finite numbers"):
        Clip(walk, body(), place=(0, 0, 0))
    with pytest.raises(hp.errors.InputError, match=r"motion: found 'walk\.npz', expected"):
        Clip("walk.npz", body())
    with pytest.raises(hp.errors.InputError, match=r"body: found 1\.8, expected"):
        Clip(walk, 1.8)


def test_a_reset_forgets_where_it_was_put(walk):
    """Episodes are alike whatever was played in those before."""
    clip = Clip(walk, body())
    first = clip.reset()
    elsewhere = hp.Pose(np.add(first.translation, (5.0, 0.0, 0.0)), first.rotations, first.axes)
    assert clip.restart(elsewhere).translation[0] == pytest.approx(first.translation[0] + 5.0)
    again = clip.reset()
    np.testing.assert_array_equal(again.translation, first.translation)
    np.testing.assert_array_equal(again.rotations, first.rotations)


def test_a_seam_fades_in_the_time_that_was_told_at_any_speed(walk):
    """By the clock; at twice the speed it was gone in half of that."""
    for speed in (1.0, 2.0):
        clip = Clip(walk, body(), loop=True, speed=speed, fade=0.4)
        assert clip._seam.seconds == pytest.approx(0.4 * speed)
    assert Clip(walk, body(), loop=True, speed=5.0, fade=0.4)._seam.seconds == pytest.approx(
        0.5 * walk.duration
    )
