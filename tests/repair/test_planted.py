"""Planted feet: what rests stays, the rest of the path is as it was."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.repair.planted import LEAST, MOST, foot_shift, planted, slides
from halfphysics.repair.soles import Soles
from support.damage import noisy
from support.real_clips import real_clip

FPS = 30.0


def path(drift):
    """A foot that stands from frame 10 to 40 and from 60 to 90, and slides by `drift` [m] each."""
    t = np.arange(100)
    x = np.interp(t, [10, 40, 60, 90], [0.0, drift, 0.7, 0.7 + drift])
    centre = np.zeros((100, 2, 3))
    centre[:, 0, 0], centre[:, 1, 0] = x, x + 0.2
    rests = np.zeros((100, 2), dtype=bool)
    rests[10:40] = rests[60:90] = True
    return centre, rests


def shifted(centre, rests):
    return foot_shift(centre, rests, slides(centre, rests, FPS), FPS)


def test_what_rests_stays():
    centre, rests = path(0.04)
    moved = centre[:, 0] + shifted(centre, rests)
    for first, end in ((10, 40), (60, 90)):
        assert np.ptp(moved[first:end], axis=0).max() < 1e-12
        # The foot is put where it was in the middle of its slide: nothing moves farther than that.
        assert abs(moved[first, 0] - centre[first:end, 0, 0].mean()) < 0.04 / 30


def test_shifts_come_and_go_in_the_air():
    centre, rests = path(0.04)
    shift = shifted(centre, rests)
    assert np.abs(shift[0]).max() < 1e-12
    assert np.abs(np.diff(shift[:, 0], axis=0)).max() < 0.01


def test_load_goes_from_heel_to_toe():
    centre, rests = path(0.0)
    centre[10:40, 0, 0] = np.linspace(0.0, 0.02, 30)  # the heel lifts off and goes ahead
    centre[10:40, 1, 0] = np.linspace(0.2, 0.22, 30)
    rests[25:40, 0] = False
    shift = shifted(centre, rests)
    moved = centre + shift[:, None]
    assert np.ptp(moved[10:25, 0, 0]) < 1e-12
    assert np.ptp(moved[10:40, 1, 0]) < 1e-12


def test_little_is_no_slide_and_much_is_no_rest():
    for drift in (LEAST, 2.5 * MOST):
        centre, rests = path(drift)
        assert not shifted(centre, rests).any()


def test_a_noisy_walk_stands_still():
    body, scene = hp.Body.default(), hp.Scene()
    scene.add_static("floor", hp.Plane())
    walk = noisy(real_clip("asap_walk1.npz").grounded(body), body)
    soles = Soles.of(walk, body, scene)
    made, held, size = planted(walk, body, soles)
    assert 0.002 < size < 0.05
    assert (held <= soles.rests.reshape(-1, 2, 2).any(axis=2)).all()
    assert held.mean() > 0.5

    def slides(motion):
        found = Soles.of(motion, body, scene)
        both = soles.rests[1:] & soles.rests[:-1]
        return np.linalg.norm(np.diff(found.centre[..., :2], axis=0), axis=-1)[both].mean()

    assert slides(made) < 0.4 * slides(walk)
    # The ball of the foot stays as well: it turns with the foot, which does not.
    ball = [hp.JOINT_NAMES.index(f"{side}_foot") for side in ("left", "right")]
    flat = soles.rests.reshape(-1, 2, 2).all(axis=2)
    flat = flat[1:] & flat[:-1]
    way = [
        np.linalg.norm(np.diff(body.joints(m)[:, ball, :2], axis=0), axis=-1)[flat].mean()
        for m in (walk, made)
    ]
    assert way[1] < 0.08 * way[0]
    # Only the legs follow, and the pelvis where they are too short.
    legs = [
        hp.JOINT_NAMES.index(f"{s}_{j}")
        for s in ("left", "right")
        for j in ("hip", "knee", "ankle")
    ]
    others = [j for j in range(55) if j not in legs]
    assert np.array_equal(made.rotations[:, others], walk.rotations[:, others])
    assert np.array_equal(made.translation[:, :2], walk.translation[:, :2])
    down = walk.translation[:, 2] - made.translation[:, 2]
    assert down.min() >= 0.0
    assert down.max() < 0.03


def test_a_foot_that_rolls_at_the_ends_of_its_rest_does_not_slide():
    centre, rests = path(0.0)
    centre[10:15, :, 0] += np.linspace(-0.03, 0.0, 5)[:, None]
    centre[35:40, :, 0] += np.linspace(0.0, 0.03, 5)[:, None]
    assert not slides(centre, rests, FPS).any()
    centre[10:40, :, 0] += np.linspace(0.0, 0.05, 30)[:, None]
    assert np.array_equal(np.flatnonzero(slides(centre, rests, FPS)), np.arange(10, 40))
