"""Sitting down, sitting, and standing up: the pelvis leaves the place above the feet."""

from __future__ import annotations

import math

from halfphysics.actors.figure import ArmTurns, Gaze, Trunk
from halfphysics.actors.glides import Glide
from halfphysics.actors.stride import Stand
from halfphysics.actors.turns import Vec, about_x, about_y, multiply, plus, times

#: Of a person who sits, by the length of its legs: how far the pelvis is behind the ankles, and
#: its joint above the seat, which gives by two centimetres.
BEHIND, ABOVE = 0.51, 0.11
# Thighs slope down from a seat higher than this by the length of a leg, over its edge: by this much
# of what it is higher, the pelvis is higher above it.
_KNEES, _HIGHER = 0.55, 0.35
# Times of sitting down [s]: until the pelvis is down, and until the trunk leans forwards most.
_DOWN, _FORWARD = 1.5, 0.9
# Times of standing up: until the trunk leans forwards most, then until the person stands.
_READY, _UP = 0.7, 1.3
# Pitch of the pelvis [rad]: on the way, and at rest.
_WAY, _REST = 0.62, -0.1
# Bend of the spine, nod of the head, lift of the arms, bend of the elbows [rad]: on the way, at
# rest. At rest arms hang, and hands are over the thighs: upper arms are turned in by `_INWARD`.
_BEND = (0.3, 0.12)
_NOD = (-0.25, 0.0)
_ARMS = (-0.75, -0.05)
_ELBOWS = (0.35, 1.1)
_INWARD = (0.0, 0.3)


class Seat:
    """What sitting adds to a stand."""

    def __init__(self) -> None:
        self._across, self._down, self._pitch = Glide(), Glide(), Glide()
        self._bend, self._nod = Glide(), Glide()
        self._arms, self._elbows, self._inward = Glide(), Glide(), Glide()
        self._pelvis: Vec = (0.0, 0.0, 0.0)
        self._wait: tuple[float, str] | None = None

    @property
    def free(self) -> bool:
        """Whether the person stands."""
        return self._wait is None and self._down.goal == 0.0 and self._all_there()

    @property
    def rests(self) -> bool:
        """Whether the person sits, at rest."""
        return self._wait is None and self._down.goal == 1.0 and self._all_there()

    @property
    def rising(self) -> bool:
        """Whether the person is about to stand, or stands."""
        return self._down.goal == 0.0 or (self._wait is not None and self._wait[1] == "up")

    def _all_there(self) -> bool:
        return all(g.there for g in (self._across, self._down, self._pitch, self._bend, self._arms))

    @property
    def _arm_glides(self) -> tuple[Glide, Glide, Glide]:
        return (self._arms, self._elbows, self._inward)

    def sit(self, pelvis: Vec) -> None:
        """Sit down: the pelvis joint comes to a place in the world [m]."""
        self._pelvis = pelvis
        self._across.to(1.0, _DOWN)
        self._down.to(1.0, _DOWN)
        self._lean(0, _WAY, _FORWARD)
        self._wait = (_FORWARD, "rest")

    def rise(self) -> None:
        """Stand up."""
        if self.rising:
            return
        self._lean(0, _WAY, _READY)
        self._wait = (0.75 * _READY, "up")

    def _lean(self, way: int, pitch: float, seconds: float) -> None:
        self._pitch.to(pitch, seconds)
        self._bend.to(_BEND[way], seconds)
        self._nod.to(_NOD[way], seconds)
        self._arms.to(_ARMS[way], seconds)
        self._elbows.to(_ELBOWS[way], seconds)
        self._inward.to(_INWARD[way], seconds)

    def advance(self, dt: float) -> None:
        """Go on by `dt` [s]."""
        if self._wait is not None:
            left = self._wait[0] - dt
            if left > 0.0:
                self._wait = (left, self._wait[1])
            else:
                self._go_on(self._wait[1])
        for glide in (self._across, self._down, self._pitch, self._bend):
            glide.advance(dt)
        for glide in (self._nod, *self._arm_glides):
            glide.advance(dt)

    def _go_on(self, what: str) -> None:
        self._wait = None
        if what == "rest":
            self._lean(1, _REST, 1.1)
            return
        self._across.to(0.0, _UP)
        self._down.to(0.0, _UP)
        for glide in (self._pitch, self._bend, self._nod, *self._arm_glides):
            glide.to(0.0, _UP)

    def stand(self, stand: Stand) -> Stand:
        """Pelvis and feet of the person."""
        if self.free:
            return stand
        across, down = self._across.value, self._down.value
        x, y, z = plus(self._pelvis, stand.pelvis, -1.0)
        pelvis = plus(stand.pelvis, (across * x, across * y, down * z))
        return stand._replace(pelvis=pelvis, root=multiply(stand.root, about_x(self._pitch.value)))

    def trunk(self, trunk: Trunk) -> Trunk:
        """The spine, bent."""
        return trunk._replace(bend=trunk.bend + self._bend.value)

    def gaze(self, gaze: Gaze) -> Gaze:
        """The head, nodding against the trunk."""
        return gaze._replace(nod=gaze.nod + self._nod.value)

    def arm(self, left: float, arm: ArmTurns) -> ArmTurns:
        """An arm, lifted and turned in, with its elbow bent."""
        if not any(glide.value for glide in self._arm_glides):
            return arm
        lifted = multiply(about_x(self._arms.value), about_y(-left * self._inward.value))
        return arm._replace(
            shoulder=multiply(lifted, arm.shoulder),
            elbow=multiply(about_y(-left * self._elbows.value), arm.elbow),
        )


def seat_pelvis(place: tuple[float, float], height: float, leg: float) -> Vec:
    """Where the pelvis joint of a person with legs of a length is on a seat [m]."""
    return (place[0], place[1], height + ABOVE * leg + _HIGHER * max(0.0, height - _KNEES * leg))


def feet_before(place: tuple[float, float], heading: float, leg: float) -> tuple[float, float]:
    """Where a person stands who is about to sit at a place [m]."""
    x, y, _ = times((math.cos(heading), math.sin(heading), 0.0), BEHIND * leg)
    return (place[0] + x, place[1] + y)
