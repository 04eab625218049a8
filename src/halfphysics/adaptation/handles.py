"""A hand that pulls: fingers hooked behind a bar or a rim of a thing that slides.

A drawer is neither lifted nor gripped: its way is level and straight, and something bears it. Where
one hand moves such a thing it is moved to the nearest place from which fingers meet the thing's far
side as it is pulled: of all hooks of the fingers and depths of the hand that are free of the thing
and meet it with fingers, the nearest to the recording. Fingers that were recorded are kept, and
close around what they meet; others are hooked: the hand comes from outside, fingers curled, and
leaves so. When the thing goes back, a hooked hand first goes back by the play between its two
sides, so that it pushes at once.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.adaptation import arm_pose
from halfphysics.adaptation.feet import direction
from halfphysics.adaptation.timing import Timing
from halfphysics.base import rotations as rot
from halfphysics.motion.easing import ease
from halfphysics.motion.skeleton import JOINT_NAMES

if TYPE_CHECKING:
    from halfphysics.adaptation.grips import Place
    from halfphysics.adaptation.hands import Hand
    from halfphysics.adaptation.recorded_holds import RecordedHold
    from halfphysics.adaptation.thing import Thing
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

#: A thing slides that goes this far [m], rises less than this [m] and turns less than this [rad].
_FAR, _LEVEL, _TURNS = 0.05, 0.02, 0.2
#: Flexion of a finger's three joints that is tried [rad]: hooks, from open to shut.
_HOOKS = tuple((a, b, 0.4) for a in (0.1, 0.4, 0.7, 1.0, 1.3) for b in (1.0, 1.4))
#: Depths of the hand, and ways along the pull, that are tried around the recorded place [m].
_DEPTHS, _ALONG = np.arange(-0.05, 0.051, 0.01), np.arange(-0.075, 0.0751, 0.0075)
#: Where the hook meets the thing is found to this [m]; the least free way before it [m].
_FINE = 2e-4
#: Part of the skin that meets the thing that is of fingers, at least, and how many fingers.
_OF_FINGERS, _FINGERS = 0.8, 2
#: A place costs as its distance over this [m], a finger that does not meet the thing this much.
_AWAY, _MISSING = 0.03, 0.5
#: Skin of a hand that stands for it, at most.
_SAMPLES = 260
#: The hand comes from outside by this [m], and wants to be flexed beyond by this [rad].
_OUTSIDE, _SQUEEZE = 0.06, 0.15
#: It goes through all of its play while the thing goes back by this [m]; the play is at most this.
_TURNING, _PLAY = 0.03, 0.05


@dataclass(frozen=True, eq=False)
class Hook:
    """How a hand pulls a thing, in the thing's frame.

    Attributes:
        hand: Which hand.
        shift: From where the hand was recorded (3,) [m].
        way: Along which it pulls (3,).
        out: From where it comes (3,).
        fingers: Rotations of its 15 joints (15, 3).
        play: How far it goes back until it pushes [m].
    """

    hand: Hand
    shift: Array
    way: Array
    out: Array
    fingers: Array
    play: float


def slides(hold: RecordedHold) -> bool:
    """Whether a held thing is borne by something else: it goes level, straight and far enough."""
    during = slice(hold.first, hold.last + 1)
    centre, turn = hold.thing.centre[during], hold.thing.turn[during]
    cosine = 0.5 * (np.einsum("ij,tij->t", turn[0], turn) - 1.0)
    gone = centre - centre[0]
    along = gone @ (hold.thing.turn[hold.first] @ direction(hold))
    aside = np.linalg.norm(gone, axis=1) ** 2 - along**2
    return bool(
        along.max() > _FAR
        and np.ptp(centre[:, 2]) < _LEVEL
        and np.sqrt(np.maximum(aside, 0.0)).max() < _LEVEL
        and np.arccos(np.clip(cosine, -1.0, 1.0)).max() < _TURNS
    )


def hook_of(
    body: Body, hold: RecordedHold, place: Place, recorded: Array | None = None
) -> Hook | None:
    """The hook nearest to how a hand was recorded.

    Args:
        body: The person's body.
        hold: What the hand pulls, and when.
        place: How the hand was recorded: `Place.seen` and `Place.seen_turn`.
        recorded: Rotations of its fingers (15, 3), where they were recorded: no others are tried.

    None: nowhere near do fingers meet a far side of the thing.
    """
    hand, way = place.hand, direction(hold)
    out: Array = place.seen_turn @ np.array([0.0, 1.0, 0.0])
    out = out - (out @ way) * way
    out /= max(float(np.linalg.norm(out)), 1e-9)
    wrist = place.seen - place.seen_turn @ hand.palm
    every = np.flatnonzero(np.isin(np.argmax(body.weights, axis=1), [hand.wrist, *hand.fingers]))
    own = every[:: max(1, len(every) // _SAMPLES)].astype(np.int32)
    finger = _finger_of(body, hand, own)
    best, found = np.inf, None
    hooks = [hand.flexed(*hook) for hook in _HOOKS] if recorded is None else [recorded]
    for fingers in hooks:
        skin = wrist + hand.skin(body, fingers, own) @ place.seen_turn.T
        for depth in _DEPTHS:
            met = _met(hold.thing, skin + depth * out, way, finger)
            if met is None:
                continue
            along, missing, play = met
            shift = depth * out + along * way
            cost = (float(np.linalg.norm(shift)) / _AWAY) ** 2 + _MISSING * missing
            if cost < best:
                best, found = cost, Hook(hand, shift, way, out, fingers, play)
    return found


def taut(place: Place, hook: Hook) -> Place:
    """A place of a hand that closes around a thing, moved along the pull to where it meets it."""
    along = float((hook.shift - (place.point - place.seen)) @ hook.way)
    return replace(place, point=place.point + along * hook.way)


def held(
    motion: Motion, body: Body, hold: RecordedHold, hook: Hook, arrives: int
) -> tuple[Motion, float]:
    """The motion whose hand pulls with a hook; how far the hand was moved [m].

    Args:
        motion: The motion, T frames.
        body: The person's body.
        hold: What the hand pulls, and when.
        hook: How.
        arrives: The frame from which on the hand is near.
    """
    thing, hand = hold.thing, hook.hand
    timing = Timing.of(hold, arrives, len(motion), motion.fps)
    frames = np.flatnonzero(timing.share > 0.0)
    position, quaternion = (x[frames] for x in body.joint_frames(motion))
    here, turn = position[:, hand.wrist], rot.to_matrix(quaternion[:, hand.wrist])
    during = (frames >= hold.first) & (frames <= hold.last)
    seen = np.einsum("tji,tj->ti", thing.turn[frames], here - thing.position[frames])
    mean = np.median(seen[during], axis=0)
    to = seen + timing.fixed[frames, None] * (mean - seen) + hook.shift
    to = to + _OUTSIDE * (1.0 - timing.closed[frames, None]) * hook.out
    to = to - hook.play * _back(hold, hook)[frames, None] * hook.way
    to = thing.position[frames] + np.einsum("tij,tj->ti", thing.turn[frames], to)
    away = float(np.median(np.linalg.norm(to - here, axis=1)[during]))
    share = timing.share[frames, None]
    rotations = np.array(motion.rotations)
    rotations[np.ix_(frames, np.array(hand.arm))] = arm_pose.moved(
        motion, body, hand, frames, here + share * (to - here), turn
    )
    joints = np.array(hand.fingers)
    beyond = _SQUEEZE * timing.presses[frames, None, None] * hand.flexed(1.0, 1.0, 1.0)
    recorded = rotations[np.ix_(frames, joints)]
    shaped = hook.fingers + beyond
    rotations[np.ix_(frames, joints)] = recorded + share[..., None] * (shaped - recorded)
    return motion.with_frames(motion.translation, rotations), away


def _back(hold: RecordedHold, hook: Hook) -> Array:
    """Whether the thing goes back rather than out (T,), smoothly from 0 to 1."""
    thing = hold.thing
    along = (thing.centre - thing.centre[hold.first]) @ (thing.turn[hold.first] @ hook.way)
    along[: hold.first] = 0.0
    result: Array = ease((np.maximum.accumulate(along) - along) / _TURNING)
    return result


def _finger_of(body: Body, hand: Hand, vertices: NDArray[np.int32]) -> NDArray[np.int64]:
    """Which finger each vertex is of (n,): 0 to 3; -1: palm, back of the hand or thumb."""
    part = np.argmax(body.weights, axis=1)[vertices]
    names = ("index", "middle", "ring", "pinky")
    out = np.full(len(vertices), -1)
    for k, name in enumerate(names):
        own = [j for j in hand.fingers if name in JOINT_NAMES[j]]
        out[np.isin(part, own)] = k
    return out


def _met(
    thing: Thing, skin: Array, way: Array, finger: NDArray[np.int64]
) -> tuple[float, int, float] | None:
    """Where a hand (n, 3) that moves along a way meets the thing with its fingers.

    Returns how far along the way [m], how many fingers do not meet it, and the free way behind [m];
    None: it meets it otherwise or not at all.
    """
    gaps = thing.gaps(skin[None] + _ALONG[:, None, None] * way)
    free = gaps.min(axis=1) > 0.0
    best = None
    for k in np.flatnonzero(free[:-1] & ~free[1:]):
        meets = gaps[k + 1] < 0.0
        fingers = np.unique(finger[meets & (finger >= 0)])
        if (finger[meets] >= 0).mean() < _OF_FINGERS or len(fingers) < _FINGERS:
            continue
        near, far = float(_ALONG[k]), float(_ALONG[k + 1])
        while far - near > _FINE:
            middle = 0.5 * (near + far)
            inside = thing.gaps(skin + middle * way).min() < 0.0
            near, far = (near, middle) if inside else (middle, far)
        behind = k
        while behind > 0 and free[behind - 1]:
            behind -= 1
        play = min(near - float(_ALONG[behind]), _PLAY) if behind > 0 else 0.0
        if best is None or abs(near) < abs(best[0]):
            best = near, 4 - len(fingers), play
    return best
