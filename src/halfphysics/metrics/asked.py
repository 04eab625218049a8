"""What was asked of a person in every frame: the reference, at the time its clock shows."""

from __future__ import annotations

import numpy as np

from halfphysics.motion.motion import Motion
from halfphysics.motion.resampling import interpolated
from halfphysics.results.result import PersonResult


def asked_motion(person: PersonResult) -> Motion:
    """The reference of a person of a result at the times of `PersonResult.clock` (T frames).

    A person who never waited gets the reference itself.
    """
    reference, clock = person.reference, getattr(person, "clock", None)
    if clock is None:
        return reference
    position = np.clip(np.asarray(clock) * reference.fps, 0.0, len(reference) - 1.0)
    if np.abs(position - np.arange(len(reference))).max() < 1e-6:
        return reference
    moved, turned = interpolated(reference.translation, reference.rotations, position)
    return reference.with_frames(moved, turned)
