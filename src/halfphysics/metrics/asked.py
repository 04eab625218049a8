"""What was asked of a person in every frame: what was recorded, at the time their clock shows.

The rule of all measures: they compare with what was asked for, `PersonResult.recorded`. Where
hands were adapted to what they hold, the `reference` that physics follows differs from it, and only
what is said of following compares with that one.
"""

from __future__ import annotations

import numpy as np

from halfphysics.motion.motion import Motion
from halfphysics.motion.resampling import interpolated
from halfphysics.results.result import PersonResult


def asked_motion(person: PersonResult) -> Motion:
    """What was recorded of a person of a result, at the times of `PersonResult.clock` (T frames).

    A person who never waited gets the recorded motion itself.
    """
    recorded, clock = person.recorded, getattr(person, "clock", None)
    if clock is None:
        return recorded
    position = np.clip(np.asarray(clock) * recorded.fps, 0.0, len(recorded) - 1.0)
    if np.abs(position - np.arange(len(recorded))).max() < 1e-6:
        return recorded
    moved, turned = interpolated(recorded.translation, recorded.rotations, position)
    return recorded.with_frames(moved, turned)
