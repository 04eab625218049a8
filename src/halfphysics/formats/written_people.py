"""People to write into a file of an estimator of people in video: the inverse of `estimates`."""

from __future__ import annotations

from collections.abc import Callable
from collections.abc import Sequence as Listing
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.body.body import Body
from halfphysics.formats.motion_builder import (
    USUAL_FPS,
    file_parameters,
    lost_betas,
    lost_gender,
    lost_joints,
    lost_model,
    lost_rate,
    own_name,
)
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Written:
    """One person to write, in the axes of the file.

    Attributes:
        frames: Numbers (T,) of the frames, from the one in which the person was first seen.
        translation: (T, 3) [m].
        rotations: Axis-angle (T, 55, 3) [rad].
        rest: Joints (55, 3) of the body at rest.
        motion: The motion that is written.
    """

    frames: NDArray[np.int64]
    translation: Array
    rotations: Array
    rest: Array
    motion: Motion

    def smpl(self) -> Array:
        """Axis-angle (T, 72) of SMPL's joints; its hands do not turn."""
        body = self.rotations[:, list(skeleton.SMPL_JOINTS)].reshape(len(self.frames), -1)
        return np.pad(body, ((0, 0), (0, 72 - body.shape[1])))

    def betas(self, count: int = 10) -> Array:
        """The shape (count,), zero where there is none."""
        out = np.zeros(count)
        own = self.motion.betas
        if own is not None:
            out[: len(own)] = own[:count]
        return out


def written(
    motions: Listing[Motion], bodies: Listing[Body | None], format: str
) -> dict[str, Written]:
    """People by name: those of their file, else numbers."""
    people: dict[str, Written] = {}
    for motion, body in zip(motions, bodies, strict=True):
        translation, rotations, fields = file_parameters(motion, format)
        name = own_name(str(fields.get("track", len(people))), people)
        frames = int(fields.get("first", 0)) + np.arange(len(motion))
        rest = np.asarray((body or Body.default()).rest_joints)
        people[name] = Written(frames, translation, rotations, rest, motion)
    return people


def lost_in(joints: Listing[int], model: str) -> Callable[[Motion], tuple[str, ...]]:
    """`Format.loses` of an estimator's files: these joints of this neutral model, ten betas."""

    def lost(motion: Motion) -> tuple[str, ...]:
        lines = [*lost_joints(motion, joints), *lost_model(motion, model)]
        lines += [*lost_gender(motion), *lost_betas(motion, 10), *lost_rate(motion, USUAL_FPS)]
        return tuple(lines)

    return lost
