"""Penetration over several sequences, as one row of a table."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from halfphysics.base.validation import shown
from halfphysics.errors import InputError
from halfphysics.metrics.penetration import PenetrationReport


@dataclass(frozen=True, kw_only=True)
class PenetrationSummary:
    """Penetration of several sequences.

    Attributes:
        sequences: Number of sequences.
        frames: Number of all their frames.
        rate_percent: Mean over all frames of the share of vertices inside [%].
        depth_mean_mm: Mean over all frames of the deepest vertex [mm].
        depth_max_mm: Mean over sequences of the sequence's deepest vertex [mm].
        depth_penetrating_mm: Mean depth over all vertices that are inside, of all frames, 0 if
            none [mm].
        worst_mm: Deepest vertex of all [mm].
    """

    sequences: int
    frames: int
    rate_percent: float
    depth_mean_mm: float
    depth_max_mm: float
    depth_penetrating_mm: float
    worst_mm: float


def over_sequences(reports: Iterable[PenetrationReport]) -> PenetrationSummary:
    """Penetration of several sequences as one row: the measures of the paper's Table 2.

    Every frame counts the same in `rate_percent` and `depth_mean_mm`, every sequence the same in
    `depth_max_mm`, every vertex inside the same in `depth_penetrating_mm`.

    Raises:
        InputError: No reports, or something else among them.
    """
    found = list(reports) if isinstance(reports, Iterable) else [reports]
    for report in found:
        if not isinstance(report, PenetrationReport):
            raise InputError(
                f"reports: expected those of halfphysics.metrics.penetration, found {shown(report)}"
            )
    if not found:
        raise InputError("reports: found none, expected at least one")
    # Sum of depths over vertices inside, and their number; shares refer to each body's vertices.
    inside = np.array([r.vertices_inside for r in found], dtype=np.float64)
    depth = np.array([r.depth_penetrating_mm for r in found])
    return PenetrationSummary(
        sequences=len(found),
        frames=sum(len(r.share) for r in found),
        rate_percent=float(np.concatenate([r.share for r in found]).mean()),
        depth_mean_mm=float(np.concatenate([r.deepest for r in found]).mean()),
        depth_max_mm=float(np.mean([r.depth_max_mm for r in found])),
        depth_penetrating_mm=float(inside @ depth / inside.sum()) if inside.any() else 0.0,
        worst_mm=max(r.depth_max_mm for r in found),
    )
