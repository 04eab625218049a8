"""Where hands hold a thing: palms flat on its surface, opposed where two carry it.

A hand was recorded near a place of the thing, off by centimetres, at about one pose in the thing's
frame. Of two hands the palms are turned onto the surface and moved until they touch. They hold by
friction if the line between them is inside both cones (antipodal grasps, Nguyen 1988): of the
places around the recorded ones the nearest such pair is taken, level with the thing's weight if
possible. A hand alone is moved until the thing is in it, and its fingers close (fingers.py).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.adaptation.fingers import thumb_aside
from halfphysics.adaptation.hands import Hand
from halfphysics.adaptation.recorded_holds import RecordedHold
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.adaptation.thing import Thing
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

#: Palms are tried on places within this of the recorded one [m], so many.
_AROUND, _PLACES = 0.08, 240
#: A place costs as its distance over this [m], a pair as the angle from its line over this [rad],
#: the weight beside its line as the lever over this [m].
_FAR, _SLANTED, _BESIDE = 0.02, 0.25, 0.15
#: Palms are turned onto a surface by no more than this [rad]; beyond they hold as they are.
_TURNED = np.radians(70.0)
#: A grasping hand is moved by no more than this [m], in so many rounds, and stays as recorded with
#: this weight; skin counts that is nearer than the first [m] in the first round, the second in the
#: last.
_ALONG, _FITS, _KEEPS = 0.06, 24, 0.02
_REACHES, _TOUCHES = 0.04, 0.006
#: And skin outside counts so much against skin inside.
_PULLS = 0.05
#: A hand about to close, where fingers were not recorded: flexion of each joint [rad].
_ROUND = 0.6
#: Fingers that never turn by more than this [rad] were not recorded.
_STRAIGHT = 1e-3
#: Hands bear from below what weighs between these from the middles of their palms towards the
#: fingers [m]; a pair costs as what is beyond over the last [m]. Farther below a tray a forearm
#: that comes from above meets the edge and pushes it; farther out the fingers give way.
_BEARS, _TIPS = (-0.02, 0.085), 0.01
#: Rounds in which a palm is laid on the surface, by no more than this [m].
_LAYS, _LAID = 3, 0.03
#: A palm whose thumb lies beside it rolls off the ball of the thumb by one of these [rad].
_ROLLS = np.radians(np.arange(0.0, 12.1, 1.0))
#: A line leaves this share of the cone of friction unused, at least.
_SPARE = 0.25


@dataclass(frozen=True, eq=False)
class Place:
    """Where one hand holds, in the thing's frame.

    Attributes:
        hand: Which hand.
        point: Where the middle of its palm touches (3,) [m].
        normal: Outward normal of the surface there (3,).
        presses: Direction in which it presses (3,); zeros: against no other hand, it only bears.
        turn: Rotation of the hand, thing from wrist (3, 3).
        seen: Where the middle of its palm was recorded (3,) [m], the mean over the hold.
        seen_turn: And the hand's rotation (3, 3).
        grasps: Its fingers go around the thing; else its palm presses on it.
    """

    hand: Hand
    point: Array
    normal: Array
    presses: Array
    turn: Array
    seen: Array
    seen_turn: Array
    grasps: bool = False

    @property
    def wrist(self) -> Array:
        """Position of the wrist in the thing's frame (3,) [m]."""
        at: Array = self.point - self.turn @ self.hand.palm
        return at


def places(motion: Motion, body: Body, hold: RecordedHold, friction: float) -> tuple[Place, ...]:
    """Where each hand of a recorded hold is to be.

    Args:
        motion: The recorded motion.
        body: The person's body.
        hold: Who holds what, and when.
        friction: Of the hands on the thing.
    """
    thing, frames = hold.thing, slice(hold.first, hold.last + 1)
    position, quaternion = (x[frames] for x in body.joint_frames(motion))
    seen = []
    for hand in hold.hands:
        turn = np.swapaxes(thing.turn[frames], 1, 2) @ rot.to_matrix(quaternion[:, hand.wrist])
        wrist = np.einsum(
            "tji,tj->ti", thing.turn[frames], position[:, hand.wrist] - thing.position[frames]
        )
        seen.append((_mean(turn), np.median(wrist, axis=0)))
    if len(hold.hands) == 1:
        pose = _taking(motion, hold.hands[0], hold.middle)
        return (_grasp(body, thing, hold.hands[0], *seen[0], pose),)
    candidates = [
        _candidates(thing, hand, turn, wrist)
        for hand, (turn, wrist) in zip(hold.hands, seen, strict=True)
    ]
    picked, ways = (0,) * len(candidates), [np.zeros(3)] * len(candidates)
    if len(candidates) == 2:
        up = np.einsum("tji,j->ti", thing.turn[frames], [0.0, 0.0, 1.0]).mean(axis=0)
        up = up / max(float(np.linalg.norm(up)), 1e-9)
        pair = _opposed(thing, candidates, friction, up)
        if pair is not None:
            a, b = (c.points[k] for c, k in zip(candidates, pair, strict=True))
            line = (b - a) / np.linalg.norm(b - a)
            picked, ways = pair, [line, -line]
        else:
            ahead = [turn @ hand.ahead for hand, (turn, _) in zip(hold.hands, seen, strict=True)]
            picked = _bearing(thing, candidates, ahead, up)
    found = []
    for hand, its, k, before, way in zip(hold.hands, candidates, picked, seen, ways, strict=True):
        place = _place(hand, its, k, before, way)
        if way.any() and not fingers_known(motion, hand):
            place = _levelled(body, thing, place)
        found.append(_laid(body, thing, place))
    return tuple(found)


