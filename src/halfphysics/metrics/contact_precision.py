"""Contact precision: the share of labelled contacts that the geometry confirms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base.short_repr import short_repr
from halfphysics.base.validation import number
from halfphysics.metrics.argument_checks import Array, check_result
from halfphysics.metrics.part_distance import Poses
from halfphysics.metrics.scene_solids import known_contacts

if TYPE_CHECKING:
    from halfphysics.results.result import Result

#: A part touches an item up to this distance beyond the clearance [m].
MARGIN = 1e-3


@dataclass(frozen=True, kw_only=True, eq=False)
class LabelReport:
    """Contact labels of a result that the geometry confirms.

    Attributes:
        contacts: Number of labelled contacts that carry an impulse; those with an item that a
            result's file could not keep, whose shape is not known, are left out.
        precision_percent: Share of them whose sides are within clearance + margin of each other
            at their frame, or at a pose on the way to it [%]; 100 where there are none.
        at_frame_percent: Share of them for which that holds at the pose of their frame itself [%]:
            after a bounce the sides are apart again.
        distance: Minimum distance of the two sides of every row of ``result.contacts`` (n,) on the
            way to its frame [m]; 0 or less if they overlap, inf beyond 0.1 m, nan where a row does
            not count.
    """

    contacts: int
    precision_percent: float
    at_frame_percent: float
    distance: Array

    __repr__ = short_repr


def contact_precision(result: Result, *, margin: float = MARGIN) -> LabelReport:
    """Share of the labelled contacts, ``result.contacts``, that the geometry confirms.

    A label says that two sides touched during (t-1, t]: a person's part or an object, and a
    static, an object, a link or another part. The measure is the distance of their collision
    geometry: hulls of the skin (of the rigid parts with ``contact="parts"``), an object's convex
    pieces, a static's own surface, of soft things the surface that nothing presses; at frames
    t-1 and t, and at every substep between them if the result has them. A label is confirmed
    if the distance is at most the clearance (`Settings.clearance`) plus `margin`.

    Args:
        result: The result of a simulation.
        margin: Tolerance beyond the clearance [m].

    Raises:
        InputError: No result, or an impossible margin.
        FileError: In a result from a file: a body or the scene has gone.
    """
    check_result(result)
    most = result.settings.clearance + number(margin, "margin", least=0.0, unit="m")
    contacts = result.contacts
    rows = np.flatnonzero((contacts.strength > 0.0) & known_contacts(result))
    frame = contacts.frame[rows]
    poses = Poses(result, [p.motion for p in result.people], result.objects)
    best = poses.distances(rows, frame)
    at_frame = best <= most

    def closer(poses: Poses, count: int) -> None:
        """Include `count` earlier poses per frame, until all labels are confirmed."""
        for back in range(1, count + 1):
            apart = np.flatnonzero((best > most) & (frame > 0))
            if not len(apart):
                return
            at = frame[apart] * count - back
            best[apart] = np.minimum(best[apart], poses.distances(rows[apart], at))

    count = result.settings.substeps_for(1.0 / result.fps)
    if result.substeps is None:
        closer(poses, 1)
    else:
        closer(Poses(result, result.substeps.motions, result.substeps.objects), count)
    distance = np.full(len(contacts), np.nan)
    distance[rows] = best
    distance.setflags(write=False)
    return LabelReport(
        contacts=len(rows),
        precision_percent=float(100.0 * (best <= most).mean()) if len(rows) else 100.0,
        at_frame_percent=float(100.0 * at_frame.mean()) if len(rows) else 100.0,
        distance=distance,
    )
