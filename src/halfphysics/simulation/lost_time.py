"""Time that was lost where a motion was blocked for good: no room was left."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.errors import HalfPhysicsWarning

if TYPE_CHECKING:
    from halfphysics.results.result import Result

#: Lost time from which on there is a warning [s]; `Result.lost_time` has every loss.
WARN_FROM = 0.05
#: The warning lists at most so many names.
_NAMED = 5


def warn_of_lost_time(result: Result, stacklevel: int) -> None:
    """One warning that says when time was lost, how much, and between which names."""
    lost = result.lost_time
    if lost.sum() < WARN_FROM:
        return
    frames = np.flatnonzero(lost)
    contacts = result.contacts
    rows = np.isin(contacts.frame, frames)
    pressed = np.bincount(
        contacts.other[rows],
        np.linalg.norm(contacts.impulse[rows], axis=1),
        minlength=len(result.names),
    )
    order = [i for i in np.argsort(-pressed, kind="stable") if pressed[i] > 0]
    between = ", ".join(repr(result.names[i]) for i in order[:_NAMED])
    more = f" and {len(order) - _NAMED} more" if len(order) > _NAMED else ""
    first, last = frames[0] / result.fps, frames[-1] / result.fps
    warnings.warn(
        f"no room from {first:.2f} to {last:.2f} s (frames {frames[0]} to {frames[-1]}): the "
        f"reference could not be followed, and {lost.sum():.2g} s were lost"
        + (f" against {between}{more}" if between else "")
        + ". Kinematic objects wait there and are late from then on; leave more room, or see "
        "Result.lost_time for the frames",
        HalfPhysicsWarning,
        stacklevel=stacklevel + 1,
    )
