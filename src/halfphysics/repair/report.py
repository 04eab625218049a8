"""What a repair changed, in numbers: each measure before and after."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.metrics.floating import physdiff
from halfphysics.metrics.joint_errors import mpjpe, mpjpe_global
from halfphysics.metrics.smoothness import jerk
from halfphysics.repair.insides import insides

if TYPE_CHECKING:
    from halfphysics.repair.repair import Repair

# Fewer frames have no jerk, and no step in which a foot could slide.
_LEAST = 4


@dataclass(frozen=True)
class Measure:
    """One number before and after; several people: the mean over them."""

    name: str
    before: float
    after: float
    unit: str


def measures(repair: Repair) -> tuple[Measure, ...]:
    """The measures of a repair.

    PhysDiff's four (`metrics.physdiff`) are of level ground at z = 0 and left out where a scene was
    given; then the depth in the scene counts, its objects and other people included. Changes are
    those from the clip as it came.
    """
    people = list(
        zip(repair.originals, repair.motions, (p.body for p in repair.result.people), strict=True)
    )
    found = []
    if repair.level_floor and len(repair.motion) >= _LEAST:
        before, after = ([physdiff(pair[k], pair[2]) for pair in people] for k in (0, 1))
        for name, field, unit in (
            ("Penetrate", "penetrate_mm", "mm"),
            ("Float", "float_mm", "mm"),
            ("Skate", "skate_mm", "mm/frame"),
            ("Phys-Err", "phys_err_mm", "mm"),
        ):
            found.append(Measure(name, _mean(before, field), _mean(after, field), unit))
    deepest = [
        max(report.depth_max_mm for report in insides(motions, repair.result))
        for motions in (repair.originals, repair.motions)
    ]
    found.append(Measure("deepest in the scene", deepest[0], deepest[1], "mm"))
    if len(repair.motion) >= _LEAST:
        rough = [float(np.mean([jerk(pair[k], pair[2]) for pair in people])) for k in (0, 1)]
        found.append(Measure("jerk", rough[0], rough[1], "m/s^3"))
    moved = float(np.mean([mpjpe_global(b, a, body) for a, b, body in people]))
    posed = float(np.mean([mpjpe(b, a, body) for a, b, body in people]))
    found.append(Measure("joints moved", 0.0, moved, "mm"))
    found.append(Measure("joints moved, of the pelvis", 0.0, posed, "mm"))
    return tuple(found)


def _mean(reports: list[Any], field: str) -> float:
    return float(np.mean([getattr(report, field) for report in reports]))
