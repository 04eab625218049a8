"""People to write into a file of an estimator of people in video: the inverse of `estimates`."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
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

#: Numbers of people stay below this: files keep them in 32 bits.
_MOST = 2**31


@dataclass(frozen=True, eq=False)
class Written:
    """One person to write, in the axes of the file.

    Attributes:
        frames: Numbers (T,) of the frames, from the one in which the person was first seen.
        translation: (T, 3) [m].
        rotations: Axis-angle (T, 55, 3) [rad].
        rest: Joints (55, 3) at rest of the body that readers of the file take.
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
    motions: Listing[Motion], format: str, bodies: Listing[Body | None] = ()
) -> dict[str, Written]:
    """People by name: those of their file, else numbers; in metres, whatever their file had.

    The joints at rest are those that a file of this format was read with, else the person's own
    (`bodies`), else the default body's.
    """
    people: dict[str, Written] = {}
    for motion, body in itertools.zip_longest(motions, bodies):
        translation, rotations, fields = file_parameters(motion, format)
        name = own_name(str(fields.get("track", len(people))), people)
        frames = int(fields.get("first", 0)) + np.arange(len(motion))
        rest = np.asarray(fields.get("rest", (body or Body.default()).rest_joints))
        metres = fields.get("unit", 1.0) * translation
        people[name] = Written(frames, metres, rotations, rest, motion)
    return people


def numbers_of(people: Mapping[str, Written]) -> dict[str, int]:
    """A number for each person, by name: the name where it is one, and where no other has it."""
    own = {name: int(name) for name in people if name.isdecimal() and int(name) < _MOST}
    numbers: dict[str, int] = {}
    for name, number in own.items():
        if number not in numbers.values():
            numbers[name] = number
    free = (k for k in itertools.count(1) if k not in numbers.values())
    for name in people:
        if name not in numbers:
            numbers[name] = next(free)
    return {name: numbers[name] for name in people}


def lost_in(joints: Listing[int], model: str) -> Callable[[Motion], tuple[str, ...]]:
    """`Format.loses` of an estimator's files: these joints of this neutral model, ten betas."""

    def lost(motion: Motion) -> tuple[str, ...]:
        lines = [*lost_joints(motion, joints), *lost_model(motion, model)]
        lines += [*lost_gender(motion), *lost_betas(motion, 10), *lost_rate(motion, USUAL_FPS)]
        return tuple(lines)

    return lost
