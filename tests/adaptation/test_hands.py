"""The inner side of hands, on the free body."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.adaptation.hands import SIDES, Hand
from halfphysics.motion.skeleton import JOINT_INDEX, PARENTS

#: The free body is the mirror image of itself to this [m].
MIRRORED = 2e-3


@pytest.fixture(scope="module")
def hands():
    return [Hand.of(hp.Body.default(), side) for side in SIDES]


def test_the_palm_is_below_the_wrist_on_its_way_to_the_knuckles(hands):
    body = hp.Body.default()
    for hand in hands:
        way = body.rest_joints[JOINT_INDEX[f"{hand.side}_middle1"]] - body.rest_joints[hand.wrist]
        assert 0.2 < hand.palm @ hand.ahead / np.linalg.norm(way) < 1.0
        assert -0.03 < hand.palm[1] < -0.005
        assert np.linalg.norm(hand.ahead) == pytest.approx(1.0, abs=1e-12)


def test_left_and_right_mirror_each_other(hands):
    left, right = hands
    assert np.abs(left.palm - right.palm * [-1.0, 1.0, 1.0]).max() < MIRRORED
    assert left.ahead[0] > 0.95
    assert right.ahead[0] < -0.95


def test_the_inner_side_is_skin_of_that_hand_that_faces_down(hands):
    body = hp.Body.default()
    for hand in hands:
        part = body.weights[hand.inner].argmax(axis=1)
        assert set(part) <= {hand.wrist, *hand.fingers}
        own = np.flatnonzero(np.isin(body.weights.argmax(axis=1), [hand.wrist, *hand.fingers]))
        middle = body.rest_vertices[own, 1].mean()
        assert (body.rest_vertices[hand.inner, 1] < middle + 0.01).mean() > 0.9


def test_the_joints_that_give_way_are_a_chain(hands):
    for hand in hands:
        assert [int(PARENTS[j]) for j in hand.pressing[1:]] == list(hand.pressing[:-1])
        assert hand.pressing[-1] == hand.wrist
