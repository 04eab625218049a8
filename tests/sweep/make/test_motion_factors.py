"""Motions in many variants: time, place and direction."""

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.sweep.make.motion_factors import placed, recorded_in_step, retimed, said_of_motion


@pytest.fixture(scope="module")
def walk():
    return hp.scenarios.load("walk_into_wall").motion[:61]


def said(**factors):
    return said_of_motion({f"motion.{key}": value for key, value in factors.items()})


def test_nothing_said_is_the_motion_itself(walk):
    body = hp.Body.default()
    assert retimed([walk], {})[0] is walk
    assert placed([walk], [body], said(yaw=0.0, offset_x=0.0))[0] is walk


def test_speed_changes_the_frames_not_their_rate(walk):
    (quick,) = retimed([walk], said(speed=2.0))
    assert (quick.fps, len(quick)) == (30.0, 31)
    assert np.array_equal(quick.translation, walk.translation[::2])
    assert np.array_equal(quick.rotations, walk.rotations[::2])
    (slow,) = retimed([walk], said(speed=0.5))
    assert (slow.fps, len(slow)) == (30.0, 121)
    assert np.array_equal(slow.translation[::2], walk.translation)


def test_fps_is_resample(walk):
    (made,) = retimed([walk], said(fps=50.0))
    other = walk.resample(50.0)
    assert made.fps == 50.0
    assert np.array_equal(made.rotations, other.rotations)


def test_speed_and_fps_sample_once(walk):
    (made,) = retimed([walk], said(speed=2.0, fps=60.0))
    assert (made.fps, len(made)) == (60.0, 61)
    assert np.array_equal(made.rotations, walk.rotations)


def test_yaw_turns_about_the_first_pelvis(walk):
    body = hp.Body.default(stature=1.6)
    (made,) = placed([walk], [body], said(yaw=90.0))
    was, now = body.joints(walk), body.joints(made)
    centre = was[0, 0]
    expected = np.stack(
        [
            centre[0] - (was[..., 1] - centre[1]),
            centre[1] + was[..., 0] - centre[0],
            was[..., 2],
        ],
        axis=-1,
    )
    assert now == pytest.approx(expected, abs=1e-9)
    assert np.array_equal(made.rotations[:, 1:], walk.rotations[:, 1:])


def test_yaw_of_a_motion_whose_file_was_y_up(walk):
    body = hp.Body.default()
    (made,) = placed([walk.rebased(body, "y")], [body], said(yaw=37.0))
    (other,) = placed([walk], [body], said(yaw=37.0))
    assert body.joints(made) == pytest.approx(body.joints(other), abs=1e-9)


def test_offsets_move(walk):
    body = hp.Body.default()
    (made,) = placed([walk], [body], said(offset_x=0.1, offset_y=-0.2, offset_z=0.3))
    assert np.array_equal(made.translation, walk.translation + np.array([0.1, -0.2, 0.3]))
    assert np.array_equal(made.rotations, walk.rotations)


def test_replayed_things_keep_step():
    scene = hp.Scene()
    scene.add_moving("cart", hp.Sphere(0.1), [(0, 0, 1), (1, 0, 1)], fps=10.0)
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0)
    made = recorded_in_step(scene, 2.0)
    assert made.objects["cart"].fps == 20.0
    assert made.objects["cart"].velocity.tolist() == [20.0, 0.0, 0.0]
    assert made.objects["cart"].at(0.05)[0] == pytest.approx([1.0, 0.0, 1.0])
    assert made.objects["ball"] is scene.objects["ball"]
    assert scene.objects["cart"].fps == 10.0


@pytest.mark.parametrize("value", [0.0, -1.0, "fast", True])
def test_impossible_speeds(value):
    with pytest.raises(InputError, match=r"motion.speed: found"):
        said(speed=value)


def test_a_speed_that_nobody_has(walk):
    with pytest.raises(InputError, match="the root moves at"):
        retimed([walk], said(speed=1000.0))
