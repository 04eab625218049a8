"""A hand on its way to a point, at it, and back to the swing of its arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from halfphysics.actors.figure import CURL, ArmTurns, Chest, Figure
from halfphysics.actors.glides import Glide, Spring
from halfphysics.actors.limbs import vec
from halfphysics.actors.stride import SIGN
from halfphysics.actors.turns import (
    Quat,
    Vec,
    about_x,
    about_y,
    about_z,
    frame,
    from_swing_twist,
    multiply,
    plus,
    rotate,
    swing_twist,
    times,
    unit,
)
from halfphysics.body.joint_ranges import JointRanges
from halfphysics.scenarios.acting.reaching import knuckle_ahead, palm_depth

if TYPE_CHECKING:
    from halfphysics.body.body import Body

#: How a hand comes: its palm towards the other hand, down or up.
PALMS = ("in", "down", "up")
# Direction of the elbow from the line to the hand, in the chest's frame: out, up, ahead.
_ELBOWS: tuple[Vec, ...] = (
    (0.35, -1.0, -0.3),
    (0.8, -0.8, -0.2),
    (0.1, -1.0, 0.0),
    (1.0, -0.2, -0.4),
    (0.5, -0.6, -0.9),
)


class _Manner(NamedTuple):
    """How an arm reaches; what leaves its joints the most room is taken, once a reach.

    Attributes:
        elbow: Of `_ELBOWS`.
        roll: Of the hand about its fingers, from where it is to face [rad].
        level: How much nearer to the horizontal the fingers are than the way to the point, 0 to 1.
        steep: Whether the palm also faces back, as it does on the way straight down.
        cost: What makes others better in case of doubt.
    """

    elbow: Vec
    roll: float
    level: float
    steep: bool
    cost: float


_MANNERS = tuple(
    _Manner(elbow, roll, level, steep, 0.002 * i + (0.05 if steep else 0.0) + 0.02 * level)
    for i, elbow in enumerate(_ELBOWS)
    for roll in (0.0, 0.5, -0.5, 1.1, -1.1)
    for level, steep in ((0.3, False), (0.0, False), (0.75, False), (0.3, True))
)
# Joints end this far within their ranges [rad].
_WITHIN = 0.01
# Where an arm can choose, its joints stay this far from their ends [rad].
_MARGIN = 0.3
# A point that moves is followed with this time constant [s].
_FOLLOW = 0.12
#: Speed of a hand on its way, in the mean [m/s]; and the least time of a way [s].
_SPEED, _LEAST = 0.5, 1.0
# Points from the first to the second of these heights [m] are come to from above, more and more: by
# this share of the way the arm is drawn in, from that share on it stretches.
_TABLE, _DRAWN, _LATE = (0.65, 0.85), 0.55, 0.3
# An arm that is drawn in: the upper arm back and down, and the elbow bent [rad].
_UPPER, _DOWN, _ELBOW = 0.35, 1.15, 2.0
OPEN, CLOSED = 0.15, 0.9


class _Range:
    """Of one joint: its axes, and the ends of its angles [rad]."""

    def __init__(self, ranges: JointRanges, joint: int) -> None:
        first, second, third = ranges.axes[joint]
        self.axes = (vec(first), vec(second), vec(third))
        self.lower = vec(ranges.lower[joint] + _WITHIN)
        self.upper = vec(ranges.upper[joint] - _WITHIN)

    def angles(self, turn: Quat) -> Vec:
        return swing_twist(turn, self.axes)

    def tight(self, angles: Vec) -> float:
        """How much less than `_MARGIN` angles are from their ends [rad]."""
        return sum(
            max(0.0, _MARGIN - min(a - low, high - a))
            for a, low, high in zip(angles, self.lower, self.upper, strict=True)
        )

    def kept(self, angles: Vec) -> tuple[Vec, float]:
        """Angles within the range, and how far they were beyond it [rad]."""
        held = tuple(
            min(max(a, low), high)
            for a, low, high in zip(angles, self.lower, self.upper, strict=True)
        )
        beyond = sum(abs(a - b) for a, b in zip(angles, held, strict=True))
        return held, beyond  # type: ignore[return-value]


class Reach:
    """One arm that reaches.

    Args:
        body: The person's body.
        figure: Its skeleton.
        side: "left" or "right".
    """

    def __init__(self, body: Body, figure: Figure, side: str) -> None:
        self.side, self._left = side, SIGN[side]
        self._figure, self._bones = figure, figure.arms[side]
        ranges = JointRanges.of(body)
        self._ranges = [_Range(ranges, joint) for joint in self._bones.joints]
        arm = (
            multiply(about_x(_UPPER), about_z(-self._left * _DOWN)),
            about_y(-self._left * _ELBOW),
            about_x(0.3),
        )
        self._drawn = [held.angles(turn) for held, turn in zip(self._ranges, arm, strict=True)]
        #: The point of a hand that comes to a point: at the palm, behind the knuckles.
        self.palm: Vec = (
            self._left * 0.85 * knuckle_ahead(body, side),
            -palm_depth(body, side),
            0.0,
        )
        self.hand = float(np.linalg.norm(self.palm))
        self.share, self.curl = Glide(), Glide(CURL)
        self.point: Vec | None = None
        self.facing = "in"
        self._at: tuple[Spring, Spring, Spring] | None = None
        self._manner: _Manner | None = None

    @property
    def there(self) -> bool:
        """Whether the hand is at its point."""
        return self.point is not None and self.share.there and self.share.goal == 1.0

    @property
    def free(self) -> bool:
        """Whether the arm swings as if nothing had been."""
        return self.share.there and self.share.goal == 0.0

    def to(self, point: Vec, facing: str, way: float) -> None:
        """Bring the hand to a point, which may be told anew in every frame.

        Args:
            point: World [m].
            facing: Of `PALMS`.
            way: Of the hand, nearly [m].
        """
        if self.point is None or self.share.goal == 0.0:
            self.share.to(1.0, max(_LEAST, way / _SPEED))
            self.curl.to(OPEN, 0.5)
            self._manner = None
        if self._at is None:
            self._at = tuple(Spring(_FOLLOW, x) for x in point)  # type: ignore[assignment]
        self.point, self.facing = point, facing

    def back(self, seconds: float = 1.2) -> None:
        """Let the arm hang again; a hand that has closed stays closed until it reaches again."""
        if self.share.goal != 0.0:
            self.share.to(0.0, seconds)
            if self.curl.goal != CLOSED:
                self.curl.to(CURL, seconds)
        self.point = None

    def close(self, closed: bool) -> None:
        """Close or open the fingers."""
        self.curl.to(CLOSED if closed else OPEN, 0.35)

    def advance(self, dt: float) -> None:
        """Go on by `dt` [s]."""
        self.curl.advance(dt)
        self.share.advance(dt)
        if self.free:
            self._at = None
        elif self._at is not None and self.point is not None:
            for spring, x in zip(self._at, self.point, strict=True):
                spring.advance(x, dt)

    def turns(self, chest: Chest, swinging: ArmTurns) -> ArmTurns:
        """Rotations of the arm: between its swing and its reach."""
        share, at = self.share.value, self._at
        if share <= 0.0 or at is None:
            return swinging
        goal = (at[0].value, at[1].value, at[2].value)
        if self._manner is None:
            self._manner = min(
                _MANNERS, key=lambda manner: self._solved(chest, swinging, goal, manner, 2)[1]
            )
        angles, _ = self._solved(chest, swinging, goal, self._manner, 4)
        ready, there = self._shares(share, goal[2])
        joints = []
        for now, drawn, then, held in zip(
            swinging[1:], self._drawn, angles, self._ranges, strict=True
        ):
            own = held.angles(now)
            own = plus(own, plus(drawn, own, -1.0), ready)
            joints.append(from_swing_twist(plus(own, plus(then, own, -1.0), there), held.axes))
        return ArmTurns(swinging.collar, *joints)

    @staticmethod
    def _shares(share: float, height: float) -> tuple[float, float]:
        """How far an arm is drawn in, and how far it is at its point, by its share of the way.

        A hand that comes to what lies on a table comes from above: first its elbow bends.
        """
        high = min(max((height - _TABLE[0]) / (_TABLE[1] - _TABLE[0]), 0.0), 1.0)
        ready = high * _soft(share / _DRAWN)
        late = _soft((share - _LATE) / (1.0 - _LATE))
        return ready, share + high * (late - share)

    def _solved(
        self, chest: Chest, swinging: ArmTurns, goal: Vec, manner: _Manner, tries: int
    ) -> tuple[list[Vec], float]:
        """Angles of shoulder, elbow and wrist within their ranges, and how bad they are.

        Where a range stops the hand, the hand is taken as it is then and its palm is brought to the
        goal, `tries` times.
        """
        collar, shoulder = self._figure.shoulder(self.side, chest, swinging.collar)
        hand = self._hand(chest, shoulder, goal, manner)
        x, y, z = manner.elbow
        out = rotate(chest.turn, (self._left * x, y, z))
        angles: list[Vec] = []
        for left in range(tries - 1, -1, -1):
            wrist = plus(goal, rotate(hand, self.palm), -1.0)
            solved = self._bones.solve(collar, shoulder, wrist, hand, out)
            angles, beyond = [], 0.0
            for turn, held in zip(solved, self._ranges, strict=True):
                kept, more = held.kept(held.angles(turn))
                angles.append(kept)
                beyond += more
            if beyond < 1e-9 or not left:
                tight = sum(
                    held.tight(kept) for kept, held in zip(angles[:2], self._ranges, strict=False)
                )
                cost = 0.3 * tight + 0.1 * abs(manner.roll) + manner.cost
                return angles, beyond + cost
            turns = (
                from_swing_twist(kept, held.axes)
                for kept, held in zip(angles, self._ranges, strict=True)
            )
            hand = collar
            for turn in turns:
                hand = multiply(hand, turn)
        return angles, 0.0

    def _hand(self, chest: Chest, shoulder: Vec, goal: Vec, manner: _Manner) -> Quat:
        """World rotation of the hand: fingers along the way, palm as it is to face."""
        along = unit(plus(goal, shoulder, -1.0))
        inward = rotate(chest.turn, (-self._left, 0.0, 0.0))
        up = (0.0, 0.0, 1.0)
        # Wrists bend rather than point at what is high or low.
        along = unit(plus(along, up, -manner.level * along[2]))
        if self.facing == "in":
            face = plus(inward, up, -0.35)
        elif self.facing == "down":
            face = plus(times(up, -1.0), inward, 0.35)
        else:
            face = plus(up, inward, 0.35)
        if manner.steep:
            face = plus(face, rotate(chest.turn, (0.0, 0.0, -1.0)))
        hand = frame(times(along, self._left), times(face, -1.0))
        return multiply(hand, about_x(manner.roll))

    def palm_at(self, chest: Chest, arm: ArmTurns) -> Vec:
        """Where the palm is, world [m]."""
        bones = self._bones
        turn, at = self._figure.shoulder(self.side, chest, arm.collar)
        turn = multiply(turn, arm.shoulder)
        at = plus(at, rotate(turn, self._figure.upper[self.side]))
        turn = multiply(turn, arm.elbow)
        at = plus(at, rotate(turn, times(bones.along, bones.fore)))
        turn = multiply(turn, arm.wrist)
        return plus(at, rotate(turn, self.palm))


def _soft(x: float) -> float:
    """0 up to 0, 1 from 1 on, with no speed at either."""
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)