def _grasp(body: Body, thing: Thing, hand: Hand, turn: Array, wrist: Array, pose: Array) -> Place:
    """One hand around a thing, moved so that the inner side of all of it is as near as can be.

    Gauss-Newton on min_t sum_i w_i g_i(t)^2 + |t|^2 mu sum_i w_i, with g_i the distances of the
    inner side of the hand from the surface.
    """
    points = wrist + hand.skin(body, pose, hand.inner) @ turn.T
    moved = np.zeros(3)
    for width in np.geomspace(_REACHES, _TOUCHES, _FITS):
        here = points + moved
        gap = thing.gaps(here)
        _, _, nearest = thing.surface.closest(here)
        way = here - nearest
        length = np.linalg.norm(way, axis=1)
        # What is inside counts in full, what is far away hardly.
        weight = np.exp(-((gap / width) ** 2)) * _PULLS
        weight = np.where(gap < 0.0, 1.0, weight) * (length > 1e-9)
        normal = way / np.maximum(length, 1e-9)[:, None] * np.sign(gap)[:, None]
        keeps = _KEEPS * float(weight.sum())
        square = (normal.T * weight) @ normal + max(keeps, 1e-9) * np.eye(3)
        moved = moved + np.linalg.solve(square, -normal.T @ (weight * gap) - keeps * moved)
        moved *= min(1.0, _ALONG / max(float(np.linalg.norm(moved)), 1e-9))
    normal = turn @ np.array([0.0, 1.0, 0.0])
    palm = wrist + turn @ hand.palm
    return Place(hand, palm + moved, normal, np.zeros(3), turn, palm, turn, grasps=True)


def fingers_known(motion: Motion, hand: Hand) -> bool:
    """Whether the fingers of a hand were recorded."""
    return bool(np.abs(motion.rotations[:, list(hand.fingers)]).max() > _STRAIGHT)


def fingers_at(motion: Motion, place: Place, frame: int) -> Array:
    """Rotations of a hand's fingers (15, 3) as it holds: as recorded, or where closing starts."""
    if place.grasps:
        return _taking(motion, place.hand, frame)
    return np.asarray(motion.rotations[frame, list(place.hand.fingers)])


def _taking(motion: Motion, hand: Hand, frame: int) -> Array:
    """Rotations of the fingers (15, 3) of a hand about to close: as recorded, or half closed."""
    if fingers_known(motion, hand):
        return np.asarray(motion.rotations[frame, list(hand.fingers)])
    return hand.flexed(_ROUND, _ROUND, _ROUND)


def _mean(turns: Array) -> Array:
    """The mean of rotations (n, 3, 3): the nearest rotation to their sum."""
    u, _, v = np.linalg.svd(turns.sum(axis=0))
    result: Array = u @ np.diag([1.0, 1.0, np.linalg.det(u @ v)]) @ v
    return result


@dataclass(frozen=True, eq=False)
class _Candidates:
    """Places on a surface (k, 3), their normals (k, 3), and how far they are [m]; nearest first."""

    points: Array
    normals: Array
    away: Array


def _candidates(thing: Thing, hand: Hand, turn: Array, wrist: Array) -> _Candidates:
    """Places around that where a palm was recorded."""
    palm = wrist + turn @ hand.palm
    ball = np.random.default_rng(0).normal(size=(_PLACES, 3))
    radius = _AROUND * np.linspace(0.0, 1.0, _PLACES) ** 0.5
    ball *= (radius / np.linalg.norm(ball, axis=1))[:, None]
    _, face, points = thing.surface.closest(palm + ball)
    normals = thing.normals[face]
    # The palm faces the surface: not one behind it, on the far side of a board.
    facing = normals @ (turn @ np.array([0.0, 1.0, 0.0])) > np.cos(_TURNED)
    if facing.any():
        points, normals = points[facing], normals[facing]
    away = np.linalg.norm(points - palm, axis=1)
    order = np.argsort(away, kind="stable")
    return _Candidates(points[order], normals[order], away[order])


