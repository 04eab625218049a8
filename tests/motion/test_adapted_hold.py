"""What is to be held stays right when its motion is cut, sampled and moved."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.motion.adapted_hold import AdaptedHold
from halfphysics.motion.motion import Motion

FRAMES, FPS, FIRST, LAST = 21, 30.0, 6, 14


def hold(**changes) -> AdaptedHold:
    """A box that both hands hold in frames 6 to 14; it goes along x and turns about z."""
    angle = np.zeros((FRAMES, 3))
    angle[:, 2] = 0.1 * np.arange(FRAMES)
    said = {
        "object": "box",
        "parts": ("left_wrist", "right_wrist"),
        "first": FIRST,
        "last": LAST,
        "force": 80.0,
        "moved": (0.02, 0.03),
        "position": np.outer(np.arange(FRAMES), [0.01, 0.0, 0.0]),
        "quaternion": rot.exp(angle),
    }
    return AdaptedHold(**said | changes)


def motion() -> Motion:
    rng = np.random.default_rng(0)
    rotations = 0.2 * rng.normal(size=(FRAMES, 55, 3))
    translation = np.cumsum(0.01 * rng.normal(size=(FRAMES, 3)), axis=0)
    recorded = Motion(translation, rotations + 0.1, FPS)
    return Motion(translation, rotations, FPS, holds=(hold(),), recorded=recorded)


@pytest.mark.parametrize(
    ("cut", "first", "last"),
    [
        (slice(None), 6, 14),
        (slice(4, None), 2, 10),
        (slice(8, 12), 0, 3),
        (slice(None, None, 4), 2, 3),  # frames 8 and 12
        (slice(None, None, -1), 6, 14),
        (slice(10, 2, -1), 0, 4),
    ],
)
def test_a_slice_has_the_same_frames_of_the_hold(cut, first, last):
    whole = motion()
    part = whole[cut]
    (kept,) = part.holds
    frames = np.arange(FRAMES)[cut]
    assert (kept.first, kept.last) == (first, last)
    assert (kept.object, kept.parts, kept.force, kept.moved) == (
        "box", ("left_wrist", "right_wrist"), 80.0, (0.02, 0.03),
    )  # fmt: skip
    assert np.array_equal(kept.position, whole.holds[0].position[frames])
    assert np.array_equal(kept.quaternion, whole.holds[0].quaternion[frames])
    assert np.array_equal(part.recorded.rotations, whole.recorded.rotations[frames])
    assert part.recorded.fps == part.fps


def test_what_is_cut_away_is_no_longer_held():
    for cut in (slice(0, 5), slice(16, None)):
        part = motion()[cut]
        assert part.holds == ()
        assert len(part.recorded) == len(part)


def test_resampled_it_is_held_at_the_same_times():
    whole = motion()
    quick = whole.resample(60.0)
    (kept,) = quick.holds
    assert (kept.first / 60.0, kept.last / 60.0) == (FIRST / FPS, LAST / FPS)
    # Linear and steady turning are met exactly between frames too.
    assert np.allclose(kept.position[:, 0], 0.005 * np.arange(41), atol=1e-15)
    assert np.allclose(rot.log(kept.quaternion)[:, 2], 0.05 * np.arange(41), atol=1e-12)
    assert np.array_equal(quick.recorded.rotations, whole.recorded.resample(60.0).rotations)
    back = quick.resample(30.0)
    assert (back.holds[0].first, back.holds[0].last) == (FIRST, LAST)
    assert np.array_equal(back.holds[0].position, whole.holds[0].position)
    assert np.array_equal(back.recorded.rotations, whole.recorded.rotations)


def test_other_frames_keep_it_while_their_number_stays():
    whole = motion()
    other = whole.with_frames(whole.translation + 1.0, whole.rotations)
    assert other.holds == whole.holds
    assert other.recorded is whole.recorded
    for changed in (
        whole.with_frames(whole.translation[1:], whole.rotations[1:]),
        whole.with_frames(whole.translation, whole.rotations, fps=20.0),
    ):
        assert changed.holds == ()
        assert changed.recorded is None


def test_what_was_recorded_moves_along():
    """On the ground and in other axes, motion and record stay as far apart as they were."""
    whole, body = motion(), Body.default()
    apart = body.joints(whole) - body.joints(whole.recorded)
    for moved in (whole.grounded(body), whole.rebased(body, "y")):
        assert moved.holds == whole.holds
        between = body.joints(moved) - body.joints(moved.recorded)
        assert np.allclose(between, apart, atol=1e-12)
    lowest = body.vertices(whole.grounded(body))[..., 2].min()
    assert abs(lowest) < 1e-12


def test_bare_frames_have_neither():
    whole = motion()
    bare = whole.bare()
    assert bare.holds == ()
    assert bare.recorded is None
    assert np.array_equal(bare.rotations, whole.rotations)
    assert bare.bare() is bare


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"object": ""}, "expected the name of an object"),
        ({"parts": ("left_hand", "right_wrist")}, "found part 'left_hand', expected one of JOINT"),
        ({"parts": ([],), "moved": (0.0,)}, "found part"),
        ({"parts": ()}, "found 0 parts and 2 distances"),
        ({"moved": (0.01,)}, "found 2 parts and 1 distances"),
        ({"moved": (0.01, -1.0)}, "moved: expected a number of at least 0"),
        ({"first": -1}, "found frames -1 to 14, expected two of 0 to 20"),
        ({"last": FRAMES}, "found frames 6 to 21"),
        ({"first": 15}, "found frames 15 to 14"),
        ({"first": 1.5}, "found frames 1.5 to 14"),
        ({"force": -1.0}, "force: expected a number of at least 0"),
        ({"force": np.nan}, "force"),
        ({"position": np.zeros((FRAMES, 2))}, r"position: found shape \(21, 2\)"),
        ({"quaternion": np.zeros((5, 4))}, r"quaternion: found shape \(5, 4\)"),
    ],
)
def test_impossible_holds_are_named(change, message):
    with pytest.raises(InputError, match=message):
        hold(**change)


def test_a_motion_refuses_what_has_other_frames():
    whole = motion()
    short = whole.recorded[:-1]
    for change, message in (
        ({"holds": (short,)}, "expected an AdaptedHold of 21 frames"),
        ({"recorded": short}, "recorded: found 20 frames at 30 fps, expected 21 at 30"),
        ({"recorded": whole.recorded.resample(60.0)}, "recorded: found 41 frames at 60 fps"),
        ({"recorded": whole}, "expected a motion as recorded"),
        ({"recorded": "a motion"}, "expected a motion as recorded"),
    ):
        with pytest.raises(InputError, match=message):
            dataclasses.replace(whole, **change)
    with pytest.raises(InputError, match="expected an AdaptedHold of 20 frames"):
        Motion(short.translation, short.rotations, FPS, holds=whole.holds)
