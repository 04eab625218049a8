"""Measures of a motion and of a result: docs/metrics.md has every definition.

Motions are `halfphysics.motion.motion.Motion`, bodies `halfphysics.body.body.Body`, scenes
`halfphysics.scene.scene.Scene`, results `halfphysics.results.result.Result`.
"""

from __future__ import annotations

from halfphysics.metrics.airborne import airborne
from halfphysics.metrics.contact_precision import LabelReport, contact_precision
from halfphysics.metrics.deviation import Deviation, IntentReport, deviation
from halfphysics.metrics.floating import FloatReport, PhysDiffReport, floating, physdiff
from halfphysics.metrics.forces import ForceReport, contact_forces
from halfphysics.metrics.joint_errors import mpjpe, mpjpe_global
from halfphysics.metrics.net_force import NetForceReport, net_force
from halfphysics.metrics.path_offset import PathReport, path_offset
from halfphysics.metrics.penetration import PenetrationReport, penetration
from halfphysics.metrics.range_violations import RangeReport, range_violations
from halfphysics.metrics.sequences import PenetrationSummary, over_sequences
from halfphysics.metrics.skating import SkateReport, foot_skate
from halfphysics.metrics.smoothness import jerk
from halfphysics.metrics.stance import Slide, StanceReport, stance_slide
from halfphysics.metrics.success import success
from halfphysics.metrics.unsupported import UnsupportedReport, unsupported_weight
from halfphysics.metrics.volume import VolumeReport, penetrating_volume

__all__ = [
    "Deviation",
    "FloatReport",
    "ForceReport",
    "IntentReport",
    "LabelReport",
    "NetForceReport",
    "PathReport",
    "PenetrationReport",
    "PenetrationSummary",
    "PhysDiffReport",
    "RangeReport",
    "SkateReport",
    "Slide",
    "StanceReport",
    "UnsupportedReport",
    "VolumeReport",
    "airborne",
    "contact_forces",
    "contact_precision",
    "deviation",
    "floating",
    "foot_skate",
    "jerk",
    "mpjpe",
    "mpjpe_global",
    "net_force",
    "over_sequences",
    "path_offset",
    "penetrating_volume",
    "penetration",
    "physdiff",
    "range_violations",
    "stance_slide",
    "success",
    "unsupported_weight",
]
