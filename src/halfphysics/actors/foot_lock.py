"""Feet that stand stay where they are, whatever a clip or a change of clips does to them.

A foot stands while its toe joint is low and slow in the motion that is played. Where it begins to
stand it is locked: its leg is bent so that the toe joint stays there. When it lifts, what the lock
has added fades away.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.actors.glides import Glide
from halfphysics.actors.limbs import LegBones, vec
from halfphysics.actors.turns import (
    Quat,
    Vec,
    back,
    cross,
    dot,
    exp,
    frame,
    log,
    multiply,
    plus,
    rotate,
    times,
    unit,
)
from halfphysics.actors.walker import SIDES
from halfphysics.scenarios.acting.legs import leg_of

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

# A toe joint stands that is slower than this [m/s] and not this far above its lowest [m]; one that
# stands goes on up to twice the speed.
_SLOW, _LOW = 0.35, 0.035
# Time in which what a lock has added fades [s], and the farthest that it holds a foot off [m].
_FADE, _FAR = 0.3, 0.25
# Beyond this share of its length a leg stays behind: a straight knee snaps.
_STRETCHED = 0.975


class Leg:
    """One leg in a pose: world positions and rotations of its joints."""

    def __init__(self, bones: LegBones, body: Body, side: str) -> None:
        leg = leg_of(body, side)
        self.bones = bones
        self._thigh, self._shank = vec(leg.thigh), vec(leg.shank)

    def place(self, root: Quat, pelvis: Vec, rotations: list[Vec]) -> None:
        """Where the joints of a pose are: root, pelvis, and the rotations of hip, knee, ankle."""
        self.hip_turn = multiply(root, exp(rotations[0]))
        self.knee_turn = multiply(self.hip_turn, exp(rotations[1]))
        self.foot_turn = multiply(self.knee_turn, exp(rotations[2]))
        self.hip = plus(pelvis, rotate(root, self.bones.hip))
        self.knee = plus(self.hip, rotate(self.hip_turn, self._thigh))
        self.ankle = plus(self.knee, rotate(self.knee_turn, self._shank))
        self.toe = plus(self.ankle, rotate(self.foot_turn, self.bones.toe))

    def _reached(self, wanted: float, own: float) -> float:
        """A distance of the ankle from the hip [m]: who nearly stretches the leg stays behind."""
        easy = max(_STRETCHED * self.bones.length, own)
        rest = max(self.bones.length - easy, 1e-4)
        return wanted if wanted < easy else easy + rest * (1.0 - math.exp((easy - wanted) / rest))

    def moved(self, root: Quat, by: Vec) -> list[Vec]:
        """Rotations of hip, knee and ankle that move the foot `by` [m], the foot as it was.

        The knee stays on its side of the line from hip to ankle; thigh and shank keep their twist.
        """
        a, b = self.bones.thigh, self.bones.shank
        old = plus(self.ankle, self.hip, -1.0)
        knee = plus(self.knee, self.hip, -1.0)
        new = plus(old, by)
        size = math.sqrt(dot(new, new))
        distance = max(self._reached(size, math.hypot(*old)), abs(a - b) + 1e-6)
        line = times(new, 1.0 / size)
        side = cross(knee, old)
        if dot(side, side) < 1e-8:
            side = rotate(root, (1.0, 0.0, 0.0))
        side = unit(plus(side, line, -dot(side, line)))
        front = cross(line, side)
        cosine = min((a * a + distance * distance - b * b) / (2.0 * a * distance), 1.0)
        sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
        there = plus(times(line, a * cosine), front, a * sine)
        plane = unit(cross(knee, old)) if dot(cross(knee, old), cross(knee, old)) > 1e-8 else side
        thigh = _carried(knee, plane, there, side, self.hip_turn)
        shank = _carried(
            plus(old, knee, -1.0),
            plane,
            plus(times(line, distance), there, -1.0),
            side,
            self.knee_turn,
        )
        return [
            log(multiply(back(root), thigh)),
            log(multiply(back(thigh), shank)),
            log(multiply(back(shank), self.foot_turn)),
        ]


def _carried(old: Vec, old_side: Vec, new: Vec, side: Vec, turn: Quat) -> Quat:
    """A bone's rotation after its direction and the plane of the leg have changed."""
    return multiply(multiply(frame(new, side), back(frame(old, old_side))), turn)


