"""Other people on the way: where they are going, and on which side to pass them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.actors.path import Path, Point

if TYPE_CHECKING:
    from halfphysics.actors.seen import Seen

Array = NDArray[np.float64]

# Someone who comes this near to the way makes one look for another way; so far one looks [m].
_NEAR, _FAR = 0.75, 3.4
# People are passed on the right: they are taken to be this far to the left of where they are [m].
_LEFT = 0.12
# When from now they are looked at [s]; time constant of their velocity [s].
_LATER = (0.0, 0.5, 1.0, 1.5)
_SMOOTH = 0.25


class Passersby:
    """What one person remembers of the others."""

    def __init__(self) -> None:
        self._known: dict[Any, tuple[Array, Array]] = {}

    def notice(self, dt: float, seen: Seen) -> None:
        """Look at them, `dt` [s] after the last time."""
        share = 1.0 - math.exp(-dt / _SMOOTH)
        known = {}
        for who, other in seen.others.items():
            at = other.pelvis[:2]
            last, velocity = self._known.get(who, (at, np.zeros(2)))
            known[who] = (at, velocity + share * ((at - last) / dt - velocity))
        self._known = known

    def in_the_way(self, path: Path, here: Point) -> bool:
        """Whether somebody is, or soon will be, on the way ahead."""
        if not self._known:
            return False
        start = path.nearest(*here)
        ahead = np.array([path.at(start + d) for d in np.arange(0.3, _FAR, 0.25)])
        return any(
            float(np.linalg.norm(ahead - (at + later * velocity), axis=1).min()) < _NEAR
            for at, velocity in self._known.values()
            if math.dist(at, here) < _FAR
            for later in _LATER
        )

    def places(self, here: Point) -> list[Array]:
        """Where they are taken to be, now and soon, by someone here: (x, y) each [m]."""
        out = []
        for at, velocity in self._known.values():
            way = at - np.array(here)
            far = float(np.hypot(*way))
            if far > 2.0 * _FAR:
                continue
            left = _LEFT / max(far, _LEFT) * np.array([-way[1], way[0]])
            out += [at + left + later * velocity for later in _LATER]
        return [place for place in out if math.dist(place, here) > 0.5]
