"""Walking: stance feet do not slide, legs reach, natural proportions."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.legs import about, leg_of, planted, solve
from halfphysics.scenarios.acting.walk_plan import Kick, Walk


@pytest.fixture(scope="module")
def body() -> Body:
    return Body.default()


@pytest.fixture(scope="module", params=[0.7, 1.2, 1.6])
def plan(request) -> Walk:
    return Walk(distance=3.0, speed=request.param, before=0.2, after=0.2)


def test_feet_do_not_slide(body, plan):
    motion = walk(body, plan, fps=60.0)
    skin = body.vertices(motion)
    height = skin[..., 2] - plan.lift
    # Soles are on the ground and no vertex is below it (float32 skin: 0.1 um).
    assert height.min() > -1e-4
    assert height.min(axis=1).max() < 5e-4
    # Skin that is within 1 mm of the ground in two frames stays where it is. The exception is
    # the rim of a heel or toe that rolls off: it moves by the part of a millimetre it rolls.
    down = (height[1:] < 1e-3) & (height[:-1] < 1e-3)
    step = np.linalg.norm(np.diff(skin[..., :2], axis=0), axis=-1)
    assert np.percentile(step[down], 99.0) < 5e-4
    assert step[down].mean() < 1e-4


def test_it_goes_as_far_and_as_fast_as_planned(body, plan):
    motion = walk(body, plan)
    pelvis = body.joints(motion)[:, 0]
    assert np.isclose(pelvis[-1, 0] - pelvis[0, 0], plan.distance, atol=1e-6)
    speed = np.diff(pelvis[:, 0]) * motion.fps
    assert speed.min() > -1e-9
    assert abs(np.median(speed[speed > 0.5 * plan.speed]) / plan.speed - 1.0) < 0.02
    under_way = pelvis[len(pelvis) // 3 : 2 * len(pelvis) // 3, 2]
    # People rise and sink by about 4 to 6 cm, more at a fast walk.
    assert 0.01 < np.ptp(under_way) < 0.085


def test_it_starts_and_ends_standing(body):
    joints = body.joints(walk(body, Walk(distance=2.0, before=0.6, after=0.6)))
    for still in (joints[:6], joints[-6:]):
        assert np.abs(np.diff(still, axis=0)).max() < 1e-6
    feet = joints[-1, [JOINT_INDEX["left_ankle"], JOINT_INDEX["right_ankle"]]]
    assert abs(feet[0, 0] - feet[1, 0]) < 1e-4  # side by side


def test_joints_stay_in_human_range(body, plan):
    motion = walk(body, plan)
    for side in ("left", "right"):
        knee = motion.rotations[:, JOINT_INDEX[f"{side}_knee"], 0]
        assert knee.min() > -np.radians(3.0)  # never bent backwards
        assert knee.max() < np.radians(95.0)
        assert np.abs(motion.rotations[:, JOINT_INDEX[f"{side}_ankle"]]).max() < np.radians(45.0)
    spin = rot.log(rot.multiply(rot.conjugate(rot.exp(motion.rotations[:-1])),
                                rot.exp(motion.rotations[1:])))  # fmt: skip
    # No joint snaps: knees and toes of a fast walker turn at about 10 rad/s.
    assert np.linalg.norm(spin, axis=-1).max() * motion.fps < 14.0


def test_frame_rates_sample_one_movement(body):
    plan = Walk(distance=2.0, kick=Kick(step=1))
    slow, fast = walk(body, plan, 30.0), walk(body, plan, 120.0)
    joints = body.joints(fast)[::4]
    assert np.abs(joints[: len(slow)] - body.joints(slow)).max() < 1e-3


def test_heading_and_start_turn_the_whole_walk(body):
    straight = body.joints(walk(body, Walk(distance=2.0)))
    turned = body.joints(walk(body, Walk(distance=2.0, heading=2.0, start=(3.0, -1.0))))
    assert np.allclose(turned, straight @ about(2, 2.0).T + [3.0, -1.0, 0.0], atol=1e-9)


def test_tall_and_short_people_reach_the_ground():
    for stature in (1.5, 1.95):
        body = Body.default(stature=stature)
        plan = Walk(distance=2.0)
        height = body.vertices(walk(body, plan))[..., 2] - plan.lift
        assert height.min() > -1e-4
        assert height.min(axis=1).max() < 5e-4


def test_the_kick_is_fast_and_clears_the_ground(body):
    plan = Walk(distance=4.0, kick=Kick(step=3))
    motion = walk(body, plan, 120.0)
    foot = JOINT_INDEX[f"{plan.swinging(3)}_foot"]
    toe = body.joints(motion)[:, foot]
    speed = np.linalg.norm(np.diff(toe, axis=0), axis=1) * motion.fps
    assert 5.0 < speed.max() < 12.0
    assert toe[:, 2].max() > 0.3  # the leg follows through
    assert body.vertices(motion)[..., 2].min() > plan.lift - 1e-4


def test_leg_reaches_any_target(body):
    rng = np.random.default_rng(0)
    leg = leg_of(body, "left")
    n = 200
    away = rng.normal(0.0, 1.0, (n, 3)) * [0.4, 0.2, 0.1] - [0.0, 0.0, 1.0]
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    ankle = away * rng.uniform(0.3, 0.99, (n, 1)) * leg.length
    root = rot.rotvec_to_matrix(rng.normal(0.0, 0.2, (n, 3))) @ np.array(
        [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    )
    foot = root @ rot.rotvec_to_matrix(rng.normal(0.0, 0.2, (n, 3)))
    out = solve(leg, root, np.zeros((n, 3)), ankle, foot, np.zeros(n))
    hip, knee, joint, _ = (rot.rotvec_to_matrix(out[j]) for j in leg.joints)
    thigh, shank = root @ hip, root @ hip @ knee
    assert np.allclose(thigh @ leg.thigh + shank @ leg.shank, ankle, atol=1e-12)
    assert np.allclose(shank @ joint, foot, atol=1e-12)


def test_a_planted_foot_rolls_over_a_fixed_point(body):
    leg = leg_of(body, "right")
    pitch = np.radians([-60.0, -30.0, -1.0, 0.0, 1.0, 25.0])
    ankle = planted(leg, np.array([1.0, 2.0]), 0.3, pitch)
    frame = about(2, 0.3) @ np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    turned = frame @ about(0, -pitch)
    toe, heel = ankle + turned @ leg.toe, ankle + turned @ leg.heel
    assert np.allclose(toe[:4], toe[3], atol=1e-12)
    assert np.allclose(heel[3:], heel[3], atol=1e-12)
    assert np.allclose(heel[3:, 2], 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"speed": 9.0}, "speed: found 9.0"),
        ({"distance": 0.0}, "distance: found 0.0"),
        ({"first": "both"}, "first: found 'both'"),
        ({"kick": Kick(step=40)}, "kick: found step 40, expected 1 to"),
    ],
)
def test_impossible_walks(values, message):
    with pytest.raises(InputError, match=message):
        Walk(**({"distance": 4.0} | values))