class FootLock:
    """Both feet of a body.

    Args:
        body: Whose feet.
    """

    def __init__(self, body: Body) -> None:
        self._legs = {side: Leg(LegBones.of(body, side), body, side) for side in SIDES}
        self._height = {
            side: leg.bones.height + leg.bones.toe[1] for side, leg in self._legs.items()
        }
        self.begin()

    def begin(self) -> None:
        """Nothing is locked."""
        self._at: dict[str, Vec | None] = dict.fromkeys(SIDES)
        self._offset = {side: (Glide(), Glide()) for side in SIDES}
        self._toes: dict[str, Vec] = {}
        self._shown: dict[str, Vec] = {}

    def toes(self, pelvis: Vec, rotations: Array) -> dict[str, Vec]:
        """World positions of the toe joints in a pose [m].

        Args:
            pelvis: Position of the pelvis joint, world.
            rotations: Axis-angle (55, 3).
        """
        found = {}
        root = exp(vec(rotations[0]))
        for side, leg in self._legs.items():
            leg.place(root, pelvis, [vec(rotations[j]) for j in leg.bones.joints[:3]])
            found[side] = leg.toe
        return found

    def locked(
        self,
        dt: float,
        source: dict[str, Vec],
        shown: dict[str, Vec],
        root: Vec,
        rotations: Array,
    ) -> Array:
        """A pose (55, 3) with its standing feet where they are.

        Args:
            dt: Time since the last pose [s].
            source: The toe joints in the motion that is played, of which feet stand.
            shown: The toe joints in the pose: the last that `toes` was asked for.
            root: Axis-angle of its pelvis.
            rotations: Of all its joints (55, 3).
        """
        turn = exp(root)
        out = np.array(rotations)
        for side, leg in self._legs.items():
            offset = self._held(side, dt, source[side], shown[side])
            if offset != (0.0, 0.0, 0.0):
                out[list(leg.bones.joints[:3])] = leg.moved(turn, offset)
        self._toes, self._shown = source, shown
        return out

    def _held(self, side: str, dt: float, toe: Vec, shown: Vec) -> Vec:
        """What is added to the place of a foot [m]."""
        x, y = self._offset[side]
        at = self._at[side]
        if self._stands(side, dt, toe, shown):
            if at is None:
                at = (shown[0] + x.value, shown[1] + y.value, 0.0)
            for glide, held, now in zip((x, y), at, shown, strict=False):
                glide.put(held - now, dt)
            if not self._stretched(side, (x.value, y.value, 0.0)):
                self._at[side] = at
                return (x.value, y.value, 0.0)
        if at is not None or (x.goal, y.goal) != (0.0, 0.0):
            self._at[side] = None
            for glide in (x, y):
                glide.to(0.0, _FADE)
        return (x.advance(dt), y.advance(dt), 0.0)

    def _stands(self, side: str, dt: float, toe: Vec, shown: Vec) -> bool:
        """Whether a foot stands in the motion, and is not on its way in what is shown."""
        slow = _SLOW if self._at[side] is None else 2.0 * _SLOW
        speed = math.dist(toe[:2], self._toes.get(side, toe)[:2]) / dt
        if speed > slow or toe[2] > self._height[side] + _LOW:
            return False
        own = math.dist(shown[:2], self._shown.get(side, shown)[:2]) / dt
        return self._at[side] is not None or own < _SLOW

    def _stretched(self, side: str, offset: Vec) -> bool:
        """Whether a lock would stretch a leg, or is too far."""
        leg = self._legs[side]
        old = plus(leg.ankle, leg.hip, -1.0)
        new = math.hypot(*plus(old, offset))
        most = max(_STRETCHED * leg.bones.length, math.hypot(*old))
        return new > most or math.hypot(*offset) > _FAR
