"""The table of measures that `demo` and `evaluate` print."""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfphysics import metrics
from halfphysics.cli.table import table

if TYPE_CHECKING:
    from halfphysics.body import Body
    from halfphysics.metrics import PenetrationReport
    from halfphysics.motion import Motion
    from halfphysics.result import Result
    from halfphysics.scene import Scene


def of_result(result: Result, person: int, *, progress: bool) -> str:
    """The skin in the scene before and after, for one person of a result; the rest of it is said
    by `Result.summary`.
    """
    who = result.people[person]
    before, after = (
        metrics.penetration(
            motion, who.body, result.scene, threads=result.settings.threads, progress=progress
        )
        for motion in (who.reference, who.motion)
    )
    return table([("", "asked", "simulated"), *_penetration(before, after)])


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
