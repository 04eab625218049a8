"""When a hand comes, closes, presses, lets go and leaves: shares of the adaptation over time.

comes      within 0.4 s, ending 0.1 s before it is near: from its recorded way to that, shifted
closes     0.3 s, until 0.3 s before the thing moves: the palm onto the surface, fingers around
presses    a rise of 0.15 s, in full 0.15 s before the thing moves
lets go    from when the thing rests to the hold's end, within 0.1 s if it does not rest; the palm
           leaves the surface in 0.3 s
leaves     within 0.5 s it is on its recorded way again
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.easing import ease

if TYPE_CHECKING:
    from halfphysics.adaptation.recorded_holds import RecordedHold

Array = NDArray[np.float64]

#: A hand leaves its recorded way so long before it is near the thing, is on its shifted way so long
#: before that, and is back on its recorded way so long after it left [s].
COMES, BEFORE, GOES = 0.5, 0.1, 0.5
#: A hand that waits near a thing goes to its shifted way no earlier than this before it closes [s].
WAITS = 0.3
#: It closes, and opens, in this time [s].
CLOSES, OPENS = 0.3, 0.3
#: It presses with full force this long before the thing moves, after a rise of as long [s].
AHEAD = 0.15
#: It lets go within this time [s].
LETS_GO = 0.1


@dataclass(frozen=True, eq=False)
class Timing:
    """Shares from 0 to 1 of every frame (T,).

    Attributes:
        share: Of the adaptation: 0 where the motion is as recorded.
        fixed: How far the hand stands still on the thing, rather than going its recorded way.
        closed: How far the hand is closed.
        presses: How much of its force it presses with.
    """

    share: Array
    fixed: Array
    closed: Array
    presses: Array

    @classmethod
    def of(cls, hold: RecordedHold, arrives: int, frames: int, fps: float) -> Timing:
        """The timing of one hand of a hold.

        Args:
            hold: What is held, and when.
            arrives: The frame from which on the hand is near the thing.
            frames: T, of the motion.
            fps: Frame rate [1/s].
        """
        time = np.arange(frames) / fps
        touches = hold.first / fps - 2.0 * AHEAD
        if touches > 0.0:
            closes = touches - CLOSES
            comes = min(max(arrives / fps, closes - WAITS), closes)
            share = ease((time - (comes - COMES)) / (COMES - BEFORE))
            closed = ease((time - (touches - CLOSES)) / CLOSES)
            presses = ease((time - touches) / AHEAD)
        else:  # held from the start
            share, closed = np.ones(frames), np.ones(frames)
            presses = ease(time / max(hold.first / fps, AHEAD))
        fixed = closed.copy()
        if not hold.kept:
            # What bears it takes over from when it rests; in the air it is let go of at the end.
            gone = max(hold.last, hold.rests + LETS_GO * fps) / fps
            presses *= 1.0 - ease((time - hold.rests / fps) / (gone - hold.rests / fps))
            opens = 1.0 - ease((time - gone + 0.5 * LETS_GO) / OPENS)
            fixed *= opens
            closed *= opens
            share *= 1.0 - ease((time - gone - 0.5 * OPENS) / GOES)
        return cls(share, fixed * share, closed, presses * share)
