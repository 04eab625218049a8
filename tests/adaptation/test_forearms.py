"""Forearms kept clear of what hands press on: a box in the way of a bent arm."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.adaptation import forearms
from halfphysics.adaptation.hands import SIDES, Hand
from halfphysics.adaptation.thing import Thing
from halfphysics.base import rotations as rot
from halfphysics.results.result import ObjectTrack
from support.bent_arms import bent, where

#: How deep the forearm is inside [m], half the box's size, and how near the forearm's middle [m]
#: skin tells its thickness.
DEEP, HALF, NEAR = 0.006, 0.1, 0.05
#: The hand stays as it is to this [m], [rad].
STAYS = 1e-6


def in_the_way(side, body, motion, frames):
    """A box whose face is inside the forearm, its other axes along the arm and outwards."""
    hand = Hand.of(body, side)
    shoulder, elbow, wrist = (body.joints(motion)[0, j] for j in hand.arm)
    line = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
    out = (elbow - shoulder) - (elbow - shoulder) @ line * line
    out /= np.linalg.norm(out)
    aside, middle = np.cross(line, out), 0.5 * (elbow + wrist)
    away = skin_of(side, body, motion)[0] - middle
    thick = (away @ aside)[np.abs(away @ line) < NEAR].max()
    turn = np.stack([aside, line, out], axis=1)
    scene = hp.Scene()
    scene.add_object("box", hp.Box((2.0 * HALF,) * 3), mass=3.0)
    at = middle + (thick - DEEP + HALF) * aside
    track = ObjectTrack(
        position=np.tile(at, (frames, 1)),
        quaternion=np.tile(rot.exp(rot.matrix_to_rotvec(turn[None])), (frames, 1)),
    )
    return hand, Thing.of(scene.objects["box"], track), at, turn


def skin_of(side, body, motion):
    part = np.argmax(np.asarray(body.weights), axis=1)
    return body.vertices(motion)[:, part == hp.JOINT_NAMES.index(f"{side}_elbow")]


def depth(points, at, turn):
    """How deep the deepest of points (n, 3) is in the box [m], by its half sizes."""
    return float((HALF - np.abs((points - at) @ turn).max(axis=1)).max())


@pytest.mark.parametrize("side", SIDES)
def test_a_forearm_inside_goes_out_and_the_hand_stays(side):
    body, one = hp.Body.default(), bent(2)
    motion = hp.Motion(np.zeros((8, 3)), np.repeat(one.rotations[:1], 8, axis=0), fps=30.0)
    hand, thing, at, turn = in_the_way(side, body, motion, 8)
    share = np.array([0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0, 1.0])
    hold = SimpleNamespace(thing=thing, first=3, last=7)
    before, facing = where(motion, hand, body)
    assert depth(skin_of(side, body, motion)[3], at, turn) > 0.5 * DEEP
    got = forearms.cleared(motion, body, hand, hold, share)
    assert depth(skin_of(side, body, got)[3], at, turn) < -0.5 * forearms._CLEAR
    after, faces = where(got, hand, body)
    assert np.abs(after - before).max() < STAYS
    assert np.abs(faces - facing).max() < STAYS
    changed = (got.rotations != motion.rotations).any(axis=2)
    assert not changed[share == 0.0].any()
    assert set(np.flatnonzero(changed.any(axis=0))) <= {hand.arm[0], hand.arm[2]}


def test_a_forearm_that_is_clear_is_left_as_it_is():
    body, motion = hp.Body.default(), bent(8)
    _, thing, *_ = in_the_way("left", body, motion, 8)
    other = Hand.of(body, "right")
    hold = SimpleNamespace(thing=thing, first=0, last=7)
    assert forearms.cleared(motion, body, other, hold, np.ones(8)) is motion
