"""`judge`: each value is what its own function gives, and mistakes are one message."""

from __future__ import annotations

import dataclasses
import pickle

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import metrics
from halfphysics.errors import InputError
from halfphysics.metrics.kimodo import foot_contacts
from halfphysics.metrics.measures import MEASURES
from halfphysics.metrics.world_error import sole_vertices
from support.made_clips import FRAMES, walk
from support.point_bodies import Track

#: Sums in another order than in the functions on their own.
EXACT = 1e-9


def room() -> hp.Scene:
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_static("shelf", hp.Box((0.4, 0.4, 1.6)), position=(0.9, 0.0, 0.8))
    return scene


def test_with_a_scene_and_a_truth_nothing_is_missing_and_all_agrees():
    motion, truth, scene, body = walk(), walk(1), room(), hp.Body.default()
    verdict = metrics.judge(motion, scene=scene, truth=truth)
    assert list(verdict.values) == [measure.key for measure in MEASURES]
    assert not verdict.missing
    assert (verdict.frames, verdict.fps) == (FRAMES, 30.0)
    joints, true = body.joints(motion), body.joints(truth)
    own, its, fps = joints[:, :22], true[:, :22], 30.0
    labels = foot_contacts(its, fps)
    physical, steady = metrics.physdiff(motion, body), metrics.stability(motion, body)
    inside = metrics.penetration(motion, body, scene)
    own_skin = metrics.self_penetration(motion, body)
    soles = (body.vertices(m, indices=sole_vertices(body)) for m in (motion, truth))
    expected = {
        "penetrate_mm": physical.penetrate_mm,
        "float_mm": physical.float_mm,
        "skate_mm": physical.skate_mm,
        "phys_err_mm": physical.phys_err_mm,
        "gmd_skating_ratio": metrics.foot_skate(motion, body).share_percent / 100.0,
        "kimodo_skate_height": metrics.foot_skate_from_height(own, fps),
        "kimodo_skate_ratio": metrics.foot_skate_ratio(own, fps),
        "kimodo_skate_contacts": metrics.foot_skate_from_contacts(own, fps, labels),
        "kimodo_consistency": metrics.foot_contact_consistency(own, fps, labels),
        "foot_sliding_mm": metrics.foot_sliding_mm(own),
        "jitter": metrics.jitter(own, fps),
        "jerk": metrics.jerk(motion, body),
        "stability_error_mm": steady.error_mm,
        "bose_percent": steady.bose_percent,
        "self_penetration_percent": own_skin.percent,
        "self_penetration_mm": own_skin.depth_mm,
        # Whatever is not inside has a distance of 0 or more.
        "non_collision_coins_percent": 100.0 - inside.rate_percent,
        "scene_contact_percent": 100.0 * (inside.deepest > 0.0).mean(),
        "penetration_rate_percent": inside.rate_percent,
        "depth_mean_mm": inside.depth_mean_mm,
        "depth_max_mm": inside.depth_max_mm,
        "floating_percent": metrics.floating(motion, body, scene).percent,
        "mpjpe_mm": metrics.mpjpe(motion, truth, body),
        "mpjpe_global_mm": metrics.mpjpe_global(motion, truth, body),
        "acceleration_error": metrics.acceleration_error(own, its, fps),
        "wa_mpjpe_mm": metrics.wa_mpjpe(own, its),
        "w_mpjpe_mm": metrics.w_mpjpe(own, its),
        "rte_percent": metrics.rte(own[:, 0], its[:, 0]),
        "world_foot_sliding_mm": metrics.world_foot_sliding(*soles),
        "phc_success": float(metrics.phc_success(own, its)),
    }
    for key, value in expected.items():
        assert verdict[key] == pytest.approx(value, abs=EXACT, nan_ok=True), key
    assert verdict["non_collision_percent"] <= verdict["non_collision_coins_percent"]
    assert [measure for measure, _ in verdict.rows()] == list(MEASURES)


def test_contact_of_hands_with_the_shelf():
    """A hand is near the box where its distance from it, clamped by hand, is under 5 cm."""
    motion, truth, body = walk(), walk(1), hp.Body.default()
    verdict = metrics.judge(motion, scene=room(), truth=truth)
    near = []
    for which in (motion, truth):
        hands = body.joints(which)[
            :, [hp.JOINT_NAMES.index(f"{s}_middle1") for s in ("left", "right")]
        ]
        beyond = np.abs(hands - [0.9, 0.0, 0.8]) - [0.2, 0.2, 0.8]
        near.append((np.linalg.norm(np.maximum(beyond, 0.0), axis=-1) < 0.05).any(axis=1))
    scores = metrics.contact_scores(*near)
    assert near[0].any()
    assert verdict["hand_contact_percent"] == pytest.approx(scores.percent)
    assert verdict["contact_f1"] == pytest.approx(scores.f1)
    assert verdict["contact_precision"] == pytest.approx(scores.precision)
    assert verdict["contact_recall"] == pytest.approx(scores.recall)


