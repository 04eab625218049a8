"""One hand of a hold: where its palm and its skin are while it holds."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from halfphysics.adaptation import one_hand
from halfphysics.adaptation.grips import places
from halfphysics.adaptation.hands import SIDES, Hand
from halfphysics.adaptation.recorded_holds import recorded_holds
from halfphysics.adaptation.thing import Thing
from halfphysics.adaptation.timing import Timing
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.settings import Settings
from support.carries.recordings import Case, recording

#: Inverse kinematics: palms are where they should be to this [m], hands turned to this [rad].
MET, TURNED = 1e-3, 0.02
FRICTION = 0.8
#: How much farther from a thing a hand goes while it comes, and nearer while it leaves [m].
BACK = 0.003


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


def test_a_share_over_1_by_rounding_is_1(carry, right):
    hold, place, timing = right
    over = dataclasses.replace(
        timing, share=np.where(timing.share == 1.0, 1.0 + 3e-16, timing.share)
    )
    assert over.share.max() > 1.0
    found, exact = (held(carry, (hold, place, t))[0] for t in (over, timing))
    assert np.abs(found.rotations - exact.rotations).max() < 1e-9


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


def test_a_hand_does_not_back_off_before_it_touches_nor_clap_after():
    """Palms and fingers come nearer to a ball until they touch, and go away from it."""
    made = recording(Case("ball"))
    sequence = made.sequence()
    body, thing = sequence.body, Thing.of(sequence.scene.objects["ball"], made.track)
    both = [Hand.of(body, side) for side in SIDES]
    (hold,) = recorded_holds(sequence.motion, body, both, thing)
    radius = np.linalg.norm(thing.item.true_shape.triangles()[0], axis=1).max()
    for number, place in enumerate(places(sequence.motion, body, hold, FRICTION)):
        times = len(sequence.motion), sequence.motion.fps
        timing = Timing.of(hold, hold.arrives[number], *times)
        motion, _ = one_hand.held(sequence.motion, body, hold, place, timing, 0.0, 0.0, Settings())
        part = np.argmax(np.asarray(body.weights), axis=1)
        thumbs = [JOINT_INDEX[f"{place.hand.side}_thumb{k}"] for k in (1, 2, 3)]
        own = {place.hand.wrist, *place.hand.fingers} - set(thumbs)
        skin = np.flatnonzero(np.isin(part, list(own)))
        touches = np.flatnonzero(timing.closed == 1.0)
        first, last, fps = int(touches[0]), int(touches[-1]), sequence.motion.fps
        for frames in (
            np.arange(first - round(0.8 * fps), first + 1),
            np.arange(last, min(last + round(0.8 * fps), times[0]))[::-1],
        ):
            away = body.vertices(motion, frames=frames, indices=skin) - thing.position[frames, None]
            gap = np.linalg.norm(away, axis=2).min(axis=1) - radius
            assert gap[0] > 0.03
            assert gap[-1] < 0.005
            assert (gap - np.minimum.accumulate(gap)).max() < BACK
