"""All measures of a result as plain values, for JSON."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics import metrics
from halfphysics.metrics.asked import asked_motion
from halfphysics.metrics.scene_solids import known_tracks
from halfphysics.results.layer_pressure import pressures

if TYPE_CHECKING:
    from halfphysics.results.result import Result


def of_result(result: Result, person: int) -> dict[str, Any]:
    """Every measure of docs/metrics.md for one person; undefined numbers are None."""
    subject = result.people[person]
    others = {p.name: p for k, p in enumerate(result.people) if k != person}
    out: dict[str, Any] = {"name": subject.name}
    for key, what in (("asked", "recorded"), ("simulated", "motion")):
        motion = getattr(subject, what)
        out[key] = {
            "penetration": metrics.penetration(
                motion,
                subject.body,
                result.scene,
                people={name: (getattr(other, what), other.body) for name, other in others.items()},
                threads=result.settings.threads,
            ),
            "penetrating_volume": metrics.penetrating_volume(motion, subject.body, result.scene),
            "foot_skate": metrics.foot_skate(motion, subject.body),
            "floating": metrics.floating(
                motion,
                subject.body,
                result.scene,
                objects=known_tracks(result.scene, result.objects),
                reference=asked_motion(subject),
            ),
            "physdiff": metrics.physdiff(motion, subject.body),
            "jerk": metrics.jerk(motion, subject.body) if len(motion) >= 4 else None,
        }
    out["success"] = metrics.success(subject.motion, subject.recorded)
    out["mpjpe_mm"] = metrics.mpjpe(subject.motion, subject.recorded, subject.body)
    out["mpjpe_global_mm"] = metrics.mpjpe_global(subject.motion, subject.recorded, subject.body)
    out["deviation"] = metrics.deviation(result, person)
    out["stance_slide"] = metrics.stance_slide(result, person)
    out["unsupported_weight"] = metrics.unsupported_weight(result, person)
    out["range_violations"] = metrics.range_violations(result, person)
    out["net_force"] = metrics.net_force(result, person)
    out["path_offset"] = metrics.path_offset(result, person)
    out["contact_precision"] = metrics.contact_precision(result)
    out["contact_forces"] = metrics.contact_forces(result)
    name = subject.name
    out["soft_pressure"] = [its for its in pressures(result) if its.other == name]
    out["holds"] = [report for report in result.holds if report.person == subject.name]
    return {name: plain(value) for name, value in out.items()}


def plain(value: Any) -> Any:
    """Dataclasses, mappings and arrays as JSON values; NaN and infinity are None."""
    if dataclasses.is_dataclass(value):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {name: plain(its) for name, its in value.items()}
    if isinstance(value, np.ndarray):
        return [plain(x) for x in value.tolist()]
    if isinstance(value, list):
        return [plain(x) for x in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
