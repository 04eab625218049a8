"""One hand of a hold: on its way to its place, its fingers around the thing, pressing.

Only its arm, collar and fingers change: the wrist is moved to where the palm lies on the thing, by
as much as the timing says, fingers close, and the arm's targets go beyond by what the force needs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.adaptation import arm_pose, forearms, press
from halfphysics.adaptation.fingers import closed
from halfphysics.adaptation.grips import Place, fingers_at, fingers_known
from halfphysics.base import rotations as rot
from halfphysics.body.joint_ranges import JointRanges, from_swing_twist
from halfphysics.motion.skeleton import JOINT_NAMES

if TYPE_CHECKING:
    from halfphysics.adaptation.recorded_holds import RecordedHold
    from halfphysics.adaptation.timing import Timing
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.settings import Settings

Array = NDArray[np.float64]

#: A palm comes to the surface from so far and leaves to there, and one whose fingers grasp [m].
_OPEN, _GRASP_OPEN = 0.03, 0.01
#: The way from coming as recorded to keeping open is rounded over this part of the opening.
_ROUNDED = 0.3
#: A thumb that was not recorded opens sooner than the hand comes, and closes later than it leaves:
#: in its way it pushes the thing. It lacks what the hand lacks of its way, to this power.
_THUMB_FIRST = 2.7
#: Palms touch at this distance from the surface [m]: contact keeps so much clear.
_CLEARANCE = 0.001


def held(
    motion: Motion,
    body: Body,
    hold: RecordedHold,
    place: Place,
    timing: Timing,
    force: float,
    squeeze: float,
    settings: Settings,
) -> tuple[Motion, float]:
    """The motion with one hand at its place on the thing; how far its palm was moved [m].

    Args:
        motion: The motion, T frames.
        body: The person's body.
        hold: What is held, and when.
        place: Where the hand is on it.
        timing: How far it is there, and presses.
        force: What it presses with [N].
        squeeze: How far its fingers flex beyond where they touch [rad].
        settings: The drive that presses; Algorithm 1 does not.
    """
    hand = place.hand
    frames = np.flatnonzero(timing.share > 0.0)
    turn, wrist, away = _reached(motion, body, hold, place, timing, frames)
    rotations = np.array(motion.rotations)
    rows = np.ix_(frames, np.array(hand.arm))
    rotations[rows] = arm_pose.moved(motion, body, hand, frames, wrist, turn)
    motion = motion.with_frames(motion.translation, rotations)
    if place.presses.any():
        motion = forearms.cleared(motion, body, hand, hold, timing.share)
    motion = _closed(motion, body, hold, place, timing, squeeze)
    pressing = np.flatnonzero(timing.presses > 0.0)
    if force == 0.0 or settings.drive_time is None or not len(pressing):
        return motion, away
    push = timing.presses[pressing, None] * force * (hold.thing.turn[pressing] @ place.presses)
    rotations = np.array(motion.rotations)
    rotations[np.ix_(pressing, np.array(hand.pressing))] = press.pressed(
        motion, body, hand, pressing, push,
        stiffness=press.ARM * press.stiffness_of(settings, hand), time=settings.drive_time,
    )  # fmt: skip
    return motion.with_frames(motion.translation, rotations), away


def _reached(
    motion: Motion,
    body: Body,
    hold: RecordedHold,
    place: Place,
    timing: Timing,
    frames: NDArray[np.int64],
) -> tuple[Array, Array, float]:
    """Where a hand is to be, in the world: as recorded but for a constant shift, and at its place.

    Args:
        motion, body, hold, place: What is held, how.
        timing: How far it is there, frame by frame.
        frames: Frames (n,).

    Returns:
        Rotations of the hand (n, 3, 3), positions of the wrist (n, 3) [m], and how far the palm was
        moved [m], the median over the hold.
    """
    hand, world = place.hand, hold.thing.turn[frames]
    position, quaternion = (x[frames] for x in body.joint_frames(motion))
    turn = rot.to_matrix(quaternion[:, hand.wrist])
    palm = position[:, hand.wrist] + turn @ hand.palm
    at = hold.thing.position[frames]
    seen = np.einsum("tji,tj->ti", world, palm - at)
    seen_turn = np.swapaxes(world, 1, 2) @ turn
    held = timing.fixed[frames, None]
    shift = place.point - place.seen
    inside = 0.0 if place.grasps else max(0.0, float(shift @ place.normal))
    to = seen + shift - inside * place.normal
    to = to + held * (place.point - to)
    apart = _apart(place, (to - place.point) @ place.normal, timing.closed[frames], inside)
    to = to + (_CLEARANCE + apart)[:, None] * place.normal
    shifted = place.turn @ place.seen_turn.T @ seen_turn
    rest = rot.matrix_to_rotvec(place.turn @ np.swapaxes(shifted, 1, 2))
    to_turn = world @ rot.rotvec_to_matrix(held * rest) @ shifted
    to = at + np.einsum("tij,tj->ti", world, to)
    part = timing.share[frames, None]
    way = rot.matrix_to_rotvec(to_turn @ np.swapaxes(turn, 1, 2))
    turn = rot.rotvec_to_matrix(part * way) @ turn
    during = (frames >= hold.first) & (frames <= hold.last)
    away = float(np.median(np.linalg.norm(to - palm, axis=1)[during]))
    palm = palm + part * (to - palm)
    return turn, palm - turn @ hand.palm, away


def _apart(place: Place, gap: Array, closed: Array, inside: float) -> Array:
    """How far a hand is to go outwards (n,) [m], so that its palm is open by what it is to be.

    A palm that is farther from the surface than that comes as it was recorded: going out first, to
    come back, it would clap.

    Args:
        place: Where it is to be.
        gap: Of its palm from the surface, as recorded (n,) [m].
        closed: How far it is closed (n,).
        inside: How deep it was recorded inside what it holds [m]; it goes out by no more than that
            and its opening, wherever else it goes.
    """
    opening = (_GRASP_OPEN if place.grasps else _OPEN) * (1.0 - closed)
    if place.grasps:
        return opening
    lacks = opening - gap
    # The larger of that and 0, without a corner.
    out: Array = 0.5 * (lacks + np.sqrt(lacks**2 + (_ROUNDED * opening) ** 2))
    return np.minimum(out, opening + inside)


def _closed(
    motion: Motion,
    body: Body,
    hold: RecordedHold,
    place: Place,
    timing: Timing,
    squeeze: float,
) -> Motion:
    """The motion with the fingers of a hand around what it holds, flexed beyond by a squeeze."""
    known = fingers_known(motion, place.hand)
    start = fingers_at(motion, place, hold.middle)
    around = closed(body, hold.thing, place, start, known)
    ranges = JointRanges.of(body)
    frames = np.flatnonzero(timing.share > 0.0)
    axes = ranges.axes[around.joints]
    recorded = ranges.angles(motion.rotations[frames])[:, around.joints]
    share, closes, presses = (
        x[frames, None, None] for x in (timing.share, timing.closed, timing.presses)
    )
    target = around.angles + squeeze * presses * around.presses
    if around.opened is None:
        mixed = recorded + share * closes * (target - recorded)
    else:
        target = around.opened + closes * (target - around.opened)
        thumb = np.array(["thumb" in JOINT_NAMES[j] for j in around.joints])
        # A share may be over 1 by rounding.
        lacks = np.maximum(1.0 - share, 0.0) ** np.where(thumb, _THUMB_FIRST, 1)[:, None]
        mixed = recorded + (1.0 - lacks) * (target - recorded)
    rotations = np.array(motion.rotations)
    rotations[np.ix_(frames, around.joints)] = from_swing_twist(mixed, axes)
    return motion.with_frames(motion.translation, rotations)
