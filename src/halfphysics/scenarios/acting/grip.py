"""A hand closed around an upright round object: finger angles found from the skin by bisection.

All quantities are in the hand's frame: rest axes, origin at the wrist. A right hand points along
-x, its palm faces -y and its thumb is on the side of +z; the axis of the held object is along z.
Contact is found by comparing the outlines of the simulator's hulls with that of the object, seen
along this axis, and also from above and below if the object is not a cylinder.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS, RIGHT_HAND_JOINTS

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

WRIST = JOINT_INDEX["right_wrist"]
#: The right hand's joints, knuckle to tip, thumb last.
FINGERS = np.array(
    [
        [JOINT_INDEX[f"right_{name}{k}"] for k in (1, 2, 3)]
        for name in ("index", "middle", "ring", "pinky", "thumb")
    ]
)
_THUMB = 4
#: Largest flexion tried [rad], knuckle to tip, thumb last.
_LIMITS = np.array([[1.5, 1.7, 1.2]] * 4 + [[1.2, 1.1, 1.2]])
#: Relative flexion rates of the joints while a finger closes.
_RATES = np.array([[0.75, 1.0, 0.6]] * 4 + [[1.0, 0.7, 0.7]])
#: A distance below the gap plus this [m] counts as touching.
_TOUCH = 1e-4
#: An open hand has this fraction of the closed angles; its thumb opens by this angle [rad].
_OPEN, _THUMB_AWAY = 0.25, 0.5
#: Direction of the thumb before it flexes, opposite the palm and beside the object.
_OPPOSED = np.array([0.35, -1.0, -0.45])
#: The knuckle of the middle finger is this far before the axis of the object [m].
_KNUCKLE = 0.010
#: An object without contact over this angle of its circle is not held: it can leave [rad].
_OPEN_SIDE = np.radians(200.0)
#: Viewing directions of an outline: at 0.5 degrees a circle is round to 1e-5.
_LOOKS = np.radians(np.arange(0.0, 360.0, 0.5))
#: Tilts, and directions at each tilt, for an outline that is not a cylinder.
_TILTS, _TILTED_LOOKS = np.radians(np.arange(-60.0, 61.0, 10.0)), _LOOKS[::4]


@dataclass(frozen=True, eq=False)
class Grip:
    """The grip of a right hand around an upright round object.

    Attributes:
        centre: Axis of the object at the middle of the hand, from the wrist, (3,) [m].
        angles: Flexion at contact, (5, 3) [rad]: fingers as in `FINGERS`.
        thumb: Rotation of the opposed thumb's first joint before it flexes, (3, 3).
    """

    centre: Array
    angles: Array
    thumb: Array

    def fingers(self, closed: ArrayLike, squeeze: float) -> Array:
        """Rotations of the right hand's 15 joints, (T, 15, 3), in the order of SMPL-X.

        Args:
            closed: 0 open to 1 closed, (T,).
            squeeze: Flexion of every joint of the closed hand beyond contact [rad].
        """
        share = np.asarray(closed, dtype=np.float64)[:, None, None]
        opened = _OPEN * self.angles
        opened[_THUMB] = self.angles[_THUMB] - [_THUMB_AWAY, 0.5 * _THUMB_AWAY, 0.0]
        turned = _turned(opened + share * (self.angles + squeeze - opened), self.thumb)
        out = np.zeros((len(share), len(RIGHT_HAND_JOINTS), 3))
        out[:, FINGERS.ravel() - RIGHT_HAND_JOINTS[0]] = turned.reshape(len(share), -1, 3)
        return out


@dataclass(frozen=True, eq=False)
class _Round:
    """A convex round object about z, by its support function: `reach` (k,) [m] in directions
    `tilts` (k,) [rad] above the horizontal, for azimuths `looks` (l,) [rad]."""

    tilts: Array
    reach: Array
    looks: Array

    @classmethod
    def of(cls, outline: Array) -> _Round:
        """From rows of height above the middle of the hand, and radius (n, 2) [m]."""
        if np.ptp(outline[:, 1]) == 0.0:
            return cls(np.zeros(1), outline[:1, 1], _LOOKS)
        reach = np.outer(np.cos(_TILTS), outline[:, 1]) + np.outer(np.sin(_TILTS), outline[:, 0])
        return cls(_TILTS, reach.max(axis=1), _TILTED_LOOKS)


def grip(body: Body, outline: float | ArrayLike, gap: float = 0.001) -> Grip:
    """The grip of a body's right hand around a round object, at a distance of `gap`.

    Args:
        body: The person's body.
        outline: The radius of a cylinder [m], or rows of height above the middle of the hand, and
            radius (n, 2) [m], whose hull is used.
        gap: Distance between every touching joint's skin and the object [m].

    Raises:
        InputError: The object is too thick or too thin for this hand.
    """
    given = np.asarray(outline, dtype=np.float64)
    held = _Round.of(np.array([[0.0, float(given)]]) if given.ndim == 0 else given)
    radius = float(given if given.ndim == 0 else given[:, 1].max())
    hand = _Hand(body)
    angles = np.zeros((5, 3))
    knuckle = hand.joints[JOINT_INDEX["right_middle1"]] - hand.joints[WRIST]
    across = [hand.joints[FINGERS[f, 0], 2] - hand.joints[WRIST, 2] for f in (0, 3)]
    centre = np.array([knuckle[0] + _KNUCKLE, 0.0, float(np.mean(across))])
    thumb = _opposed(hand)
    # As near to the palm as the straight fingers allow.
    palm = [WRIST, *FINGERS[:_THUMB].ravel()]

    def palm_is_clear(y: float) -> bool:
        result: bool = hand.gaps(angles, thumb, np.array([centre[0], -y]), held, palm).min() > gap
        return result

    centre[1] = -_first(palm_is_clear, 0.0, 0.2)[1]
    for finger, row in enumerate(angles):

        def gaps(parts: list[int]) -> Array:
            return hand.gaps(angles, thumb, centre, held, parts)

        _wrap(finger, row, gaps, gap)
    away, sides = hand.around(angles, thumb, centre, held, palm + list(FINGERS[_THUMB]))
    touched = np.sort(sides[away < 2.0 * gap])
    if not len(touched) or np.diff([*touched, touched[0] + 2.0 * np.pi]).max() > _OPEN_SIDE:
        raise InputError(
            f"radius: found {radius!r} m, expected what a hand closes around: 0.025 to 0.05 m"
        )
    return Grip(centre, angles, thumb)


class _Hand:
    """A body's right hand, with all other joints at rest."""

    def __init__(self, body: Body) -> None:
        self.body = body
        self.joints: Array = np.asarray(body.rest_joints)
        hulls = body.skin_hulls
        own = np.flatnonzero(np.isin(hulls.part, [WRIST, *RIGHT_HAND_JOINTS]))
        sets = [hulls.vertex[hulls.first[h] : hulls.first[h + 1]] for h in own]
        self.parts = hulls.part[own]
        self.first = np.cumsum([0, *(len(s) for s in sets[:-1])])
        self.vertex = np.concatenate(sets)
        self.of_hull = np.repeat(self.parts, [len(s) for s in sets])

    def gaps(
        self, angles: Array, thumb: Array, centre: Array, held: _Round, parts: list[int]
    ) -> Array:
        """Distances between the hulls of some parts and the object [m], (hulls,); 0: touching."""
        return self.around(angles, thumb, centre, held, parts)[0]

    def around(
        self, angles: Array, thumb: Array, centre: Array, held: _Round, parts: list[int]
    ) -> tuple[Array, Array]:
        """As `gaps`, and the side of the object as an azimuth [rad], (hulls,)."""
        rotations = np.zeros((N_JOINTS, 3))
        rotations[FINGERS.ravel()] = _turned(angles[None], thumb).reshape(-1, 3)
        rows = np.isin(self.of_hull, parts)
        pose = Pose(np.zeros(3), rotations)
        points = self.body.vertices(pose, indices=self.vertex[rows]) - self.joints[WRIST]
        points -= [centre[0], centre[1], centre[2] if len(centre) == 3 else 0.0]
        looks = np.stack([np.cos(held.looks), np.sin(held.looks)])
        chosen = np.isin(self.parts, parts)
        sizes = np.diff([*self.first, len(self.vertex)])[chosen]
        first = np.cumsum([0, *sizes[:-1]])
        sideways = points[:, :2] @ looks
        away = np.full((chosen.sum(), len(held.looks)), -np.inf)
        for tilt, reach in zip(held.tilts, held.reach, strict=True):
            seen = np.cos(tilt) * sideways + np.sin(tilt) * points[:, 2:]
            np.maximum(away, np.minimum.reduceat(seen, first, axis=0) - reach, out=away)
        return np.maximum(away.max(axis=1), 0.0), held.looks[away.argmax(axis=1)]


