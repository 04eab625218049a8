"""The table of measures that `demo` and `evaluate` print."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halfphysics import metrics
from halfphysics.cli.table import table

if TYPE_CHECKING:
    from halfphysics.body import Body
    from halfphysics.metrics import PenetrationReport
    from halfphysics.motion import Motion
    from halfphysics.result import Result
    from halfphysics.scene import Scene

_NONE = "-"


def of_result(result: Result, person: int, *, progress: bool) -> str:
    """Before and after, for one person of a result."""
    who = result.people[person]
    before, after = (
        metrics.penetration(
            motion, who.body, result.scene, threads=result.settings.threads, progress=progress
        )
        for motion in (who.reference, who.motion)
    )
    local, everywhere = who.joint_errors()
    free = result.free_frames(person)
    rows = [
        ("", "asked", "simulated"),
        *_penetration(before, after),
        (f"MPJPE in the {int(free.sum())} free frames [mm]", _NONE, _mean_mm(local[free])),
        ("MPJPE [mm]", _NONE, _mean_mm(local)),
        ("MPJPE-g [mm]", _NONE, _mean_mm(everywhere)),
    ]
    nearest = float(result.clearance.min())
    shown = f"{1000.0 * nearest:.3f}" if np.isfinite(nearest) else "beyond reach"
    rows.append(("nearest rigid part to what stands [mm]", _NONE, shown))
    return table(rows)


def of_motion(
    motion: Motion,
    body: Body,
    scene: Scene | None,
    reference: Motion | None,
    *,
    progress: bool,
) -> str:
    """Of a motion alone: penetration of a scene, distance from a reference, where given."""
    rows = [("", "motion")]
    if scene is not None:
        report = metrics.penetration(motion, body, scene, progress=progress)
        rows += [(row[0], row[1]) for row in _penetration(report, report)]
    if reference is not None:
        rows.append(("MPJPE [mm]", f"{metrics.mpjpe(motion, reference, body):.6f}"))
        rows.append(("MPJPE-g [mm]", f"{metrics.mpjpe_global(motion, reference, body):.6f}"))
    return table(rows)


def _penetration(before: PenetrationReport, after: PenetrationReport) -> list[tuple[str, str, str]]:
    return [
        ("skin vertices inside [%]", f"{before.rate_percent:.3f}", f"{after.rate_percent:.3f}"),
        (
            "deepest, mean over frames [mm]",
            f"{before.depth_mean_mm:.2f}",
            f"{after.depth_mean_mm:.2f}",
        ),
        ("deepest of all [mm]", f"{before.depth_max_mm:.2f}", f"{after.depth_max_mm:.2f}"),
    ]


def _mean_mm(errors: np.ndarray) -> str:
    return f"{1000.0 * errors.mean():.6f}" if errors.size else _NONE
