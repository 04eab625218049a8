"""How clips are read, and in which body and scene they are judged."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from halfphysics.formats.loading import MotionOptions, betas_for, furnished, model_for

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene


class Reading(Hashable, Protocol):
    """What every process knows of all clips; equal ones read the same scene."""

    @property
    def motion_file(self) -> MotionOptions:
        """What motion files cannot say."""

    def body(self, own: Body | None, motion: Motion) -> Body:
        """The body of a motion, in place of that of its file."""

    def scene(self) -> Scene | None:
        """The scene of all clips; None: of a result its own, of a motion none."""


@dataclass(frozen=True, kw_only=True)
class Files:
    """Reading by the paths of a scene file and of a body model, or a folder of models."""

    scene_file: Path | None = None
    body_model: Path | None = None
    motion_file: MotionOptions = field(default_factory=MotionOptions)

    def body(self, own: Body | None, motion: Motion) -> Body:
        """The model's with the motion's betas; without a model the file's own, or the default."""
        from halfphysics.body.body import Body

        if self.body_model is None:
            return Body.default() if own is None else own
        space = model_for(motion, self.body_model)
        return Body.shaped(space, betas_for(motion, space))

    def scene(self) -> Scene | None:
        """The file's scene, with a floor where it has none."""
        if self.scene_file is None:
            return None
        return furnished(None, self.scene_file, (), (), ground=True)