def test_true_hands_are_near_what_was_there_in_the_truth():
    """The true hand holds a ball all along; the simulated one lost it, though it goes as asked."""
    motion, scene = walk(), hp.Scene()
    scene.add_object("ball", hp.Sphere(0.04), mass=1.0)
    body = hp.Body.default()
    hand = body.joints(motion)[:, hp.JOINT_NAMES.index("right_middle1")]
    held = Track(hand, np.tile([1.0, 0.0, 0.0, 0.0], (FRAMES, 1)))
    lost = Track(hand + 3.0 * (np.arange(FRAMES) >= FRAMES // 2)[:, None], held.quaternion)
    verdict = metrics.judge(
        motion, scene=scene, truth=motion, objects={"ball": lost}, truth_objects={"ball": held}
    )
    assert verdict["contact_recall"] == 0.5
    assert verdict["contact_precision"] == 1.0
    for theirs in (None, {}, {"cup": held}):
        alone = metrics.judge(
            motion, scene=scene, truth=motion, objects={"ball": lost}, truth_objects=theirs
        )
        assert alone["hand_contact_percent"] == verdict["hand_contact_percent"] == 50.0
        for key in ("contact_precision", "contact_recall", "contact_f1"):
            assert alone.missing[key] == "takes tracks of the objects in the truth"
    with pytest.raises(InputError, match="truth_objects: expected names and tracks"):
        metrics.judge(motion, scene=scene, truth=motion, truth_objects=3)
    short = Track(held.position[:2], held.quaternion[:2])
    with pytest.raises(InputError, match=r"^truth_objects: 'ball': expected position"):
        metrics.judge(
            motion, scene=scene, truth=motion, objects={"ball": lost}, truth_objects={"ball": short}
        )


def test_alone_it_says_what_is_missing_and_why():
    verdict = metrics.judge(walk())
    assert verdict.missing["rte_percent"] == "takes a truth"
    assert verdict.missing["non_collision_percent"] == "takes a scene"
    assert "non_collision_percent" not in verdict.values
    same = pickle.loads(pickle.dumps(verdict))
    assert (dict(same.values), dict(same.missing)) == (dict(verdict.values), dict(verdict.missing))
    with pytest.raises(TypeError):
        verdict.values["jerk"] = 0.0
    floor = hp.Scene()
    floor.add_static("floor", hp.Plane())
    with_floor = metrics.judge(walk(), scene=floor)
    assert with_floor.missing["hand_contact_percent"].startswith("takes a scene with more")
    short = metrics.judge(walk()[:3])
    assert short.missing["jerk"] == "takes at least 4 frames, found 3"


def test_level_ground_may_be_elsewhere():
    motion = walk()
    lifted = dataclasses.replace(
        motion, translation=motion.translation + np.array([0.0, 0.0, 0.25])
    )
    here, there = metrics.judge(motion), metrics.judge(lifted, ground=0.25)
    for key, value in here.values.items():
        assert there[key] == pytest.approx(value, rel=1e-6, abs=1e-6), key


def test_objects_of_a_result_count():
    scene = room()
    scene.add_object("ball", hp.Sphere(0.3), mass=1.0)
    track = Track(np.tile([0.0, -0.47, 1.1], (FRAMES, 1)), np.tile([1.0, 0, 0, 0], (FRAMES, 1)))
    with_ball = metrics.judge(walk(), scene=scene, objects={"ball": track})
    assert with_ball["depth_max_mm"] > metrics.judge(walk(), scene=scene)["depth_max_mm"] + 50.0


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"motion": 3}, r"motion: expected a halfphysics\.Motion"),
        ({"scene": "room.yaml"}, r"scene: expected a halfphysics\.Scene"),
        ({"truth": 3}, r"truth: expected a halfphysics\.Motion"),
        ({"truth": "short"}, "truth: found 20 frames, expected 40 as of the motion"),
        ({"truth": "slow"}, "truth: found 20 frames per second, expected 30"),
        ({"ground": np.nan}, "ground"),
        ({"body": 1}, "body"),
    ],
    ids=str,
)
def test_mistakes(wrong, words):
    given = {"motion": walk()} | wrong
    truths = {"short": walk()[:20], "slow": dataclasses.replace(walk(), fps=20.0)}
    if isinstance(given.get("truth"), str):
        given["truth"] = truths[given["truth"]]
    with pytest.raises(InputError, match=words):
        metrics.judge(**given)
