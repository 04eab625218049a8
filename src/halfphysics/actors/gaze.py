"""The head follows what is looked at, as far as necks turn."""

from __future__ import annotations

import math

from halfphysics.actors.figure import Chest, Gaze
from halfphysics.actors.glides import Spring
from halfphysics.actors.turns import Vec, back, plus, rotate

# The farthest that head and neck turn to a side, down and up [rad]: within the ranges of both.
_TURN, _DOWN, _UP = 1.25, 0.9, -0.75
_TIME = 0.35


class Look:
    """Turn and nod of the head towards a point."""

    def __init__(self) -> None:
        self._turn, self._nod = Spring(_TIME), Spring(_TIME)

    def advance(self, dt: float, chest: Chest, eyes: Vec, at: Vec | None, ahead: float) -> None:
        """Go on by `dt` [s].

        Args:
            chest: Where the chest is.
            eyes: The head from it, in its frame [m].
            at: What is looked at, world [m]; None: nothing.
            ahead: Where the way goes, to the left of the chest's heading [rad]: nobody looks
                elsewhere while walking.
        """
        turn, nod = 0.6 * ahead, 0.0
        if at is not None:
            x, y, z = plus(rotate(back(chest.turn), plus(at, chest.at, -1.0)), eyes, -1.0)
            turn, nod = math.atan2(x, z), -math.atan2(y, math.hypot(x, z))
            if abs(turn) > 2.2:  # behind: not at all rather than over the wrong shoulder
                turn, nod = 0.0, 0.0
        self._turn.advance(min(max(turn, -_TURN), _TURN), dt)
        self._nod.advance(min(max(nod, _UP), _DOWN), dt)

    def gaze(self, gaze: Gaze) -> Gaze:
        """The head of a walk, with the look added."""
        return Gaze(gaze.turn + self._turn.value, gaze.nod + self._nod.value)
