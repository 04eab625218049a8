"""What a person does above its feet: sits, leans, reaches, looks, and is never quite still."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.actors.figure import (
    ArmTurns,
    Figure,
    Trunk,
    swinging_arm,
    walking_gaze,
    walking_trunk,
)
from halfphysics.actors.gaze import Look
from halfphysics.actors.reach import Reach
from halfphysics.actors.seat import Seat
from halfphysics.actors.stoop import Stoop
from halfphysics.actors.stride import SIGN, Stand, Stride
from halfphysics.actors.turns import Vec, about_x, multiply, plus
from halfphysics.actors.walker import SIDES

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.pose import Pose

# Sway of who stands: to the side and ahead [m], of the trunk [rad]; frequencies [Hz].
_SWAY = (0.006, 0.004)
_BREATH = 0.012
# How much of the trunk's pitch a hanging arm takes back.
_HANG = 0.85
_RATES = (0.11, 0.17, 0.25, 0.07)


class Poise:
    """Trunk, arms and head of one person.

    Args:
        body: Its body.
        figure: Its skeleton.
    """

    def __init__(self, body: Body, figure: Figure) -> None:
        self._body, self._figure = body, figure
        self._leg = figure.leg

    def begin(self, seed: int, stand: Stand) -> Pose:
        """Stand with arms that hang; to be called first. The sway is drawn from a seed."""
        self._phases = np.random.default_rng(seed).uniform(0.0, 2.0 * math.pi, 4).tolist()
        self._time = 0.0
        return self.restart(stand)

    def restart(self, stand: Stand) -> Pose:
        """Stand with arms that hang, whatever it did before; its sway goes on."""
        self.seat, self._stoop, self._look = Seat(), Stoop(self._leg), Look()
        self.reaches = {side: Reach(self._body, self._figure, side) for side in SIDES}
        return self.pose(stand)

    def palm(self, side: str) -> Vec:
        """Where a palm was in the last pose [m]."""
        return self._palms[SIDES.index(side)]

    def lacks(self, side: str, point: Vec) -> float:
        """What a stretched arm lacks to a point without leaning any farther [m]."""
        _, shoulder = self._figure.shoulder(side, self._chest, self._arms[side].collar)
        length = self._figure.arms[side].length + 0.9 * self.reaches[side].hand
        return math.dist(shoulder, point) - length

    def advance(self, dt: float, stand: Stand, at: Vec | None, ahead: float) -> None:
        """Go on by `dt` [s].

        Args:
            dt: Length of the frame [s].
            stand: Pelvis and feet.
            at: What is looked at, world [m]; None: nothing.
            ahead: Where the way goes, to the left of where the person faces [rad].
        """
        self._time += dt
        self.seat.advance(dt)
        for reach in self.reaches.values():
            reach.advance(dt)
        self._stoop.advance(dt, self._need(stand))
        self._look.advance(dt, self._chest, self._figure.eyes, at, ahead)

    def _need(self, stand: Stand) -> tuple[float, Vec, Vec, float, float] | None:
        """Of the hand that has most to go: see `Stoop.advance`."""
        needs = []
        for side, reach in self.reaches.items():
            if reach.point is None:
                continue
            _, shoulder = self._figure.shoulder(side, self._chest, self._arms[side].collar)
            length = self._figure.arms[side].length + 0.9 * reach.hand
            lacks = self.lacks(side, reach.point)
            needs.append((lacks, (length, shoulder, reach.point, SIGN[side], stand.yaw)))
        return max(needs, key=lambda need: need[0])[1] if needs else None

    def pose(self, stand: Stand) -> Pose:
        """All of it as a pose."""
        stride = stand.stride
        stand, trunk = self._swaying(stand, walking_trunk(stride))
        stand = self._stoop.stand(self.seat.stand(stand))
        trunk = self._stoop.trunk(self.seat.trunk(trunk))
        chest = self._chest = self._figure.chest(stand, trunk)
        gaze = self._look.gaze(self.seat.gaze(walking_gaze(stride)))
        # Who leans keeps the face up.
        gaze = gaze._replace(nod=gaze.nod - 0.35 * self._stoop.lean)
        self._arms = {
            side: reach.turns(chest, self._hanging(SIGN[side], stride))
            for side, reach in self.reaches.items()
        }
        self._palms = tuple(self.reaches[side].palm_at(chest, self._arms[side]) for side in SIDES)
        left, right = (self._arms[side] for side in SIDES)
        curls = tuple(self.reaches[side].curl.value for side in SIDES)
        return self._figure.pose(stand, chest, gaze, (left, right), curls)  # type: ignore[arg-type]

    def _hanging(self, left: float, stride: Stride) -> ArmTurns:
        """An arm that does not reach: who leans lets it hang down."""
        arm = self.seat.arm(left, swinging_arm(left, stride))
        turn = -_HANG * self._stoop.pitch
        return arm._replace(shoulder=multiply(about_x(turn), arm.shoulder)) if turn else arm

    def _swaying(self, stand: Stand, trunk: Trunk) -> tuple[Stand, Trunk]:
        """Who stands sways and breathes."""
        still = max(0.0, 1.0 - stand.stride.going)
        a, b, c, d = (
            math.sin(2.0 * math.pi * rate * self._time + phase)
            for rate, phase in zip(_RATES, self._phases, strict=True)
        )
        side, ahead = still * _SWAY[0] * (a + 0.5 * d), still * _SWAY[1] * b
        x, y = math.cos(stand.yaw), math.sin(stand.yaw)
        pelvis = plus(stand.pelvis, (x * ahead - y * side, y * ahead + x * side, -0.0015 * still))
        bend = still * _BREATH * c
        return stand._replace(pelvis=pelvis), trunk._replace(bend=trunk.bend + bend)
