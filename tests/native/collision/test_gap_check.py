"""Thin poles within the arcs that points go on: no step swings a limb through one."""

from __future__ import annotations

import coal
import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import simulate
from support.judges.coal_shapes import coal_shape, coal_triangles
from support.judges.posed_skin import Skinner
from support.people import t_pose

#: The swing is one of so many frames; it begins in the second.
FRAMES, FPS = 7, 30.0
#: Poses in a frame that are judged.
BETWEEN = 200
POLE = Box((0.002, 0.002, 1.0))
#: Triangles further from the pole's bounds than this [m] are not asked about.
NEAR = 1e-3
#: A bit for each side of a box, as `Arm.near` has them.
SIDES = 1 << np.arange(6, dtype=np.uint8)
#: Joint -> axis that swings the left arm, or the trunk with it, about the vertical.
SWINGS = {"left_shoulder": 1, "left_elbow": 1, "spine1": 1}


@pytest.fixture(scope="module")
def body():
    return Body.default()


@pytest.fixture(scope="module")
def arm(body):
    return Arm(Skinner(body))


def swing(joints, angle):
    """The T-pose; `joints` turn together by `angle` in one frame, and on, through the T-pose."""
    still = t_pose(np.zeros((FRAMES, 3)))
    rotations = np.array(still.rotations)
    share = np.array([-0.5, -0.5, 0.5, 1.5, 1.5, 1.5, 1.5]) / len(joints)
    for name in joints:
        rotations[:, JOINT_INDEX[name], SWINGS[name]] = angle * share
    return still.with_frames(still.translation, rotations)


def tip_of(body):
    """The left fingertip in the T-pose (3,), and the direction of the arm (3,)."""
    motion = t_pose(np.zeros((2, 3)))
    vertices, joints = body.vertices(motion)[0], body.joints(motion)[0]
    along = joints[JOINT_INDEX["left_wrist"]] - joints[JOINT_INDEX["left_shoulder"]]
    along[2] = 0.0
    along /= np.linalg.norm(along)
    return vertices[(vertices @ along).argmax()], along


def between(first, second, count):
    """Poses on the way of constant joint velocities: translations (n, 3), rotations (n, 55, 3)."""
    share = np.linspace(0.0, 1.0, count + 1)[:, None]
    q, r = rot.exp(first.rotations), rot.exp(second.rotations)
    turn = rot.log(rot.multiply(rot.conjugate(q), r))
    translation = first.translation + share * (second.translation - first.translation)
    return translation, rot.log(rot.multiply(q, rot.exp(share[:, :, None] * turn)))


class Arm:
    """The left arm's triangles, posed without the rest of the skin."""

    def __init__(self, skinner):
        names = ("left_collar", "left_shoulder", "left_elbow", "left_wrist")
        own = [JOINT_INDEX[name] for name in names] + list(range(25, 40))
        faces = skinner.faces[np.isin(skinner.part[skinner.faces], own).all(axis=1)]
        used, self.faces = np.unique(faces, return_inverse=True)
        self.faces = self.faces.reshape(faces.shape)
        self._skinner, self._linear = skinner, skinner.linear(used)

    def near(self, low, high, translation, rotations, axes):
        """Corners (n, 3, 3) of the triangles near a box, per pose of (T, 3) and (T, 55, 3)."""
        points = self._skinner.points_of(self._linear, translation, rotations, axes)
        for here in points.swapaxes(0, 1):
            # One bit for each side of the box that a point is beyond: a triangle whose corners
            # share one cannot meet it (Cohen and Sutherland's codes).
            beyond = np.concatenate([here < low, here > high], axis=1) @ SIDES
            first, second, third = beyond[self.faces].T
            yield here[self.faces[first & second & third == 0]]


def met(arm, motion, place, substeps=1):
    """Number of sub-poses at which the skin of the left arm meets the pole, by coal."""
    pole, here = coal_shape(POLE, solid=False), coal.Transform3s(np.eye(3), place)
    half = 0.5 * np.array(POLE.size) + NEAR
    count = 0
    for t in range(len(motion) - 1):
        first, second = motion[t], motion[t + 1]
        if np.abs(first.rotations - second.rotations).max() < 1e-3:
            continue
        poses = between(first, second, BETWEEN // substeps)
        for corners in arm.near(place - half, place + half, *poses, motion.axes):
            if not len(corners):
                continue
            request, result = coal.CollisionRequest(), coal.CollisionResult()
            skin = coal_triangles(
                corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)
            )
            count += coal.collide(skin, coal.Transform3s(), pole, here, request, result)
    return count


def check(body, arm, joints, rate, substeps, inset):
    motion = swing(joints, rate / FPS)
    tip, along = tip_of(body)
    place = tip - inset * along
    # The motion itself goes through the pole.
    assert met(arm, motion[1:4], place) > 0
    scene = Scene()
    scene.add_static("pole", POLE, position=place)
    settings = Settings(substeps=substeps, record="substeps")
    result = simulate(motion, scene, body=body, settings=settings)
    assert len(result.contacts)
    assert met(arm, result.substeps.motions[0], place, substeps) == 0


@pytest.mark.parametrize("inset", [0.01, 0.018, 0.03, 0.06])
@pytest.mark.parametrize(("rate", "substeps"), [(15.0, 1), (8.0, 1), (15.0, 2), (45.0, 7)])
def test_a_swinging_arm_meets_a_pole_within_its_arc(body, arm, rate, substeps, inset):
    """At 15 rad/s and one substep a frame the fingers once passed it."""
    check(body, arm, ["left_shoulder"], rate, substeps, inset)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_joints_that_swing_together_meet_a_pole_within_their_arc(body, arm, seed):
    rng = np.random.default_rng(seed)
    joints = list(rng.permutation(list(SWINGS))[: int(rng.integers(1, 4))])
    substeps = int(rng.choice([1, 1, 2, 3, 8]))
    rate, inset = rng.uniform(5.0, 20.0 * substeps**0.5), rng.uniform(0.008, 0.06)
    check(body, arm, joints, rate, substeps, inset)
