"""Measures of a motion and of a result: docs/metrics.md has every definition.

Motions are `halfphysics.motion.motion.Motion`, bodies `halfphysics.body.body.Body`, scenes
`halfphysics.scene.scene.Scene`, results `halfphysics.results.result.Result`.
"""

from __future__ import annotations

from halfphysics.metrics.contact_precision import LabelReport, contact_precision
from halfphysics.metrics.deviation import Deviation, IntentReport, deviation
from halfphysics.metrics.forces import ForceReport, contact_forces
from halfphysics.metrics.joint_errors import mpjpe, mpjpe_global
from halfphysics.metrics.penetration import PenetrationReport, penetration
from halfphysics.metrics.sequences import PenetrationSummary, over_sequences
from halfphysics.metrics.skating import SkateReport, foot_skate
from halfphysics.metrics.smoothness import jerk
from halfphysics.metrics.success import success
from halfphysics.metrics.volume import VolumeReport, penetrating_volume

__all__ = [
    "Deviation",
    "ForceReport",
    "IntentReport",
    "LabelReport",
    "PenetrationReport",
    "PenetrationSummary",
    "SkateReport",
    "VolumeReport",
    "contact_forces",
    "contact_precision",
    "deviation",
    "foot_skate",
    "jerk",
    "mpjpe",
    "mpjpe_global",
    "over_sequences",
    "penetrating_volume",
    "penetration",
    "success",
]
