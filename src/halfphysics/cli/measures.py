"""The table of measures that `demo` and `evaluate` print."""

from __future__ import annotations

from typing import TYPE_CHECKING

from halfphysics import metrics
from halfphysics.cli.table import table
from halfphysics.metrics.asked import asked_motion
from halfphysics.metrics.scene_solids import known_tracks

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.metrics import PenetrationReport
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result
    from halfphysics.scene.scene import Scene


def of_result(result: Result, person: int, *, progress: bool) -> str:
    """Penetration of one person's skin into the scene and other people, recorded and simulated;
    `Result.summary` gives the other measures.
    """
    subject, others = result.people[person], {p.name: p for p in result.people}
    del others[subject.name]

    def measured(what: str) -> PenetrationReport:
        return metrics.penetration(
            getattr(subject, what),
            subject.body,
            result.scene,
            people={name: (getattr(other, what), other.body) for name, other in others.items()},
            threads=result.settings.threads,
            progress=progress,
        )

    before, after = measured("recorded"), measured("motion")
    rows: list[tuple[str, ...]] = [*_penetration(before, after)]
    if others:
        asked, got = (max(r.by_name[name].max() for name in others) for r in (before, after))
        rows.append(("deepest in other people [mm]", f"{asked:.2f}", f"{got:.2f}"))
    motions = subject.recorded, subject.motion
    if len(subject.motion) >= 4:
        jerks = (metrics.jerk(m, subject.body) for m in motions)
        rows.append(("jerk [m/s3]", *(f"{jerk:.1f}" for jerk in jerks)))
    skates = (metrics.foot_skate(m, subject.body) for m in motions)
    rows.append(("foot skate [mm/frame]", *(f"{skate.mean_mm:.2f}" for skate in skates)))
    rows += _standing(result, person)
    labels, forces = metrics.contact_precision(result), metrics.contact_forces(result)
    if labels.contacts:
        rows.append(("contact precision [%]", "", f"{labels.precision_percent:.2f}"))
        rows.append(("contact forces in friction cones [%]", "", f"{forces.cone_percent:.2f}"))
    return table([("", "reference", "simulated"), *rows])


def of_motion(
    motion: Motion,
    body: Body,
    scene: Scene | None,
    reference: Motion | None,
    *,
    progress: bool,
) -> str:
    """Measures of a motion alone: penetration of a scene, distance from a reference, if given."""
    rows = [("", "motion")]
    if scene is not None:
        report = metrics.penetration(motion, body, scene, progress=progress)
        rows += [(row[0], row[1]) for row in _penetration(report, report)]
    if reference is not None:
        rows.append(("MPJPE [mm]", f"{metrics.mpjpe(motion, reference, body):.6f}"))
        rows.append(("MPJPE-g [mm]", f"{metrics.mpjpe_global(motion, reference, body):.6f}"))
    return table(rows)


def _standing(result: Result, person: int) -> list[tuple[str, str, str]]:
    """Floating, slide in stance, net force and the way back to the path."""
    subject = result.people[person]
    reference = asked_motion(subject)
    floats = [
        metrics.floating(
            motion,
            subject.body,
            result.scene,
            objects=known_tracks(result.scene, result.objects),
            reference=reference,
        )
        for motion in (reference, subject.motion)
    ]
    asked, got = (metrics.physdiff(m, subject.body) for m in (reference, subject.motion))
    stance, force = metrics.stance_slide(result, person), metrics.net_force(result, person)
    path, weight = (
        metrics.path_offset(result, person),
        metrics.unsupported_weight(result, person),
    )
    ranges = metrics.range_violations(result, person)

    def said(value: float | None, digits: int) -> str:
        return "" if value is None else f"{round(value, digits) + 0.0:.{digits}f}"

    def row(name: str, before: float | None, after: float, digits: int = 2) -> tuple[str, str, str]:
        return name, said(before, digits), said(after, digits)

    return [
        row("floating [% of frames]", floats[0].percent, floats[1].percent, 1),
        row("floating [mm]", floats[0].mean_mm, floats[1].mean_mm),
        row("Phys-Err of PhysDiff, level ground [mm]", asked.phys_err_mm, got.phys_err_mm),
        row("slide in stance, mean [mm/frame]", stance.asked.mean_mm, stance.simulated.mean_mm),
        row("slide in stance, largest [mm/frame]", stance.asked.max_mm, stance.simulated.max_mm),
        row("unsupported weight [% of frames]", None, weight.percent, 1),
        row("beyond joint ranges and reference [deg]", None, ranges.max_deg, 1),
        row("net force, peak [body weights]", None, force.peak_weights),
        row("net force held for 50 ms [body weights]", None, force.sustained_weights),
        row("off the path at the end [mm]", None, path.end_offset_mm, 1),
        row("above the path at the end [mm]", None, path.end_height_mm, 1),
        row("tilted at the end [deg]", None, path.end_tilt_deg),
    ]


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
