"""Sequence: a motion together with all that is needed to simulate it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from halfphysics.base.in_notebook import InNotebook
from halfphysics.base.short_repr import short_repr
from halfphysics.motion.motion import Motion
from halfphysics.results.moment import Figure, Moment, at_start
from halfphysics.results.overview import scene_lines
from halfphysics.settings import Settings

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.results.result import ObjectTrack
    from halfphysics.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class Sequence(InNotebook):
    """What `simulate` takes, in one piece: from a data set or from `halfphysics.scenarios`.

    Attributes:
        motion: What the person wants to do; a tuple where there are several people.
        scene: What stands and lies around, objects as they are at the first frame.
        body: The person's body, a tuple of one each where there are several people; None where
            the source names none.
        settings: How to simulate it.
        recorded: Name of an object -> how it moved in the data set, frame by frame of the motion;
            empty where nothing was recorded.
    """

    motion: Motion | tuple[Motion, ...]
    scene: Scene
    body: Body | tuple[Body, ...] | None = None
    settings: Settings = field(default_factory=Settings)
    recorded: Mapping[str, ObjectTrack] = field(default_factory=dict)

    __repr__ = short_repr

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

    def _notebook_moment(self) -> Moment:
        from halfphysics.body.body import Body

        people = tuple(
            Figure(Body.default() if body is None else body, motion)
            for motion, body in zip(self.motions, self.bodies, strict=True)
        )
        return Moment(people=people, scene=self.scene, objects=at_start(self.scene))

    def _notebook_lines(self) -> list[str]:
        return [*(repr(motion) for motion in self.motions), *scene_lines(self.scene)]

    def adapted(self, *, grip: bool = True) -> Sequence:
        """The sequence with every person's hands at what they hold (`halfphysics.adapt`).

        What a motion was recorded as is adapted anew, to the body and the settings that are here:
        `load_sequence` does it for those of the data set, after another body
        (`dataclasses.replace(sequence, body=mine).adapted()`) it is due again.

        Args:
            grip: Hands press with what the load needs. False: they touch.

        Returns:
            A new sequence, with `Motion.holds` and `Motion.recorded`; this one where nothing is
            held.
        """
        from halfphysics.adaptation.adapt import adapt

        people = [(m.recorded or m, b) for m, b in zip(self.motions, self.bodies, strict=True)]
        found = tuple(
            adapt(
                motion, self.scene, body, self.recorded, settings=self.settings, grip=grip,
                others=people[:k] + people[k + 1 :],
            ).motion
            for k, (motion, body) in enumerate(zip(self.motions, self.bodies, strict=True))
        )  # fmt: skip
        if all(a is b for a, b in zip(found, self.motions, strict=True)):
            return self
        return replace(self, motion=found[0] if isinstance(self.motion, Motion) else found)
