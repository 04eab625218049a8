"""In which unit a file's translations are, and whether its angles are radians, by content.

A body has its size, and so the legs say what a metre is. With p(t) the root and f(t) a foot from
the root, a planted foot stays where it is: while it does not turn, ``p + s f`` is constant, and s
is the number of the file's units in a metre: 1, 100 or 1000. Who stands still says it by the height
of the root above a floor at zero.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.reader_warnings import warn
from halfphysics.formats.glance import Glance, glance
from halfphysics.motion.possible import SUSPICIOUS, are_degrees

Array = NDArray[np.float64]

#: Metres per unit -> its name, and the units in a metre that feet may say: sizes of people differ,
#: and feet slide a little.
_UNITS = {0.01: ("centimetres", 40.0, 250.0), 0.001: ("millimetres", 400.0, 2500.0)}
#: Translations that stay below this are in metres [unit of the file]: a root in centimetres that is
#: at a person's height is not.
_METRES = 5.0
#: Feet say it if root and feet move together so well (a correlation), over a way of at least this
#: [m]. A foot that turns slower than this is planted [rad/s].
_TOGETHER, _WAY, PLANTED = 0.7, 0.1, 0.5
#: Who stands or sits has the root so far above the soles [m], and these at zero to within this [m],
#: not at a height of more than this in the file's unit.
_LEGS, _NEAR, _HIGH = 0.45, 0.2, 20.0


def unit_of(where: str, translation: Array, rotations: Array, fps: float, axes: Array) -> float:
    """Metres per unit of the translations: 1, or 0.01 or 0.001 where the content is clear.

    Args:
        where: Name of the file or clip in messages.
        translation, rotations: (T, 3) and axis-angle (T, 55, 3) [rad], turned to z up.
        fps: Frames per second.
        axes: World from file axes (3, 3).

    Warns:
        HalfPhysicsWarning: It is not 1.
    """
    if len(translation) < 2 or float(np.abs(translation).max(initial=0.0)) < _METRES:
        return 1.0
    seen = glance(translation, rotations, fps, axes)
    for unit, (name, low, high) in _UNITS.items():
        size = feet_say(seen)
        if size is not None:
            why, clear = "planted feet stay where they are only so", low < size < high
        else:
            why = "the person stands on z = 0 only so"
            clear = _stands(seen, translation, unit)
        if clear:
            warn(f"{where}: translations are in {name}: {why}. Read as such")
            return unit
    return 1.0


def feet_say(seen: Glance) -> float | None:
    """Units per metre of the root by planted feet; None: they say nothing."""
    planted = seen.turned < PLANTED
    feet = seen.feet[planted]
    root = np.repeat(seen.moved[:, None], 2, axis=1)[planted]
    square = float((feet * feet).sum())
    if float(np.abs(feet).sum()) < _WAY or square == 0.0:
        return None
    product = -float((feet * root).sum())
    if product < _TOGETHER * np.sqrt(square * float((root * root).sum())):
        return None
    return product / square


def _stands(seen: Glance, translation: Array, unit: float) -> bool:
    """Whether soles are at zero in this unit, and far above or below it in metres."""
    height = float(np.median(translation[:, 2]))
    low = float(np.median(seen.low))
    return low < -_LEGS and abs(height) > _HIGH and abs(low + unit * height) < _NEAR


def in_radians(where: str, rotations: Array) -> tuple[Array, bool]:
    """Rotations (T, 55, 3) in radians, and whether they are in doubt.

    Warns:
        HalfPhysicsWarning: They were in degrees, or may be.
    """
    largest = float(np.abs(rotations[:, 1:]).max(initial=0.0))
    if largest <= SUSPICIOUS:
        return rotations, False
    if are_degrees(rotations):
        warn(
            f"{where}: joints are turned by up to {largest:.0f}: rotations are in degrees, and "
            "read as such; expected radians"
        )
        return np.radians(rotations), False
    warn(
        f"{where}: a joint is turned by {largest:.0f} rad; expected axis-angle in radians. "
        "Are these degrees?"
    )
    return rotations, True
