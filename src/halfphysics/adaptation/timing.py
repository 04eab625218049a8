"""When a hand comes, closes, presses, lets go and leaves: shares of the adaptation over time.

comes      within 0.5 s, from its recorded way to that, shifted
closes     0.4 s, until 0.3 s before the thing moves: the palm onto the surface, fingers around
presses    a rise of 0.4 s, in full 0.15 s before the thing moves
lets go    over the last 0.3 s in which the thing rests in the hands, or 0.1 s around their end
leaves     the surface from 0.15 s before that to 0.25 s after; on its recorded way after 0.65 s

All are as slow as they can be: a hand that jerks pushes what it should hold.
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

#: The palm is at the surface so long before the thing moves [s]: slow starts are seen late.
TOUCHES = 0.3
#: It comes onto the surface, and fingers close, within this time until then [s].
CLOSES = 0.4
#: A hand goes from its recorded way to the shifted one within this time [s], and is there when it
#: is near the thing, but not earlier or later than this before it touches [s].
COMES, EARLY, LATE = 0.5, 0.2, 0.15
#: In a clip that starts shortly before, it takes this long for that, if there is time [s].
HASTE = 0.3
#: A hand that is at the thing from the clip's start on and comes within this time [s] is there at
#: once: its recorded place may be inside the thing.
FROM_START = 1.5
#: It presses in full so long before the thing moves, after a rise of this time [s].
AHEAD, RISES = 0.15, 0.4
#: Its force falls within this time until it lets go, from when the thing rests; within the second,
#: around that moment, where it does not rest [s].
FALLS, THROWS = 0.3, 0.1
#: Palm and fingers leave the surface from this before they let go on, within the second [s]; a hand
#: that has sunk in by a centimetre is off it in time.
OPENS, OPENING = 0.15, 0.4
#: Palms between which a thing does not rest leave from this before on [s].
THROWS_OPENS = 0.05
#: A grasp whose fingers were not recorded lets go so long after the thing rests [s], if the hand
#: has not left it before: nobody recorded that its fingers opened.
UNSEEN = 0.5
#: And so long before the recorded hand leaves: it leaves with open fingers, at the latest [s].
OPEN_BEFORE = 0.3
#: A hand is back on its recorded way within the second, from the first after it let go on [s].
LEAVES, GOES = 0.1, 0.55


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
    def of(
        cls,
        hold: RecordedHold,
        arrives: int,
        frames: int,
        fps: float,
        *,
        grasps: bool = False,
        unseen: bool = False,
    ) -> Timing:
        """The timing of one hand of a hold.

        Args:
            hold: What is held, and when.
            arrives: The frame from which on the hand is near the thing.
            frames: T, of the motion.
            fps: Frame rate [1/s].
            grasps: Its fingers hold the thing.
            unseen: Its fingers were not recorded.
        """
        time = np.arange(frames) / fps
        touches = hold.first / fps - TOUCHES
        if touches > 0.0:
            comes = min(max(arrives / fps, touches - EARLY), touches - LATE)
            pressing = hold.first / fps - AHEAD
            share = _rises(time, comes - COMES, max(comes, min(touches, HASTE)))
            if arrives == 0 and comes < FROM_START:
                share = np.ones(frames)
            closed = _rises(time, touches - CLOSES, touches)
            presses = _rises(time, pressing - RISES, pressing)
        else:  # held from the start
            share, closed = np.ones(frames), np.ones(frames)
            presses = ease(time / max(hold.first / fps, AHEAD))
        fixed = closed.copy()
        if not hold.kept:
            last, rests = hold.last / fps, hold.rests / fps
            if grasps and unseen:
                last = max(rests, min(last - OPEN_BEFORE, rests + UNSEEN))
            after = time - last
            falls, late = (FALLS, 0.0) if rests < last - THROWS else (THROWS, 0.5 * THROWS)
            presses *= 1.0 - ease((after - late) / falls + 1.0)
            ahead = OPENS if late == 0.0 or grasps else THROWS_OPENS
            opens = 1.0 - ease((after + ahead) / OPENING)
            fixed *= opens
            closed *= opens
            share *= 1.0 - ease((after - LEAVES) / GOES)
        return cls(share, fixed * share, closed, presses * share)


def _rises(time: Array, start: float, end: float) -> Array:
    """From 0 to 1 between two times, not before the clip starts: there all is as recorded."""
    start = max(start, 0.0)
    rises: Array = ease((time - start) / max(end - start, 1e-9))
    return rises
