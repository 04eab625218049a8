"""Unsupported weight: what of a person's weight nothing carries, though they are not in a jump."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.short_repr import short_repr
from halfphysics.metrics.airborne import airborne, free_fall
from halfphysics.metrics.argument_checks import Array, check_result
from halfphysics.metrics.asked import asked_motion
from halfphysics.support.support import UNSUPPORTED

if TYPE_CHECKING:
    from halfphysics.results.result import Result


@dataclass(frozen=True, kw_only=True, eq=False)
class UnsupportedReport:
    """Weight that nothing carries over T frames.

    Attributes:
        percent: Share of the frames that are not airborne in the reference in which over 5 % of
            the weight is carried by nothing [%].
        weight_percent: Mean over these frames of the share of the weight that nothing carries [%].
        missing: Upward force that nothing supplies (T,) [% of the weight], at least 0
            (`Support.residual_percent`); 0 without gravity.
        unsupported: Frames in which a person is held up by nothing (T,).
    """

    percent: float
    weight_percent: float
    missing: Array
    unsupported: NDArray[np.bool_]

    __repr__ = short_repr


def unsupported_weight(result: Result, person: int = 0) -> UnsupportedReport:
    """How much of a person's weight is carried by nothing (`PersonResult.support`).

    A frame counts unless the *reference* is airborne in it (`halfphysics.metrics.airborne`): a
    person who falls freely needs no support, whatever the reference does.

    Raises:
        InputError: No result, no such person, or a result without its surroundings.
        FileError: In a result from a file: the body or a mesh of the scene has gone.
    """
    check_result(result)
    result._check_person(person)
    subject = result.people[person]
    missing = np.maximum(np.nan_to_num(subject.support.residual_percent), 0.0)
    in_air = airborne(asked_motion(subject), subject.body, free_fall(result.scene))
    return unsupported_from(missing, in_air)


def unsupported_from(missing: Array, in_air: NDArray[np.bool_]) -> UnsupportedReport:
    """The report of missing shares (T,) [%] and of the reference's airborne frames (T,)."""
    counts = ~in_air
    unsupported = counts & (missing > 100.0 * UNSUPPORTED)
    for array in (missing, unsupported):
        array.setflags(write=False)
    number = max(int(counts.sum()), 1)
    return UnsupportedReport(
        percent=100.0 * float(unsupported.sum()) / number,
        weight_percent=float(missing[counts].sum()) / number,
        missing=missing,
        unsupported=unsupported,
    )
