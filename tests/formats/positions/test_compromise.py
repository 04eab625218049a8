"""A skeleton like SMPL's on the default body: near the least error that a pose can have, soles
where the skeleton's own body has them, nothing turned far, nothing jumps.

The least error is found by scipy's L-BFGS-B over all rotations of one frame, without priors.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.formats.positions.bones import bones_of
from halfphysics.formats.positions.compromise import pulls
from halfphysics.formats.positions.inverse_kinematics import solve
from halfphysics.motion.skeleton import JOINT_INDEX, PARENTS
from support.files.layouts import movement
from support.files.position_files import STRANGER, offsets, places
from support.real_clips import NAMES, real_clip

BODY = range(22)
MET = 0.0275  # metres, mean of a clip; by least squares 0.028
ABOVE_LEAST = 1.5e-3  # metres, mean of a frame
SUNK = 0.013  # metres, soles that rest; by least squares up to 0.039
LIFTED = 0.003  # metres
SLOW = 0.3  # m/s: a foot that rests
EXTRA, JUMP = np.radians(60.0), np.radians(30.0)  # beyond the truth
ENDS = [JOINT_INDEX[j] for j in ("left_foot", "right_foot", "head", "left_wrist", "right_wrist")]
INNER = [j for j in BODY if j not in ENDS]
DEFAULT = hp.Body.default()
REST = np.asarray(DEFAULT.rest_joints)


@cache
def own_body():
    """The body that `load_sequence` gives: the skeleton's bones, with soles as ours."""
    positions = np.full((60, 55, 3), np.nan)
    positions[:, :22] = seen(hp.Motion(*movement(60), 60.0))
    return hp.Body.default(bones=bones_of(positions, REST))


def seen(motion):
    return places(motion.rotations, motion.translation + motion.axes @ REST[0], STRANGER)


def on_the_default_body(positions):
    return solve(positions, BODY, REST, pulls(positions, BODY, REST))


def soles(body, solved, side):
    """Lowest points (T,) of one foot's skin [m], z up."""
    joints = [JOINT_INDEX[f"{side}_{joint}"] for joint in ("ankle", "foot")]
    part = np.isin(np.asarray(body.weights).argmax(axis=1), joints)
    pelvis = np.asarray(body.rest_joints)[0]
    motion = hp.Motion(solved.pelvis - pelvis, solved.rotations, 30.0)
    return np.asarray(body.vertices(motion))[:, part, 2].min(axis=1)


def angles(a, b):
    """Angles (T, J) between rotations (T, J, 3)."""
    one, other = (Rotation.from_rotvec(np.array(x).reshape(-1, 3)) for x in (a, b))
    return (one.inv() * other).magnitude().reshape(a.shape[:2])


def check(motion):
    positions = seen(motion)
    solved = on_the_default_body(positions)
    again = places(solved.rotations, solved.pelvis, offsets(REST, 22))
    assert np.linalg.norm(again - positions, axis=2).mean() < MET
    theirs = np.asarray(own_body().rest_joints)
    own = solve(positions, BODY, theirs)
    for side in ("left", "right"):
        toes = positions[:, JOINT_INDEX[f"{side}_foot"]]
        rests = np.linalg.norm(np.diff(toes, axis=0), axis=1) * motion.fps < SLOW
        off = (soles(DEFAULT, solved, side) - soles(own_body(), own, side))[:-1][rests]
        assert (off > -SUNK).all()
        assert (off < LIFTED).all()
    found, truth = solved.rotations[:, BODY], motion.rotations[:, BODY]
    zero = np.zeros_like(truth)
    assert (angles(found, zero) - angles(truth, zero))[:, 1:].max() < EXTRA
    steps = angles(found[1:], found[:-1]) - angles(truth[1:], truth[:-1])
    assert steps[:, INNER].max() < JUMP


@pytest.mark.filterwarnings("ignore::halfphysics.HalfPhysicsWarning")
@pytest.mark.parametrize("name", NAMES)
def test_recorded_clips(name):
    check(real_clip(name))


@pytest.mark.parametrize("name", ["crawl_under_table", "kick_ball"])
def test_authored_clips(name):
    check(scenarios.load(name).motions[0])


def least_error(seen, solved):
    """The least mean distance [m] that joints of the default body can have from 22 places.

    Every bone hangs on a rotation of its own, so distances are a function of these alone; a local
    least, searched from the pose that was found.
    """
    bones = offsets(REST, 22)
    inner = sorted({int(p) for p in PARENTS[1:22]})
    start, world = np.zeros(3 * len(inner) + 3), {}
    for j in BODY:
        own = Rotation.from_rotvec(np.array(solved.rotations[0, j]))
        world[j] = world[int(PARENTS[j])] * own if j else own
    start[:3] = solved.pelvis[0]
    start[3:] = np.concatenate([world[j].as_rotvec() for j in inner])

    def at(unknown):
        turned = dict(
            zip(inner, Rotation.from_rotvec(unknown[3:].reshape(-1, 3)).as_matrix(), strict=True)
        )
        out = np.empty((22, 3))
        out[0] = unknown[:3]
        for j in BODY[1:]:
            out[j] = out[PARENTS[j]] + turned[int(PARENTS[j])] @ bones[j]
        return out

    for smooth in (0.03, 0.003):  # rounds the tip of a distance's cone

        def total(unknown, smooth=smooth):
            return float(np.sqrt(((at(unknown) - seen) ** 2).sum(axis=1) + smooth**2).sum())

        start = minimize(total, start, method="L-BFGS-B", options={"maxfun": 10**5}).x
    return float(np.linalg.norm(at(start) - seen, axis=1).mean())


def test_no_pose_has_much_less():
    """And none under 25 mm: hips, spine and collars are elsewhere in the same flesh."""
    positions = seen(hp.Motion(*movement(2), 60.0))[:1]
    solved = on_the_default_body(positions)
    least = least_error(positions[0], solved)
    assert least > 0.025
    assert solved.errors.mean() < least + ABOVE_LEAST


def test_a_body_with_the_skeletons_bones_is_not_changed():
    """Where all joints are met, only the feet pull more."""
    translation, rotations = movement(60)
    positions = places(rotations, translation, offsets(REST, 22))
    found = pulls(positions, BODY, REST)
    feet = {7: 4.0, 8: 4.0, 10: 10.0, 11: 10.0}
    expected = np.array([feet.get(j, 1.0) for j in BODY])
    assert np.abs(found[:22] / expected - 1.0).max() < 0.3  # priors hold knees 3 mm off
    assert (found[22:] == 1.0).all()


def test_joints_that_cannot_be_met_pull_least():
    found = pulls(seen(hp.Motion(*movement(60), 60.0)), BODY, REST)
    assert set(np.argsort(found[:22])[:5]) == {1, 2, 3, 13, 14}  # hips, spine1, collars
