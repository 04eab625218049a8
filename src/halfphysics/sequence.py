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
        motion: What the person wants to do; a tuple where there are several people.
        scene: What stands and lies around, objects as they are at the first frame.
        body: The person's body, a tuple of one each where there are several people; None where
            the source names none.
        settings: How to simulate it.
    """

    motion: Motion | tuple[Motion, ...]
    scene: Scene
    body: Body | tuple[Body, ...] | None = None
    settings: Settings = field(default_factory=Settings)

    @property
    def motions(self) -> tuple[Motion, ...]:
        """What each person wants to do, also where there is only one."""
        return (self.motion,) if isinstance(self.motion, Motion) else self.motion

    @property
    def bodies(self) -> tuple[Body | None, ...]:
        """Of each person the body, as `motions`; None where the source names none."""
        if isinstance(self.body, tuple):
            return self.body
        return (self.body,) * len(self.motions)
