"""Sequence: a motion together with all that is needed to simulate it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from halfphysics.motion import Motion
from halfphysics.settings import Settings

if TYPE_CHECKING:
    from halfphysics.body import Body
    from halfphysics.scene import Scene


@dataclass(frozen=True, eq=False)
class Sequence:
    """What `simulate` takes, in one piece: from a data set or from `halfphysics.scenarios`.

    Attributes:
        motion: What the person wants to do.
        scene: What stands and lies around, objects as they are at the first frame.
        body: The person's body; None where the source names none.
        settings: How to simulate it.
    """

    motion: Motion
    scene: Scene
    body: Body | None = None
    settings: Settings = field(default_factory=Settings)
