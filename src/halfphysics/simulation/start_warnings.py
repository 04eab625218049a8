"""Warnings about the start of a run: what is inside what, and clips that begin in mid-air."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import HalfPhysicsWarning
from halfphysics.simulation.core_rows import Named, inside_rows
from halfphysics.simulation.floating_start import floating

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.simulation.world import World

Array = NDArray[np.float64]

#: A start that is deeper inside something than this is warned of [m].
START_INSIDE = 1e-3
#: The same in the world of another program: feet stand a little in floors [m].
HOSTED_START_INSIDE = 5e-3
_NAMED = 5  # this many of them are named
#: From `warnings.warn` to the line that called `simulate`: through `simulate` and `follow`.
_CALLER = 5


def warn_of_start(world: World, motions: Sequence[Motion], rows: Array) -> None:
    """Warn of what starts inside something, or, where all is clear, of starts in mid-air.

    Args:
        world: What is run.
        motions: One per person.
        rows: What is inside something at their first frame: the core's rows (n, 4).
    """
    if len(rows):
        _warn_of_inside(
            world,
            rows,
            "; nothing penetrates from clear starts only. Move the motion or the scene, "
            "or see motion.grounded(body) for feet in a floor",
            _CALLER,
            START_INSIDE,
        )
    else:
        _warn_of_floating(world, motions)


def warn_of_hosted_start(world: Named, rows: Array) -> None:
    """Warn of what starts inside another program's world; `rows` are those of the core (n, 4)."""
    _warn_of_inside(
        world,
        rows,
        ", with whatever force that takes where the world cannot give way. Reset to a pose that "
        "is clear of it",
        4,
        HOSTED_START_INSIDE,
    )


def _warn_of_inside(world: Named, rows: Array, meaning: str, caller: int, least: float) -> None:
    """One warning that names what starts deeper than `least` [m]; `caller`: its stacklevel."""
    inside = inside_rows(world, rows, np.zeros(len(rows), dtype=np.int64))
    worth = inside[(inside.depth > least) | inside.no_way_out]
    if not len(worth):
        return
    words = worth.described(world.names, len(world.people))
    more = f" and {len(words) - _NAMED} more" if len(words) > _NAMED else ""
    warnings.warn(
        f"the start is not clear: {', '.join(words[:_NAMED])}{more}. Initial overlaps are "
        f"resolved{meaning}",
        HalfPhysicsWarning,
        stacklevel=caller,
    )


def _warn_of_floating(world: World, motions: Sequence[Motion]) -> None:
    """One warning for each clip from a file whose first frame is in mid-air in this scene."""
    for person, motion in zip(world.people, motions, strict=True):
        found = None if motion.origin is None else floating(person.body, motion[0], world.made_of)
        if found is not None:
            warnings.warn(
                f"{person.name} starts {100.0 * found[0]:.0f} cm above {found[1]}, on nothing. "
                "Where the clip's floor is not the scene's: motion.grounded(body, z=...), or "
                "--grounded",
                HalfPhysicsWarning,
                stacklevel=_CALLER,
            )
