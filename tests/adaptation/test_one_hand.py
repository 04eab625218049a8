"""One hand of a hold: where its palm and its skin are while it holds."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.adaptation import one_hand
from halfphysics.adaptation.grips import places
from halfphysics.adaptation.hands import SIDES, Hand
from halfphysics.adaptation.recorded_holds import recorded_holds
from halfphysics.adaptation.thing import Thing
from halfphysics.adaptation.timing import Timing
from halfphysics.base import rotations as rot
from halfphysics.settings import Settings

#: Inverse kinematics: palms are where they should be to this [m], hands turned to this [rad].
MET, TURNED = 1e-3, 0.02
FRICTION = 0.8


@pytest.fixture(scope="module")
def right(carry):
    """The right hand of the suitcase: the hold, its place and timing."""
    body = carry.body
    thing = Thing.of(carry.scene.objects["suitcase"], carry.recorded["suitcase"])
    hands = [Hand.of(body, side) for side in SIDES]
    (hold,) = recorded_holds(carry.motion, body, hands, thing)
    place = places(carry.motion, body, hold, FRICTION)[1]
    timing = Timing.of(hold, hold.arrives[1], len(carry.motion), carry.motion.fps)
    return hold, place, timing


def held(carry, right, force=0.0, settings=None):
    hold, place, timing = right
    settings = Settings() if settings is None else settings
    return one_hand.held(carry.motion, carry.body, hold, place, timing, force, 0.0, settings)


def palm(carry, motion, right, frames):
    """Middle of the palm in the thing's frame (n, 3) [m], and the hand's rotation (n, 3, 3)."""
    hold, place, _ = right
    position, quaternion = (x[frames] for x in carry.body.joint_frames(motion))
    turn = rot.to_matrix(quaternion[:, place.hand.wrist])
    at = position[:, place.hand.wrist] + turn @ place.hand.palm - hold.thing.position[frames]
    world = hold.thing.turn[frames]
    return np.einsum("tji,tj->ti", world, at), np.swapaxes(world, 1, 2) @ turn


def test_while_it_holds_the_palm_is_at_its_place_and_does_not_move(carry, right):
    hold, place, timing = right
    motion, away = held(carry, right)
    frames = np.flatnonzero((timing.fixed == 1.0) & (timing.closed == 1.0))
    assert len(frames) > 0.8 * (hold.last - hold.first)
    at, turn = palm(carry, motion, right, frames)
    wanted = place.point + one_hand._CLEARANCE * place.normal
    assert np.linalg.norm(at - wanted, axis=1).max() < MET
    assert np.linalg.norm(rot.matrix_to_rotvec(turn @ place.turn.T), axis=1).max() < TURNED
    assert 0.0 < away < 0.05


def test_only_its_own_arm_and_fingers_change(carry, right):
    _, place, _ = right
    motion, _ = held(carry, right, force=80.0)
    changed = (motion.rotations != carry.motion.rotations).any(axis=(0, 2))
    own = {*place.hand.pressing, *place.hand.fingers}
    assert set(np.flatnonzero(changed)) <= own
    assert np.array_equal(motion.translation, carry.motion.translation)


def test_a_force_moves_its_target_inwards(carry, right):
    """Along the direction in which it presses, by centimetres; Algorithm 1 has no force to set."""
    hold, place, timing = right
    frames = np.flatnonzero(timing.presses == 1.0)
    ways = []
    for force, settings in ((0.0, None), (80.0, None), (80.0, Settings.paper())):
        motion, _ = held(carry, right, force, settings)
        ways.append(palm(carry, motion, right, frames)[0] @ place.presses)
    deeper = (ways[1] - ways[0]).min(), (ways[1] - ways[0]).max()
    assert 0.003 < deeper[0] <= deeper[1] < 0.05
    assert np.array_equal(ways[2], ways[0])
    assert hold.last in frames


def test_it_stays_as_recorded_before_and_after(carry, right):
    _, _, timing = right
    motion, _ = held(carry, right, force=80.0)
    free = timing.share == 0.0
    assert np.array_equal(motion.rotations[free], carry.motion.rotations[free])
