"""The trunk leans, turns and sinks, so that a hand comes to what is far away or low."""

from __future__ import annotations

import math

from halfphysics.actors.figure import Trunk
from halfphysics.actors.glides import Spring
from halfphysics.actors.stride import Stand
from halfphysics.actors.turns import Vec, about_x, multiply, plus, wrapped

#: The farthest that the trunk leans [rad], and sinks [m]. All lengths here are those of a person
#: with legs of `_LEG` [m]; they are as much longer as legs are.
MOST, LOWEST = 0.9, 0.42
_LEG = 0.83
# An arm is comfortable up to this share of its length; lean by this much for what lacks [rad/m].
_EASY, _GAIN = 0.9, 2.0
# The pelvis's share of a lean; how far it goes back, by the lean [m/rad].
_PELVIS, _BACK = 0.4, 0.22
# Points lower than this make the person sink [m], by this share.
_LOW, _SINK = 0.72, 0.8
# How far the trunk turns the shoulder ahead that reaches [rad].
_TURN = 0.45


class Stoop:
    """Lean, turn and sinking of a person who reaches.

    Args:
        leg: Length of the person's legs [m].
    """

    def __init__(self, leg: float) -> None:
        self._size = leg / _LEG
        self._lean, self._twist = Spring(0.3), Spring(0.3)
        self._aside, self._sink = Spring(0.3), Spring(0.35)

    @property
    def lean(self) -> float:
        """How far the trunk leans [rad]."""
        return self._lean.value

    @property
    def pitch(self) -> float:
        """How far the chest is turned forwards [rad]."""
        return self._lean.value * math.cos(self._aside.value) + 0.5 * self._sink.value

    def advance(self, dt: float, need: tuple[float, Vec, Vec, float, float] | None) -> None:
        """Go on by `dt` [s].

        Args:
            need: Length of the arm [m], its shoulder and its point in the world [m], its side (1:
                left) and the heading of the person [rad]; None: no hand reaches.
        """
        if need is None:
            for spring in (self._lean, self._twist, self._aside, self._sink):
                spring.advance(0.0, dt)
            return
        length, shoulder, point, left, yaw = need
        lacks = math.dist(shoulder, point) - _EASY * length
        lean = min(max(self._lean.value + _GAIN * lacks / self._size, 0.0), MOST)
        dx, dy = point[0] - shoulder[0], point[1] - shoulder[1]
        aside = min(max(wrapped(math.atan2(dy, dx) - yaw), -1.2), 1.2)
        if math.hypot(dx, dy) < 0.1:
            aside = 0.0
        self._lean.advance(lean, dt)
        self._aside.advance(aside, dt)
        self._twist.advance(-left * _TURN * min(1.0, 0.25 + lean / 0.4) + 0.25 * aside, dt)
        self._sink.advance(min(max(_SINK * (_LOW - point[2] / self._size), 0.0), LOWEST), dt)

    def trunk(self, trunk: Trunk) -> Trunk:
        """The spine, leaning."""
        lean = (1.0 - _PELVIS) * self._lean.value
        c, s = math.cos(self._aside.value), math.sin(self._aside.value)
        return Trunk(trunk.twist + self._twist.value, trunk.tilt - lean * s, trunk.bend + lean * c)

    def stand(self, stand: Stand) -> Stand:
        """The pelvis, leaning; it goes back and down, so that the feet carry the person."""
        lean, sink = self._lean.value, self._sink.value
        if abs(lean) < 1e-9 and abs(sink) < 1e-9:
            return stand
        back = _BACK * lean + 0.15 * sink
        down = sink + 0.7 * back * back
        c, s = math.cos(stand.yaw), math.sin(stand.yaw)
        back, down = back * self._size, down * self._size
        pelvis = plus(stand.pelvis, (-back * c, -back * s, -down))
        tilt = _PELVIS * lean + 0.5 * sink
        return stand._replace(pelvis=pelvis, root=multiply(stand.root, about_x(tilt)))
