"""Legs and arms of one frame: inverse kinematics in tuples.

The same equations as `scenarios.acting.legs` and `scenarios.acting.arms`, which solve all frames of
a motion at once and which the tests compare these with.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.actors.turns import (
    WORLD_FROM_REST,
    Quat,
    Vec,
    about_x,
    about_z,
    back,
    cross,
    dot,
    exp,
    frame,
    multiply,
    plus,
    rotate,
    times,
    unit,
)
from halfphysics.scenarios.acting.arms import FOREARM, Arm, arm_of
from halfphysics.scenarios.acting.legs import Leg, leg_of

if TYPE_CHECKING:
    from halfphysics.body.body import Body

_X: Vec = (1.0, 0.0, 0.0)
_Y: Vec = (0.0, 1.0, 0.0)
_Z: Vec = (0.0, 0.0, 1.0)


def vec(array: object) -> Vec:
    """A vector (3,) as a tuple of floats."""
    x, y, z = np.asarray(array, dtype=np.float64)
    return (float(x), float(y), float(z))


@dataclass(frozen=True)
class LegBones:
    """`scenarios.acting.legs.Leg` as tuples, with what follows from it."""

    joints: tuple[int, int, int, int]
    hip: Vec
    thigh: float
    shank: float
    toe: Vec
    heel: Vec
    height: float
    length: float
    thigh_rest: Quat
    shank_rest: Quat

    @classmethod
    def of(cls, body: Body, side: str) -> LegBones:
        leg: Leg = leg_of(body, side)
        thigh, shank = vec(leg.thigh), vec(leg.shank)
        return cls(
            leg.joints,
            vec(leg.hip),
            math.sqrt(dot(thigh, thigh)),
            math.sqrt(dot(shank, shank)),
            vec(leg.toe),
            vec(leg.heel),
            leg.height,
            leg.length,
            back(frame(thigh, _X)),
            back(frame(shank, _X)),
        )

    def planted(self, x: float, y: float, yaw: float, pitch: float) -> tuple[Vec, Quat]:
        """Ankle and rotation of a foot that rolls over a fixed point of the ground at z = 0.

        Args:
            x, y: Point of the ground below the ankle of the flat foot [m].
            yaw: Heading of the foot [rad].
            pitch: Toes up (over the heel) where positive, heel up (over the toe joint) [rad].
        """
        upright = multiply(about_z(yaw), WORLD_FROM_REST)
        tilt = about_x(-pitch)
        pivot = self.heel if pitch > 0.0 else self.toe
        away = rotate(upright, plus(pivot, rotate(tilt, pivot), -1.0))
        return (x + away[0], y + away[1], self.height + away[2]), multiply(upright, tilt)

    def solve(self, root: Quat, hip: Vec, ankle: Vec, foot: Quat) -> tuple[Quat, Quat, Quat]:
        """Rotations of hip, knee and ankle, as `scenarios.acting.legs.solve`.

        Args:
            root: Rotation of the pelvis, world.
            hip, ankle: Positions, world [m]; an ankle out of reach is approached.
            foot: Rotation of the foot, world.
        """
        a, b = self.thigh, self.shank
        line = plus(ankle, hip, -1.0)
        size = math.sqrt(dot(line, line))
        distance = min(max(size, abs(a - b) + 1e-6), self.length)
        line = times(line, 1.0 / size)
        pole = plus(rotate(foot, _Z), rotate(root, _Z))
        side = unit(cross((pole[0], pole[1], 0.0), line))
        front = cross(line, side)
        cosine = (a * a + distance * distance - b * b) / (2.0 * a * distance)
        sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
        knee = plus(times(line, a * cosine), front, a * sine)
        thigh = multiply(frame(knee, side), self.thigh_rest)
        shank = multiply(frame(plus(times(line, distance), knee, -1.0), side), self.shank_rest)
        return (
            multiply(back(root), thigh),
            multiply(back(thigh), shank),
            multiply(back(shank), foot),
        )


@dataclass(frozen=True)
class ArmBones:
    """`scenarios.acting.arms.Arm` as tuples, with what follows from it."""

    collar: int
    joints: tuple[int, int, int]
    side: float
    upper: float
    fore: float
    along: Vec
    length: float
    upper_rest: Quat
    fore_rest: Quat

    @classmethod
    def of(cls, body: Body, side: str) -> ArmBones:
        arm: Arm = arm_of(body, side)
        upper, fore = vec(arm.upper), vec(arm.fore)
        return cls(
            arm.collar,
            arm.joints,
            1.0 if upper[0] > 0.0 else -1.0,
            math.sqrt(dot(upper, upper)),
            math.sqrt(dot(fore, fore)),
            unit(fore),
            arm.length,
            back(frame(upper, _Y)),
            back(frame(fore, _Y)),
        )

    def solve(
        self, collar: Quat, shoulder: Vec, wrist: Vec, hand: Quat, pole: Vec
    ) -> tuple[Quat, Quat, Quat]:
        """Rotations of shoulder, elbow and wrist, as `scenarios.acting.arms.solve`.

        Args:
            collar: Rotation of the collar, world.
            shoulder, wrist: Positions, world [m]; a wrist out of reach is approached.
            hand: Rotation of the hand, world.
            pole: Direction of the elbow, world, not along the line from shoulder to wrist.
        """
        a, b = self.upper, self.fore
        line = plus(wrist, shoulder, -1.0)
        size = math.sqrt(dot(line, line))
        distance = min(max(size, abs(a - b) + 1e-6), self.length)
        line = times(line, 1.0 / size)
        front = unit(plus(pole, line, -dot(pole, line)))
        cosine = (a * a + distance * distance - b * b) / (2.0 * a * distance)
        sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
        along = plus(times(line, cosine), front, sine)
        end = plus(times(line, distance), along, -a)
        hinge = times(cross(line, front), self.side)
        upper = multiply(frame(along, hinge), self.upper_rest)
        fore = multiply(frame(end, hinge), self.fore_rest)
        turn = multiply(back(fore), hand)
        twist = 2.0 * math.atan2(dot(turn[1:], self.along), turn[0])
        twist = math.remainder(twist, 2.0 * math.pi)
        twisted = multiply(fore, exp(times(self.along, FOREARM * twist)))
        return (
            multiply(back(collar), upper),
            multiply(back(upper), twisted),
            multiply(back(twisted), hand),
        )
