"""Range violations: joints beyond what a person can do, and beyond what the reference asks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base.short_repr import short_repr
from halfphysics.body.joint_ranges import JointRanges
from halfphysics.metrics.argument_checks import Array, check_result
from halfphysics.metrics.asked import asked_motion
from halfphysics.motion.skeleton import JOINT_NAMES

if TYPE_CHECKING:
    from halfphysics.results.result import Result

#: An angle beyond its range by more than this is a violation [deg].
TOLERANCE = 2.0


@dataclass(frozen=True, kw_only=True, eq=False)
class RangeReport:
    """Joints beyond their ranges over T frames.

    Attributes:
        percent: Share of the frames in which a joint is beyond its range by over 2 degrees [%].
        max_deg: Largest angle beyond a range [deg].
        joint, frame: Where that is; "" and -1 where it is 0.
        asked_deg: Largest angle by which the reference itself is beyond the ranges [deg].
        beyond: Largest angle of each joint beyond its range (T, 55) [deg].
    """

    percent: float
    max_deg: float
    joint: str
    frame: int
    asked_deg: float
    beyond: Array

    __repr__ = short_repr


def range_violations(result: Result, person: int = 0) -> RangeReport:
    """How far joints are beyond their anatomical ranges, by axis.

    Ranges are those of `halfphysics.body.joint_ranges`, of twist, flexion and abduction, widened in
    every frame to what the reference has there.

    Raises:
        InputError: No result, or no such person.
        FileError: In a result from a file: the body has gone.
    """
    check_result(result)
    result._check_person(person)
    subject = result.people[person]
    ranges = JointRanges.of(subject.body)
    asked, got = asked_motion(subject).rotations, subject.motion.rotations
    beyond = np.rad2deg(ranges.excess(got, asked).max(axis=-1))
    still = ranges.angles(asked)
    own = np.maximum(np.maximum(ranges.lower - still, still - ranges.upper), 0.0)
    frame, joint = np.unravel_index(beyond.argmax(), beyond.shape)
    most = float(beyond[frame, joint])
    beyond.setflags(write=False)
    return RangeReport(
        percent=float(100.0 * (beyond > TOLERANCE).any(axis=1).mean()),
        max_deg=most,
        joint=JOINT_NAMES[joint] if most > 0.0 else "",
        frame=int(frame) if most > 0.0 else -1,
        asked_deg=float(np.rad2deg(own.max())),
        beyond=beyond,
    )
