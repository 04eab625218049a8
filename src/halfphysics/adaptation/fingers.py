"""Fingers that close around a thing: flexed until they touch, bone by bone, the thumb opposite.

Recordings of bodies often have no fingers. With the hand at its place every finger flexes about its
own axes from how it was recorded (or half closed) until its skin meets the surface; the bones
beyond the one that touches go on. Of the ways a thumb can oppose the one is taken whose pad presses
most against those of the fingers. Nothing is closed beyond the ranges of joints.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body import skinning
from halfphysics.body.joint_ranges import JointRanges, from_swing_twist, swing_twist
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS

if TYPE_CHECKING:
    from halfphysics.adaptation.grips import Place
    from halfphysics.adaptation.thing import Thing
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

_NAMES = ("index", "middle", "ring", "pinky")
_KNUCKLES = {JOINT_INDEX[f"{side}_{name}1"] for side in ("left", "right") for name in _NAMES}
#: Flexion of a finger's joints, knuckle to tip, as it closes, and of the thumb's, relative.
_RATES, _THUMB_RATES = np.array([0.75, 1.0, 0.6]), np.array([0.6, 0.8, 0.8])
#: A finger opens by this before it closes, to straight at most, and closes by this at most [rad];
#: below a palm that presses by the last: fingers that meet nothing make no fist.
_BACK, _CLOSES, _PALM_CLOSES = 0.3, 2.0, 1.0
#: The root of a thumb that comes to a grasp is open by this [rad]: opposed and little open, it
#: pushes a glass away before it is in the hand. Its other joints bend no more back than fingers.
_THUMB_BACK = 1.0
#: Steps of a search, and rounds of it.
_STEPS, _ROUNDS = 24, 2
#: Skin that is nearer than this touches [m].
_TOUCHES = 0.0015
#: Ways in which a thumb opposes: abduction of its root [rad].
_OPPOSES = np.radians([-90.0, -80.0, -70.0, -60.0])
#: A finger that meets nothing stays this much bent [rad]. Below a palm it is as bent as those that
#: touch, and no joint is bent by more than this more than theirs.
_IDLE, _TOGETHER = 0.5, 0.3
_FLEXION, _ABDUCTION = 1, 2


@dataclass(frozen=True, eq=False)
class Closed:
    """Fingers around a thing, as angles (twist, flexion, abduction) of `JointRanges`.

    Attributes:
        joints: Their joints (15,).
        angles: As they touch (15, 3) [rad].
        presses: Flexion (15, 3) that goes on for each radian of pressing; 0: nothing touches.
        opened: As the hand comes and goes (15, 3) [rad]; None: as recorded.
    """

    joints: NDArray[np.int64]
    angles: Array
    presses: Array
    opened: Array | None


def closed(body: Body, thing: Thing, place: Place, start: Array, known: bool) -> Closed:
    """The fingers of a hand around a thing.

    Args:
        body: The person's body.
        thing: What it holds.
        place: Where the hand is.
        start: Rotations of its fingers (15, 3) [rad], where closing starts.
        known: They were recorded: the thumb opposes as it did.
    """
    hand = _Hand(body, thing, place, known)
    rotations = np.zeros((N_JOINTS, 3))
    rotations[list(place.hand.fingers)] = start
    angles = hand.ranges.angles(rotations)
    presses = np.zeros((N_JOINTS, 3))
    normals = []
    rows = np.array([[JOINT_INDEX[f"{place.hand.side}_{n}{k}"] for k in (1, 2, 3)] for n in _NAMES])
    for joints in rows:
        normal = hand.close(angles, list(joints), _RATES, presses)
        normals += [] if normal is None else [normal]
    if not place.grasps and not known:
        _together(angles, rows, presses)
    thumb = [JOINT_INDEX[f"{place.hand.side}_thumb{k}"] for k in (1, 2, 3)]
    if not place.grasps:
        if not known:
            aside = thumb_aside(body, place.hand.side)
            angles[thumb[0]] = swing_twist(rot.exp(aside), hand.ranges.axes[thumb[0]])
    elif not known or hand.close(angles, thumb, _THUMB_RATES, presses) is None:
        _close_thumb(hand, angles, thumb, presses, normals)
    own = np.array(place.hand.fingers)
    opened = angles.copy()
    flexion = angles[:, _FLEXION]
    opened[:, _FLEXION] = np.minimum(flexion, np.maximum(flexion - _BACK, 0.0))
    if place.grasps:
        root = flexion[thumb[0]] - _THUMB_BACK
        opened[thumb[0], _FLEXION] = max(root, hand.ranges.lower[thumb[0], _FLEXION])
    opened = opened[own]
    return Closed(own, angles[own], presses[own], None if known else opened)


def _together(angles: Array, rows: NDArray[np.int64], presses: Array) -> None:
    """Bends fingers (4, 3) about as those of them that touch, in place: a hand is no staircase."""
    touch = presses[rows[:, 0], _FLEXION] > 0.0
    if not touch.any():
        return
    usual = np.median(angles[rows[touch], _FLEXION], axis=0)
    for joints, touches in zip(rows, touch, strict=True):
        flexion = angles[joints, _FLEXION]
        most = usual + _TOGETHER if touches else usual
        # What is bent less than it takes does not touch.
        lacks = np.logical_or.accumulate(flexion > most)
        presses[joints[lacks], _FLEXION] = 0.0
        angles[joints, _FLEXION] = np.minimum(flexion, most) if touches else usual


def thumb_aside(body: Body, side: str) -> Array:
    """Axis-angle (3,) of a thumb's root that puts the thumb into the plane of the palm.

    At rest it is in front of the palm, and would bear what the palm should press with.
    """
    rest = np.asarray(body.rest_joints)
    first, last = (rest[JOINT_INDEX[f"{side}_thumb{k}"]] for k in (1, 3))
    along = (last - first) / np.linalg.norm(last - first)
    axis = np.cross(along, along * [1.0, 0.0, 1.0])
    sine = float(np.linalg.norm(axis))
    cosine = float(along @ (along * [1.0, 0.0, 1.0]))
    out: Array = axis * (np.arctan2(sine, cosine) / max(sine, 1e-12))
    return out


def _close_thumb(
    hand: _Hand, angles: Array, joints: list[int], presses: Array, normals: list[Array]
) -> None:
    """Closes the thumb the way that opposes the fingers best, in place."""
    against = np.mean(normals, axis=0) if normals else hand.place.normal
    best, found = np.inf, None
    lower, upper = hand.ranges.lower[joints[0]], hand.ranges.upper[joints[0]]
    for way in np.clip(_OPPOSES, lower[_ABDUCTION], upper[_ABDUCTION]):
        tried, bent = angles.copy(), np.zeros_like(presses)
        tried[joints] = 0.0
        tried[joints[0], _ABDUCTION] = way
        normal = hand.close(tried, joints, _THUMB_RATES, bent)
        if normal is not None and float(normal @ against) < best:
            best, found = float(normal @ against), (tried, bent)
    if found is not None:
        angles[joints], presses[joints] = found[0][joints], found[1][joints]


class _Hand:
    """A hand at its place: what its fingers meet."""

    def __init__(self, body: Body, thing: Thing, place: Place, known: bool = False) -> None:
        self.body, self.thing, self.place, self.known = body, thing, place, known
        self.ranges = JointRanges.of(body)
        self.part = np.argmax(body.weights, axis=1)
        self.wrist = place.wrist

    def seen(self, angles: Array, vertices: NDArray[np.int32]) -> Array:
        """Skin in the thing's frame (n, k, 3), for angles of all joints (n, 55, 3)."""
        rotations = np.zeros_like(angles)
        joints = list(self.place.hand.fingers)
        rotations[:, joints] = from_swing_twist(angles[:, joints], self.ranges.axes[joints])
        rest = np.asarray(self.body.rest_joints)
        root = np.broadcast_to(rest[0], (len(angles), 3))
        at, turns = skinning.kinematics(rotations, np.ascontiguousarray(root), rest)
        skin = skinning.skin(self.body.skin, rotations, at, turns, indices=vertices)
        local = skin - rest[self.place.hand.wrist]
        result: Array = self.wrist + local @ self.place.turn.T
        return result

    def close(self, angles: Array, joints: list[int], rates: Array, presses: Array) -> Array | None:
        """Flexes one finger until it touches, in place; the normal where it does, None: nowhere."""
        start, normal = 0, None
        # Straight at most, or as recorded; only a thumb's root opens farther.
        least = np.minimum(angles[joints, _FLEXION], 0.0)
        if joints[0] not in _KNUCKLES:
            least[0] = self.ranges.lower[joints[0], _FLEXION]
        most = self.ranges.upper[joints, _FLEXION]
        while start < 3:
            moving = np.where(np.arange(3) >= start, rates, 0.0)
            back = _BACK if joints[0] in _KNUCKLES else _THUMB_BACK
            low = -back if start == 0 else 0.0
            high = _CLOSES if self.place.grasps else _PALM_CLOSES
            vertices = np.flatnonzero(np.isin(self.part, joints[start:])).astype(np.int32)
            bone = np.searchsorted(joints, self.part[vertices])
            begin = angles[joints, _FLEXION].copy()
            hit = None
            for _ in range(_ROUNDS):
                amounts = np.linspace(low, high, _STEPS)
                flexion = np.clip(begin + amounts[:, None] * moving, least, most)
                tried = np.repeat(angles[None], _STEPS, axis=0)
                tried[:, joints, _FLEXION] = flexion
                points = self.seen(tried, vertices)
                gaps = self.thing.gaps(points)
                touching = np.flatnonzero(gaps.min(axis=1) < _TOUCHES)
                if not len(touching):
                    break
                k = int(touching[0])
                hit = k
                low, high = amounts[max(k - 1, 0)], amounts[k]
            if hit is None:
                if start == 0 and not self.known:
                    angles[joints, _FLEXION] = np.clip(begin + _IDLE * rates, least, most)
                break
            before = max(hit - 1, 0)
            angles[joints, _FLEXION] = flexion[before]
            nearest = int(gaps[hit].argmin())
            presses[joints[: bone[nearest] + 1], _FLEXION] = 1.0
            _, face, _ = self.thing.surface.closest(points[hit, nearest : nearest + 1])
            normal = self.thing.normals[face[0]]
            start = int(bone[nearest]) + 1
        return normal
