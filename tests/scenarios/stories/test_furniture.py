"""Scenes with furniture: penetrations are removed, and the rest follows the reference."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from halfphysics import scenarios
from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Mesh
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence
from halfphysics.simulation.simulate import simulate
from support.as_it_is import as_it_is
from support.judges.scene_judge import judge
from support.judges.skin_judge import SkinJudge

#: Scenario -> static that its motion penetrates, and the least depth [mm].
SCENES = {
    "climb_onto_bed": {"mattress": 30.0},
    "crawl_under_table": {"table": 20.0},
    "doorway": {"right_jamb": 50.0, "table": 15.0},
    "leg_through_table": {"table": 50.0},
    "sit_on_bed": {"mattress": 50.0},
    "sit_on_sofa": {"seat": 60.0, "rest": 40.0},
    "step_back_onto_cabinet": {"cabinet": 60.0, "wall": 20.0},
    "stretch_on_bed": {"mattress": 50.0, "headboard": 50.0},
}
#: Scenarios whose motion is made by `acting` and not by `gait`.
ACTED = (*sorted(set(SCENES) - {"doorway", "leg_through_table"}), "fly_with_ball")


#: How far the pelvis is kept from its path [m]: people are no stronger than people.
AWAY = 0.16
#: How far joints that nothing touches may turn from the reference [deg]; legs also put soles on
#: what is under them.
FREE, FREE_LEG = 12.0, 25.0
LEG = ("hip", "knee", "ankle", "foot")


@functools.cache
def judged(name):
    return judge(scenarios.load(name))


def check(verdict):
    """The bounds on every scene: clear, near, and otherwise as in the reference."""
    assert verdict.after.depth_max_mm == 0.0
    assert verdict.after.rate_percent == 0.0
    assert verdict.result.lost_time.sum() == 0.0
    assert verdict.pelvis.max() < AWAY
    leg = np.array([any(part in name for part in LEG) for name in JOINT_NAMES])
    for own, most in ((~leg, FREE), (leg, FREE_LEG)):
        joint = int(np.where(own, verdict.free, 0.0).argmax())
        assert verdict.free[joint] < most, JOINT_NAMES[joint]


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_nothing_is_entered_and_the_intent_is_kept(name):
    verdict = judged(name)
    for thing, depth in SCENES[name].items():
        assert verdict.asked.by_name[thing].max() > depth
    check(verdict)


@pytest.mark.slow
def test_half_of_a_body_goes_round_the_wall_it_was_asked_through():
    """The jamb is near the middle of the way: the body goes round it, and the walk goes on."""
    verdict = judge(scenarios.load("doorway", right_jamb=-0.10), as_it_is())
    assert verdict.asked.share.max() > 15.0  # of all the skin, within a wall 12 cm thick
    assert verdict.after.depth_max_mm == 0.0
    pelvis = [
        verdict.sequence.body.joints(m)[:, 0]
        for m in (verdict.sequence.motion, verdict.result.motion)
    ]
    at = int(np.argmax(pelvis[0][:, 0] > 2.3))  # beyond the wall
    aside = pelvis[1][at] - pelvis[0][at]
    assert 0.05 < aside[1] < 0.3  # to the left, as far as the shoulder is wide
    assert pelvis[1][-1, 0] > pelvis[0][-1, 0] - 0.4  # and past the wall


@pytest.mark.slow
@pytest.mark.parametrize(("name", "fps"), [("sit_on_sofa", 60.0), ("crawl_under_table", 120.0)])
def test_other_frame_rates(name, fps):
    verdict = judge(scenarios.load(name, fps=fps))
    check(verdict)
    # Alike at all rates: the same places at the same times, to the tolerance of the solver's path.
    at = round(fps / 30.0)
    other = judged(name)
    assert np.abs(verdict.pelvis[::at] - other.pelvis).max() < 0.012


def test_the_cabinet_and_its_wall_as_meshes():
    sequence = scenarios.load("step_back_onto_cabinet")
    scene = Scene()
    for static in sequence.scene.statics.values():
        shape = static.shape
        if isinstance(shape, Box):
            shape = Mesh(*shape.triangles())
        scene.add_static(
            static.name,
            shape,
            position=static.position,
            quaternion=static.quaternion,
            friction=static.friction,
        )
    verdict = judge(Sequence(sequence.motion, scene, sequence.body))
    check(verdict)
    assert np.abs(verdict.pelvis - judged("step_back_onto_cabinet").pelvis).max() < 0.005


@pytest.mark.parametrize("name", ["leg_through_table", "sit_on_bed"])
def test_the_skin_meets_nothing_and_passes_through_nothing(name):
    sequence = scenarios.load(name)
    frames = range(0, len(sequence.motion), 5)
    judge_ = SkinJudge(sequence.body, sequence.scene)
    asked = judge_.judge_motion(sequence.motion[:: frames.step], coal_every=4)
    assert not asked.clear  # the measure can fail
    verdict = judge_.judge_motion(judged(name).result.motion[:: frames.step], coal_every=4)
    assert verdict.clear, str(verdict)
    assert verdict.gap > 0.0


def test_a_ball_in_flight_is_held_by_two_palms():
    verdict = judged("fly_with_ball")
    check(verdict)
    result, body = verdict.result, verdict.sequence.body
    ball = result.objects["ball"].position
    assert ball[-1, 0] - ball[0, 0] > 2.5
    assert ball[-1, 2] - ball[0, 2] > 0.5
    joints = body.joints(result.motion)
    hands = [joints[:, JOINT_INDEX[f"{side}_middle1"]] for side in ("left", "right")]
    held = round(1.0 * result.fps)  # the object has been taken
    way = (ball - 0.5 * (hands[0] + hands[1]))[held:]
    assert np.linalg.norm(way - way[0], axis=1).max() < 0.02
    # Only the two hands touch it once it has left its stand.
    contacts, names = result.contacts, result.names
    ball_rows = contacts.other == names.index("ball")
    for side in ("left", "right"):
        own = np.array([n.startswith(f"{side}_") for n in JOINT_NAMES])
        rows = ball_rows & (contacts.part >= 0)
        touched = set(contacts.frame[rows][own[contacts.part[rows]]].tolist())
        assert touched >= set(range(held, len(ball)))


def test_a_ball_without_friction_is_not_held():
    sequence = scenarios.load("fly_with_ball", friction=0.0)
    result = simulate(sequence.motion, sequence.scene, body=sequence.body)
    ball = result.objects["ball"].position
    assert ball[-1, 2] < 0.5


@pytest.mark.parametrize("name", ACTED)
def test_acted_motions_are_smooth_and_within_reach(name):
    fps = 120.0
    sequence = scenarios.load(name, fps=fps)
    motion, body = sequence.motion, sequence.body
    assert 3.0 <= motion.duration <= 6.0
    joints = body.joints(motion)
    speed = np.linalg.norm(np.diff(joints, axis=0), axis=-1) * fps
    assert speed.max() < 4.0
    # No jump in speed: a knee in an ordinary walk has 60 m/s^2.
    assert np.linalg.norm(np.diff(joints, 2, axis=0), axis=-1).max() * fps**2 < 75.0
    q = rot.exp(motion.rotations)
    spin = np.linalg.norm(rot.log(rot.multiply(rot.conjugate(q[:-1]), q[1:])), axis=-1) * fps
    assert spin.max() < 14.0
    knees = [JOINT_INDEX["left_knee"], JOINT_INDEX["right_knee"]]
    assert motion.rotations[:, knees, 0].min() > -1e-6  # never bent backwards
    slow = body.joints(scenarios.load(name, fps=30).motion)
    assert np.abs(joints[::4][: len(slow)] - slow).max() < 1e-9