def _opposed(
    thing: Thing, candidates: list[_Candidates], friction: float, up: Array
) -> tuple[int, int] | None:
    """The best two places that press against each other; None: there are none."""
    a, b = candidates
    line = b.points[None] - a.points[:, None]
    length = np.linalg.norm(line, axis=2)
    line = line / np.maximum(length, 1e-9)[..., None]
    into = np.einsum("ijk,ik->ij", line, -a.normals), np.einsum("ijk,jk->ij", line, b.normals)
    angle = np.arccos(np.clip(np.minimum(*into), -1.0, 1.0))
    # Weight beside the line turns the thing about it, unless it hangs below.
    lever = thing.item.com - a.points[:, None]
    lever = lever - np.einsum("ijk,ijk->ij", lever, line)[..., None] * line
    level = lever - (lever @ up)[..., None] * up
    beside = np.linalg.norm(level, axis=2) + np.maximum(lever @ up, 0.0)
    cost = (
        (a.away[:, None] / _FAR) ** 2
        + (b.away[None] / _FAR) ** 2
        + (angle / _SLANTED) ** 2
        + (beside / _BESIDE) ** 2
    )
    cost[angle > (1.0 - _SPARE) * np.arctan(friction)] = np.inf
    best = int(np.argmin(cost))
    if not np.isfinite(cost.flat[best]):
        return None
    i, j = np.unravel_index(best, cost.shape)
    return int(i), int(j)


def _bearing(
    thing: Thing, candidates: list[_Candidates], ahead: list[Array], up: Array
) -> tuple[int, int]:
    """The best two places that bear from below: the weight is above the hands, palm to fingers.

    What is beyond reach, another one bears: then they stay where they are.
    """
    a, b = candidates
    along = ahead[0] + ahead[1]
    along = along - (along @ up) * up
    along = along / max(float(np.linalg.norm(along)), 1e-9)
    middle = 0.5 * (a.points[:, None] + b.points[None])
    beyond = (thing.item.com - middle) @ along
    off = np.maximum(beyond - _BEARS[1], 0.0) + np.maximum(_BEARS[0] - beyond, 0.0)
    if off[0, 0] > _AROUND:
        return 0, 0
    below = np.maximum(-a.normals @ up, 0.0)[:, None] * np.maximum(-b.normals @ up, 0.0)
    cost = (a.away[:, None] / _FAR) ** 2 + (b.away[None] / _FAR) ** 2 + below * (off / _TIPS) ** 2
    i, j = np.unravel_index(int(np.argmin(cost)), cost.shape)
    return int(i), int(j)


def _laid(body: Body, thing: Thing, place: Place) -> Place:
    """The place with the palm moved along the surface's normal until its skin just touches."""
    hand = place.hand
    part = np.argmax(np.asarray(body.weights)[hand.inner], axis=1)
    palm = np.asarray(body.rest_vertices)[hand.inner[part == hand.wrist]]
    palm = palm - np.asarray(body.rest_joints)[hand.wrist]
    for _ in range(_LAYS):
        gap = float(thing.gaps(place.wrist + palm @ place.turn.T).min(initial=np.inf))
        if abs(gap) > _LAID:
            break
        place = replace(place, point=place.point - gap * place.normal)
    return place


def _levelled(body: Body, thing: Thing, place: Place) -> Place:
    """The place with the palm rolled until both of its sides are on the surface.

    The ball of the thumb stands proud of a palm: a thing between two of them is held at two points,
    and turns about their line.
    """
    hand = place.hand
    root = JOINT_INDEX[f"{hand.side}_thumb1"]
    part = np.argmax(np.asarray(body.weights), axis=1)
    skin = np.flatnonzero(np.isin(part, [hand.wrist, root])).astype(np.int32)
    fingers = np.zeros((len(hand.fingers), 3))
    fingers[hand.fingers.index(root)] = thumb_aside(body, hand.side)
    local = hand.skin(body, fingers, skin)
    ball = part[skin] == root
    other = ~ball & (local[:, 2] < hand.palm[2])
    if not ball.any() or not other.any():
        return place
    level, least = place, np.inf
    for roll in _ROLLS:
        turn = place.turn @ rot.rotvec_to_matrix(np.array([-roll, 0.0, 0.0]))
        rolled = replace(place, turn=turn)
        gaps = thing.gaps(rolled.wrist + local @ turn.T)
        off = abs(float(gaps[ball].min() - gaps[other].min()))
        if off < least:
            level, least = rolled, off
    return level


def _place(
    hand: Hand, its: _Candidates, k: int, before: tuple[Array, Array], presses: Array
) -> Place:
    """A palm turned onto the surface, by the smallest rotation from where it was `before`."""
    seen_turn, wrist = before
    turn = seen_turn
    normal = its.normals[k]
    faces = turn @ np.array([0.0, -1.0, 0.0])
    axis = np.cross(faces, -normal)
    sine, cosine = float(np.linalg.norm(axis)), float(faces @ -normal)
    angle = np.arctan2(sine, cosine)
    if sine > 1e-9 and angle < _TURNED:
        turn = rot.rotvec_to_matrix(axis / sine * angle) @ turn
    return Place(
        hand, its.points[k], normal, presses, turn, wrist + seen_turn @ hand.palm, seen_turn
    )