def _opposed(hand: _Hand) -> Array:
    """Rotation (3, 3) of the thumb's first joint that points the thumb away from the palm."""
    first, last = FINGERS[_THUMB, 0], FINGERS[_THUMB, 2]
    rest = hand.joints[last] - hand.joints[first]
    rest /= np.linalg.norm(rest)
    wanted = _OPPOSED / np.linalg.norm(_OPPOSED)
    axis = np.cross(rest, wanted)
    angle = np.arctan2(np.linalg.norm(axis), rest @ wanted)
    matrix: Array = rot.rotvec_to_matrix(axis / np.linalg.norm(axis) * angle)
    return matrix


def _turned(angles: Array, thumb: Array) -> Array:
    """Axis-angles (T, 5, 3, 3) of all fingers for flexions (T, 5, 3) [rad]."""
    out = np.zeros((*angles.shape, 3))
    out[..., 2] = angles  # a finger flexes about z
    # The thumb closes against the fingers, about z of the opposed thumb.
    axis = -thumb[2]
    out[:, _THUMB] = angles[:, _THUMB, :, None] * axis
    flexed = rot.rotvec_to_matrix(out[:, _THUMB, 0])
    out[:, _THUMB, 0] = rot.matrix_to_rotvec(thumb @ flexed)
    return out


