"""Offset and tilt from the path over time: where a person is, and how upright, by the reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.base.short_repr import short_repr
from halfphysics.metrics.argument_checks import Array, check_result
from halfphysics.metrics.asked import asked_motion

if TYPE_CHECKING:
    from halfphysics.results.result import PersonResult, Result


@dataclass(frozen=True, kw_only=True, eq=False)
class PathReport:
    """Deviation of a person's pelvis from the reference over T frames, and in the last one.

    Attributes:
        offset: Horizontal distance (T,) [m].
        height: Height above that of the reference (T,) [m].
        tilt: Angle by which the deviation turns the vertical (T,) [rad].
        heading: Angle by which it turns about the vertical (T,) [rad], with a sign.
        max_offset_mm, max_height_mm, max_tilt_deg: Largest sizes.
        end_offset_mm, end_height_mm, end_tilt_deg, end_heading_deg: In the last frame.
    """

    offset: Array
    height: Array
    tilt: Array
    heading: Array
    max_offset_mm: float
    max_height_mm: float
    max_tilt_deg: float
    end_offset_mm: float
    end_height_mm: float
    end_tilt_deg: float
    end_heading_deg: float

    __repr__ = short_repr


def path_offset(result: Result, person: int = 0) -> PathReport:
    """How far a person is from the path, how much higher, how tilted and how turned, over time.

    The pelvis' rotation is R = D R_ref in the world. D is a turn about the vertical (the heading)
    after a turn about a horizontal axis (the tilt).

    Raises:
        InputError: No result, or no such person.
    """
    check_result(result)
    result._check_person(person)
    return path_of(result.people[person])


def path_of(person: PersonResult) -> PathReport:
    """`path_offset` of one person of a result."""
    motion, reference = person.motion, asked_motion(person)
    shift = motion.translation - reference.translation
    turns = [rot.exp(m.rotations[:, 0]) for m in (motion, reference)]
    w, x, y, z = np.moveaxis(rot.multiply(turns[0], rot.conjugate(turns[1])), -1, 0)
    tilt = 2.0 * np.arctan2(np.hypot(x, y), np.hypot(w, z))
    heading = 2.0 * np.arctan2(z, w)
    heading = (heading + np.pi) % (2.0 * np.pi) - np.pi
    offset, height = np.linalg.norm(shift[:, :2], axis=1), shift[:, 2].copy()
    for array in (offset, height, tilt, heading):
        array.setflags(write=False)
    return PathReport(
        offset=offset,
        height=height,
        tilt=tilt,
        heading=heading,
        max_offset_mm=float(1000.0 * offset.max()),
        max_height_mm=float(1000.0 * np.abs(height).max()),
        max_tilt_deg=float(np.rad2deg(tilt.max())),
        end_offset_mm=float(1000.0 * offset[-1]),
        end_height_mm=float(1000.0 * height[-1]),
        end_tilt_deg=float(np.rad2deg(tilt[-1])),
        end_heading_deg=float(np.rad2deg(heading[-1])),
    )
