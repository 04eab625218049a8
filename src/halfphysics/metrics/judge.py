"""`judge`: a motion by everybody's measures at once, each under its own name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.base import validation
from halfphysics.base.validation import number, shown
from halfphysics.errors import InputError
from halfphysics.metrics.argument_checks import Array, check_motion
from halfphysics.metrics.contact_scores import HANDS, contact_scores, hand_contact
from halfphysics.metrics.floating import floating, physdiff_from
from halfphysics.metrics.foot_sliding import foot_sliding_mm, gmd_skating_ratio
from halfphysics.metrics.kimodo import (
    foot_contact_consistency,
    foot_contacts,
    foot_skate_from_contacts,
    foot_skate_from_height,
    foot_skate_ratio,
)
from halfphysics.metrics.measures import MEASURES, WANTED, Measure
from halfphysics.metrics.penetration import penetration
from halfphysics.metrics.scene_contact import SceneDistance, counts_of, scores_of
from halfphysics.metrics.self_penetration import self_penetration
from halfphysics.metrics.skating import foot_skate
from halfphysics.metrics.skins import batches, skin
from halfphysics.metrics.smoothness import acceleration_error, jerk, jitter
from halfphysics.metrics.stability import report_of, skin_points, stability_of
from halfphysics.metrics.success import phc_success
from halfphysics.metrics.verdict import Verdict
from halfphysics.metrics.world_error import (
    rte,
    sole_vertices,
    w_mpjpe,
    wa_mpjpe,
    world_foot_sliding,
)

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene

#: The joints that SMPL, SMPL-H and SMPL-X share, by which other projects measure.
SHARED = 22
# What compares contact with the truth, and why it is missing where the truth's objects are.
_COMPARED = ("contact_precision", "contact_recall", "contact_f1")
_UNKNOWN = "takes tracks of the objects in the truth"


def judge(
    motion: Motion,
    body: Body | None = None,
    scene: Scene | None = None,
    truth: Motion | None = None,
    *,
    truth_body: Body | None = None,
    objects: Mapping[str, Any] | None = None,
    truth_objects: Mapping[str, Any] | None = None,
    ground: float = 0.0,
) -> Verdict:
    """Take every measure that can be taken of a motion; `MEASURES` names and defines them.

    Args:
        motion: T >= 2 frames.
        body: The person's body; None: the default body.
        scene: Static geometry, for non-collision, penetration and contact of hands; None: only
            level ground is known.
        truth: The true motion of T frames at the same rate; None: no errors are measured.
        truth_body: The body of the truth; None: the same body.
        objects: Tracks of the scene's objects, name -> position (T, 3) and quaternion (T, 4), as in
            ``result.objects``; those not named are left out.
        truth_objects: Tracks of the same objects in the truth: the true hands are near these, not
            near what was simulated. None: with `objects`, contact is not compared with the truth.
        ground: Height of level ground [m], for measures that know no scene.

    Raises:
        InputError: An argument of another kind; fewer than 2 frames; a truth of another length or
            rate; a track of no object of the scene.
    """
    from halfphysics.body.body import Body
    from halfphysics.scene.scene import Scene

    check_motion("motion", motion)
    if len(motion) < 2:
        raise InputError(f"motion: found {len(motion)} frame, expected at least 2 to judge")
    body = Body.default() if body is None else body
    truth_body = body if truth_body is None else truth_body
    for its in (body, truth_body):
        validation.body(its, "vertices")
    if scene is not None and not isinstance(scene, Scene):
        raise InputError(f"scene: expected a halfphysics.Scene, found {shown(scene)}")
    if truth is not None:
        _check_truth(motion, truth)
    if not isinstance(truth_objects, Mapping | None):
        raise InputError(
            "truth_objects: expected names and tracks, as in result.objects, found "
            f"{shown(truth_objects)}"
        )
    ground = number(ground, "ground", unit="m")
    found: dict[str, float] = {}
    joints = body.joints(motion)
    _of_feet(found, motion, body, joints, ground)
    _of_skin(found, motion, body, scene, objects, ground)
    if truth is not None:
        _of_truth(found, motion, body, truth, truth_body, joints, ground)
    if scene is not None:
        _of_scene(found, motion, body, scene, objects)
        true = None if truth is None else truth_body.joints(truth)[:, HANDS]
        _of_hands(found, scene, objects, joints[:, HANDS], truth_objects or {}, true)
    missing = {m.key: _missing(m, len(motion)) for m in MEASURES if m.key not in found}
    if truth is not None and "hand_contact_percent" in found:
        missing |= {key: _UNKNOWN for key in _COMPARED if key in missing}
    return Verdict(
        values={m.key: found[m.key] for m in MEASURES if m.key in found},
        missing=missing,
        frames=len(motion),
        fps=float(motion.fps),
    )


def _check_truth(motion: Any, truth: Any) -> None:
    check_motion("truth", truth)
    if len(truth) != len(motion):
        raise InputError(
            f"truth: found {len(truth)} frames, expected {len(motion)} as of the motion. Cut the "
            "longer one to the frames of the other"
        )
    if abs(truth.fps - motion.fps) > 1e-6 * abs(motion.fps):
        raise InputError(
            f"truth: found {truth.fps:g} frames per second, expected {motion.fps:g} as of the "
            "motion. Resample one of them"
        )


def _missing(measure: Measure, frames: int) -> str:
    if frames < measure.least:
        return f"takes at least {measure.least} frames, found {frames}"
    return WANTED.get(measure.needs, "")


def _of_feet(
    found: dict[str, float], motion: Motion, body: Body, joints: Array, ground: float
) -> None:
    """Sliding feet and smoothness: joints alone."""
    fps, shared = float(motion.fps), joints[:, :SHARED]
    found["skate_mm"] = foot_skate(motion, body, ground=ground).mean_mm
    found["gmd_skating_ratio"] = gmd_skating_ratio(shared, fps, ground=ground)
    found["kimodo_skate_height"] = foot_skate_from_height(shared, fps, ground=ground)
    found["kimodo_skate_ratio"] = foot_skate_ratio(shared, fps, ground=ground)
    found["foot_sliding_mm"] = foot_sliding_mm(shared, ground=ground)
    if len(motion) >= 4:
        found["jitter"] = jitter(shared, fps)
        found["jerk"] = jerk(motion, body)


def _of_skin(
    found: dict[str, float],
    motion: Motion,
    body: Body,
    scene: Scene | None,
    objects: Mapping[str, Any] | None,
    ground: float,
) -> None:
    """What takes the whole skin: it is posed once."""
    points = skin_points(body)
    distance = None if scene is None else SceneDistance(scene, len(motion), objects)
    lowest, steady, shares = [], [], []
    for part in batches(len(motion), "judging"):
        vertices = skin(motion, body, part)
        lowest.append(vertices[..., 2].min(axis=1))
        steady.append(stability_of(vertices, points, ground=ground))
        if distance is not None:
            shares.append(counts_of(distance.of(vertices, part)))
    physical = physdiff_from(np.concatenate(lowest), found["skate_mm"], ground)
    found["penetrate_mm"], found["float_mm"] = physical.penetrate_mm, physical.float_mm
    found["phys_err_mm"] = physical.phys_err_mm
    balance = report_of(*(np.concatenate(c) for c in zip(*steady, strict=True)))
    found["stability_error_mm"] = balance.error_mm
    found["bose_percent"] = balance.bose_percent
    own = self_penetration(motion, body)
    found["self_penetration_percent"] = own.percent
    found["self_penetration_mm"] = own.depth_mm
    if shares:
        scores = scores_of(*(np.concatenate(c) for c in zip(*shares, strict=True)))
        found["non_collision_percent"] = scores.non_collision_percent
        found["non_collision_coins_percent"] = scores.non_collision_coins_percent
        found["scene_contact_percent"] = scores.contact_percent


def _of_scene(
    found: dict[str, float],
    motion: Motion,
    body: Body,
    scene: Scene,
    objects: Mapping[str, Any] | None,
) -> None:
    inside = penetration(motion, body, scene, objects=objects)
    found["penetration_rate_percent"] = inside.rate_percent
    found["depth_mean_mm"], found["depth_max_mm"] = inside.depth_mean_mm, inside.depth_max_mm
    found["floating_percent"] = floating(motion, body, scene, objects=objects).percent


def _of_hands(
    found: dict[str, float],
    scene: Scene,
    objects: Mapping[str, Any] | None,
    hands: Array,
    true_objects: Mapping[str, Any],
    true_hands: Array | None,
) -> None:
    """Contact of hands (T, 2, 3) [m] with what is no plane, and of the true hands with what was
    there in the truth."""
    distance = SceneDistance(scene, len(hands), objects, planes=False)
    if not distance.solids:
        return
    whole = slice(0, len(hands))
    contact = hand_contact(distance.of(hands, whole))
    found["hand_contact_percent"] = contact_scores(contact, contact).percent
    moved = objects or {}
    if true_hands is None or not moved.keys() <= true_objects.keys():
        return
    true_objects = {name: true_objects[name] for name in moved}
    there = SceneDistance(scene, len(hands), true_objects, planes=False, what="truth_objects")
    scores = contact_scores(contact, hand_contact(there.of(true_hands, whole)))
    found["contact_precision"], found["contact_recall"] = scores.precision, scores.recall
    found["contact_f1"] = scores.f1


def _of_truth(
    found: dict[str, float],
    motion: Motion,
    body: Body,
    truth: Motion,
    truth_body: Body,
    joints: Array,
    ground: float,
) -> None:
    """Errors against the truth."""
    fps, true = float(motion.fps), truth_body.joints(truth)
    own, its = joints[:, :SHARED], true[:, :SHARED]
    labels = foot_contacts(its, fps, ground=ground)
    found["kimodo_skate_contacts"] = foot_skate_from_contacts(own, fps, labels)
    found["kimodo_consistency"] = foot_contact_consistency(own, fps, labels, ground=ground)
    error = np.linalg.norm(joints - true, axis=-1).mean()
    found["mpjpe_global_mm"] = float(1000.0 * error)
    relative = (joints - joints[:, :1]) - (true - true[:, :1])
    found["mpjpe_mm"] = float(1000.0 * np.linalg.norm(relative, axis=-1).mean())
    if len(motion) >= 3:
        found["acceleration_error"] = acceleration_error(own, its, fps)
    found["wa_mpjpe_mm"] = wa_mpjpe(own, its)
    found["w_mpjpe_mm"] = w_mpjpe(own, its)
    found["rte_percent"] = rte(own[:, 0], its[:, 0])
    soles, true_soles = (
        whose.vertices(what, indices=sole_vertices(whose))
        for whose, what in ((body, motion), (truth_body, truth))
    )
    found["world_foot_sliding_mm"] = world_foot_sliding(soles, true_soles)
    found["phc_success"] = float(phc_success(own, its))
