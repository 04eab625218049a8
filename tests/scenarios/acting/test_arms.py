"""Arms solved from hand targets."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.motion.motion import Motion
from halfphysics.scenarios.acting.arms import arm_of, solve
from halfphysics.scenarios.acting.legs import WORLD_FROM_REST, about

N = 60


def reaching(body, side, wrist, hand, pole):
    """Joint frames of a standing body with a solved arm."""
    arm = arm_of(body, side)
    rotations = np.zeros((N, 55, 3))
    rotations[:, 0] = rot.matrix_to_rotvec(WORLD_FROM_REST)
    positions, frames = body.joint_frames(Motion(np.zeros((N, 3)), rotations, 30.0))
    shoulder = positions[:, arm.joints[0]]
    collar = rot.to_matrix(frames[:, arm.collar])
    local = solve(arm, collar, shoulder, shoulder + wrist, hand, pole)
    for joint, rotvec in local.items():
        rotations[:, joint] = rotvec
    positions, frames = body.joint_frames(Motion(np.zeros((N, 3)), rotations, 30.0))
    return arm, positions - shoulder[:, None], frames, rotations


@pytest.mark.parametrize("side", ["left", "right"])
def test_wrist_and_hand_are_where_they_should_be(side):
    rng = np.random.default_rng(7)
    arm = arm_of(Body.default(), side)
    way = rng.normal(size=(N, 3))
    way *= rng.uniform(0.3, 0.99, (N, 1)) * arm.length / np.linalg.norm(way, axis=1)[:, None]
    hand = rot.rotvec_to_matrix(rng.normal(size=(N, 3)))
    pole = rng.normal(size=(N, 3))
    _, positions, frames, _ = reaching(Body.default(), side, way, hand, pole)
    np.testing.assert_allclose(positions[:, arm.joints[2]], way, atol=1e-9)
    np.testing.assert_allclose(rot.to_matrix(frames[:, arm.joints[2]]), hand, atol=1e-9)
    # The elbow is on the pole's side of the line to the wrist, in their plane.
    elbow, line = positions[:, arm.joints[1]], way / np.linalg.norm(way, axis=1)[:, None]
    out = elbow - np.sum(elbow * line, axis=1)[:, None] * line
    aim = pole - np.sum(pole * line, axis=1)[:, None] * line
    cosine = np.sum(out * aim, axis=1) / np.linalg.norm(out, axis=1) / np.linalg.norm(aim, axis=1)
    np.testing.assert_allclose(cosine, 1.0, atol=1e-6)


def test_out_of_reach_is_approached_along_its_line():
    arm = arm_of(Body.default(), "right")
    way = np.tile([0.7, -0.2, 0.1], (N, 1))
    hand, pole = about(2, np.zeros(N)), np.tile([0.0, 0.0, -1.0], (N, 1))
    _, positions, _, _ = reaching(Body.default(), "right", way, hand, pole)
    reached = positions[:, arm.joints[2]]
    np.testing.assert_allclose(np.linalg.norm(reached, axis=1), arm.length, atol=1e-9)
    np.testing.assert_allclose(np.cross(reached, way), 0.0, atol=1e-9)


def test_a_hand_that_turns_all_the_way_round_turns_evenly():
    """Past half a turn no joint flips: elbow and wrist go on by the same small steps."""
    turn = np.linspace(0.0, 2.0 * np.pi, N)
    way, pole = np.tile([0.3, -0.2, -0.2], (N, 1)), np.tile([0.0, -0.3, -1.0], (N, 1))
    hand = about(2, np.full(N, np.pi)) @ about(0, turn)
    arm, _, _, rotations = reaching(Body.default(), "right", way, hand, pole)
    for joint in arm.joints[1:]:
        q = rot.exp(rotations[:, joint])
        cosine = np.abs(np.sum(q[1:] * q[:-1], axis=1))
        steps = 2.0 * np.arccos(np.clip(cosine, 0.0, 1.0))
        assert steps.max() < 4.0 * 2.0 * np.pi / N
