"""What a held thing weighs on the hands, and what two palms press with to bear it.

Weight and recorded acceleration; twice what friction needs for it, and for the turn of what hangs
beside the hands.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from halfphysics.adaptation.grips import Place
    from halfphysics.adaptation.recorded_holds import RecordedHold

Array = NDArray[np.float64]

#: Hands use no more than one part of so many of their friction.
MARGIN = 2.0
#: A hand that presses does so with at least and at most this [N].
LEAST, MOST = 25.0, 150.0
#: Radius at which a flat hand's friction holds against turning [m].
_PALM = 0.05
#: Accelerations of the recorded thing are taken over this time [s]: sensors shake.
_SMOOTH = 0.2


def load(hold: RecordedHold, fps: float, gravity: Array) -> Array:
    """What bears a held thing, weight and recorded acceleration (3,) [N], in the thing's frame.

    The largest while it is held, along its mean direction.

    Args:
        hold: What is held, and when.
        fps: Frame rate [1/s].
        gravity: (3,) [m/s^2].
    """
    during = slice(hold.first, hold.last + 1)
    turn, span = hold.thing.turn[during], max(1, round(_SMOOTH * fps))
    centre = hold.thing.centre[during]
    needed = np.tile(-gravity, (len(centre), 1))
    if len(centre) > 2 * span:
        second = centre[2 * span :] - 2.0 * centre[span:-span] + centre[: -2 * span]
        needed[span:-span] += second * (fps / span) ** 2
    along = np.einsum("tji,tj->ti", turn, needed).mean(axis=0)
    most = float(np.linalg.norm(needed, axis=1).max())
    result: Array = hold.thing.item.mass * most * along / max(float(np.linalg.norm(along)), 1e-9)
    return result


def between_palms(
    hold: RecordedHold, its: tuple[Place, ...], load: Array, friction: float
) -> float:
    """What each palm presses with against the other, so that friction bears the load [N].

    Args:
        hold: What is held, and when.
        its: Where the hands are.
        load: As `load` gives it (3,) [N].
        friction: Of hands on the thing.

    Returns:
        0 where no hand presses against another.
    """
    if not any(place.presses.any() for place in its):
        return 0.0
    size, rubs = float(np.linalg.norm(load)), len(its) * max(friction, 1e-3)
    # What hangs beside the line between the hands turns about it: the palms' friction holds that.
    lever = hold.thing.item.com - its[0].point
    lever = lever - (lever @ its[0].presses) * its[0].presses
    turn = hold.thing.turn[hold.first : hold.last + 1]
    up = np.einsum("tji,j->ti", turn, [0.0, 0.0, 1.0])
    beside = float(np.linalg.norm(lever - (up @ lever)[:, None] * up, axis=1).max())
    needed = max(size / rubs, size * beside / (rubs * _PALM))
    return float(np.clip(MARGIN * needed, LEAST, MOST))