def _wrap(finger: int, row: Array, gaps: Callable[[list[int]], Array], gap: float) -> None:
    """Flex a finger around the object: touching bones stop, the bones beyond them go on.

    Args:
        finger: Row of `FINGERS`.
        row: Flexions of the finger (3,) [rad], changed in place.
        gaps: Function that gives the distances of parts at the present flexions [m].
        gap: The distance to keep [m].
    """
    start = 0
    while start < 3:
        before, rates, parts = row.copy(), _RATES[finger].copy(), list(FINGERS[finger, start:])
        rates[:start] = 0.0
        room = np.divide(_LIMITS[finger] - before, rates, where=rates > 0.0, out=np.full(3, np.inf))

        def is_clear(amount: float) -> bool:
            row[:] = before + amount * rates  # noqa: B023 - called at once
            return bool(gaps(parts).min() > gap)  # noqa: B023

        is_clear(_last(is_clear, float(room.min())))
        reached = gaps(parts)
        if reached.min() > gap + _TOUCH:  # stopped by a joint limit
            start += int(np.argmin(room[start:])) + 1
        else:
            start += int(np.argmin(reached)) + 1


def _first(clear: Callable[[float], bool], low: float, high: float) -> tuple[float, float]:
    """Bracket of the change of `clear` from false at `low` to true at `high`."""
    for _ in range(24):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if clear(middle) else (middle, high)
    return low, high


def _last(clear: Callable[[float], bool], limit: float) -> float:
    """The largest value up to `limit` with all smaller values clear; 0: none is."""
    step, reached = 0.05, 0.0
    while reached < limit:
        nxt = min(reached + step, limit)
        if not clear(nxt):
            low, high = reached, nxt
            for _ in range(12):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if clear(middle) else (low, middle)
            return low
        reached = nxt
    return limit
