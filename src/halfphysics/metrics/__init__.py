"""Measures of a motion and of a result: docs/metrics.md has every definition.

Motions are `halfphysics.motion.motion.Motion`, bodies `halfphysics.body.body.Body`, scenes
`halfphysics.scene.scene.Scene`, results `halfphysics.results.result.Result`.
"""

from __future__ import annotations

from halfphysics.metrics.airborne import airborne
from halfphysics.metrics.contact_precision import LabelReport, contact_precision
from halfphysics.metrics.contact_scores import ContactScores, contact_scores
from halfphysics.metrics.deviation import Deviation, IntentReport, deviation
from halfphysics.metrics.floating import FloatReport, PhysDiffReport, floating, physdiff
from halfphysics.metrics.foot_sliding import foot_sliding_mm, gmd_skating_ratio
from halfphysics.metrics.forces import ForceReport, contact_forces
from halfphysics.metrics.joint_errors import mpjpe, mpjpe_global
from halfphysics.metrics.judge import judge
from halfphysics.metrics.kimodo import (
    foot_contact_consistency,
    foot_skate_from_contacts,
    foot_skate_from_height,
    foot_skate_ratio,
)
from halfphysics.metrics.measures import MEASURES, Measure
from halfphysics.metrics.net_force import NetForceReport, net_force
from halfphysics.metrics.path_offset import PathReport, path_offset
from halfphysics.metrics.penetration import PenetrationReport, penetration
from halfphysics.metrics.range_violations import RangeReport, range_violations
from halfphysics.metrics.scene_contact import SceneContactReport, scene_contact
from halfphysics.metrics.self_penetration import SelfPenetrationReport, self_penetration
from halfphysics.metrics.sequences import PenetrationSummary, over_sequences
from halfphysics.metrics.skating import SkateReport, foot_skate
from halfphysics.metrics.smoothness import acceleration_error, jerk, jitter
from halfphysics.metrics.stability import StabilityReport, stability
from halfphysics.metrics.stance import Slide, StanceReport, stance_slide
from halfphysics.metrics.success import phc_success, success
from halfphysics.metrics.unsupported import UnsupportedReport, unsupported_weight
from halfphysics.metrics.verdict import Verdict
from halfphysics.metrics.volume import VolumeReport, penetrating_volume
from halfphysics.metrics.world_error import rte, w_mpjpe, wa_mpjpe, world_foot_sliding

__all__ = [
    "MEASURES",
    "ContactScores",
    "Deviation",
    "FloatReport",
    "ForceReport",
    "IntentReport",
    "LabelReport",
    "Measure",
    "NetForceReport",
    "PathReport",
    "PenetrationReport",
    "PenetrationSummary",
    "PhysDiffReport",
    "RangeReport",
    "SceneContactReport",
    "SelfPenetrationReport",
    "SkateReport",
    "Slide",
    "StabilityReport",
    "StanceReport",
    "UnsupportedReport",
    "Verdict",
    "VolumeReport",
    "acceleration_error",
    "airborne",
    "contact_forces",
    "contact_precision",
    "contact_scores",
    "deviation",
    "floating",
    "foot_contact_consistency",
    "foot_skate",
    "foot_skate_from_contacts",
    "foot_skate_from_height",
    "foot_skate_ratio",
    "foot_sliding_mm",
    "gmd_skating_ratio",
    "jerk",
    "jitter",
    "judge",
    "mpjpe",
    "mpjpe_global",
    "net_force",
    "over_sequences",
    "path_offset",
    "penetrating_volume",
    "penetration",
    "phc_success",
    "physdiff",
    "range_violations",
    "rte",
    "scene_contact",
    "self_penetration",
    "stability",
    "stance_slide",
    "success",
    "unsupported_weight",
    "w_mpjpe",
    "wa_mpjpe",
    "world_foot_sliding",
]
