"""Poses that are set and not driven: which modes those are, and what does not go with them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfphysics.errors import InputError
from halfphysics.validation import frame_rate

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from halfphysics.motion import Motion
    from halfphysics.settings import Settings

#: Modes in which the person's pose is the reference's, and how the core calls them.
FORCED = {"kinematic": 1, "positions": 2, "interpolated": 3}


def check_forced(settings: Settings) -> None:
    """Refuse what says nothing where poses are set.

    Raises:
        InputError: A return to the reference, contact with oneself, a limit of strength or forces
            on joints, with a mode of `FORCED`.
    """
    if settings.mode not in FORCED:
        return
    refused = {
        "root": ("stay", "nobody leaves the reference"),
        "self_contact": (False, "nobody gives way"),
        "strength": (None, "nothing is exerted"),
        "internal_forces": (False, "no force acts on the person"),
        "joint_damping": (0.0, "no force acts on the person"),
    }
    for name, (only, why) in refused.items():
        if getattr(settings, name) != only:
            raise InputError(
                f"Settings.{name} is {getattr(settings, name)!r} with mode={settings.mode!r}, "
                f"which sets the person's pose: {why}; expected {only!r}, or mode='velocity'"
            )


def recorded(
    motion: Motion, translation: NDArray[np.float64], rotations: NDArray[np.float64], fps: float
) -> Motion:
    """A motion's poses in all substeps, `fps` a second: those that are set may jump."""
    poses = motion.with_frames(translation, rotations, fps=1.0)
    object.__setattr__(poses, "fps", frame_rate(fps))
    return poses
