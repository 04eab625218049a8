"""Who was moved off its place steps back, over and round what is in the way."""

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.scenarios.acting.gait import Walk
from halfphysics.scenarios.acting.gait import walk as gait
from support.ground.cases import Case, set_up
from support.ground.upright import BODY, FEET, SIDES, STANDS, floor, lowest, standing


def pushed_aside(by=0.6, fps=60.0, bench=None):
    """Somebody who stands for 6 s, whom a slow wall pushes aside within 2 s and then leaves.

    `bench`: how high one is on the other side, and how far from the foot there [m].
    """
    motion = standing(0.0, frames=int(6 * fps), fps=fps)
    scene = floor(top=-0.0012)
    t = np.arange(len(motion)) / fps
    reach = np.abs(BODY.vertices(motion[0])[:, 0]).max()
    # Beside the arm, out by `by` and back again.
    way = by * np.interp(t, [0.0, 0.5, 2.0, 2.5], [0.0, 0.0, 1.0, -0.5])
    start = motion.translation[0, 0] - reach - 0.06
    track = np.column_stack([start + way, np.zeros_like(t), np.full_like(t, 1.0)])
    scene.add_moving("wall", hp.Box((0.1, 2.0, 1.9)), track, fps=fps)
    if bench:
        high, away = bench
        edge = BODY.vertices(motion[0])[FEET, 0].max() + away
        box = hp.Box((0.5, 2.0, high))
        scene.add_static("bench", box, position=(edge + 0.25, 0.0, high / 2.0))
    return hp.simulate(motion, scene, body=BODY)


def test_who_is_pushed_aside_steps_there_and_back():
    result = pushed_aside()
    off = (result.motion.translation - result.reference.translation)[:, 0]
    assert off.max() > 0.4
    assert abs(off[-1]) < 0.01
    slid = np.nansum(hp.metrics.stance_slide(result).slide, axis=0)
    assert slid.max() < 0.1  # [m] of 0.9 that the body goes
    ankles = BODY.joints(result.motion)[:, [hp.JOINT_NAMES.index(f"{s}_ankle") for s in SIDES]]
    up = ankles[..., 2] - ankles[0, :, 2]
    assert up.max() > 0.02  # a foot was lifted
    assert not ((up > 0.02).all(axis=1)).any()  # never both
    home = (
        ankles[-1, :, :2]
        - BODY.joints(result.reference)[-1][[hp.JOINT_NAMES.index(f"{s}_ankle") for s in SIDES], :2]
    )
    assert np.linalg.norm(home, axis=1).max() < 0.04  # the feet are where they belong
    assert not len(result.breaches)


@pytest.mark.parametrize("bench", [(0.18, 0.02), (0.18, 0.15), (0.24, 0.15)])
def test_who_is_pushed_over_a_bench_stays_on_the_ground(bench):
    """Feet that rest do not step up: people rose by up to 0.18 m, with both feet in the air."""
    result = pushed_aside(by=0.4, bench=bench)
    off = result.motion.translation - result.reference.translation
    assert off[:, 0].max() > 0.05
    assert off[:, 2].max() < 0.01
    assert lowest(result.motion, FEET).max() < 0.01
    assert hp.metrics.unsupported_weight(result).percent == 0.0


@pytest.mark.parametrize(("high", "steps"), [(0.28, True), (0.38, False)])
def test_no_step_is_much_higher_than_the_lowest_foot(high, steps):
    """A foot that swings to the side at a height of 0.14 m steps on what is up to 0.30 m high."""
    fps, frames = 60.0, 120
    motion = standing(0.0, frames=frames, fps=fps)
    bent = np.array(motion.rotations)
    hip, knee = (hp.JOINT_NAMES.index(f"left_{joint}") for joint in ("hip", "knee"))
    bent[:, [hip, knee], 0] = [-1.0, 1.5]
    bent[:, hip, 2] = np.interp(np.arange(frames) / fps, [0.5, 1.5], [0.0, 0.5])
    motion = motion.with_frames(motion.translation, bent)
    skin, scene = BODY.vertices(motion[0]), floor()
    left = np.array([v for v in FEET if skin[v, 0] > 0.0])
    edge = skin[left, 0].max() + 0.03
    scene.add_static("bench", hp.Box((0.6, 2.0, high)), position=(edge + 0.3, 0.0, high / 2.0))
    result = hp.simulate(motion, scene, body=BODY)
    if steps:
        assert STANDS[0] < lowest(result.motion, left)[-1] - high < 0.02
    else:
        assert lowest(result.motion, left).max() < 0.2
    assert not len(result.breaches)


def test_who_was_pushed_onto_a_low_bench_steps_down_again():
    """How far down a step goes is measured from the lowest point of the sole, not from each."""
    result = pushed_aside(by=0.4, bench=(0.08, 0.02))
    off = result.motion.translation - result.reference.translation
    assert off[:, 2].max() > 0.05
    assert np.abs(off[-1]).max() < 0.005


def on_a_piston(falls, fps=60.0, frames=180):
    """Somebody waits at a wall with a foot on what rises, and falls away: how high that foot is."""
    t = np.arange(frames) / fps
    motion = standing(0.0, frames=frames, fps=fps)
    way = t[:, None] * [0.0, -0.5, 0.0]
    motion = motion.with_frames(motion.translation + way, motion.rotations)
    skin, scene = BODY.vertices(motion[0]), floor()
    wall = (0.0, skin[:, 1].min() - 0.35, 1.0)
    scene.add_static("wall", hp.Box((3.0, 0.1, 2.0)), position=wall)
    left = np.array([v for v in FEET if skin[v, 0] > 0.0])
    under = np.tile(skin[left].mean(axis=0), (frames, 1))
    under[:, 1] -= 0.3
    under[:, 2] = np.interp(t, [0.0, 1.2, falls, falls + 0.04], [0.0, 0.0, 0.35, -0.1]) - 0.31
    scene.add_moving("piston", hp.Box((0.16, 0.5, 0.6)), under, fps=fps)
    result = hp.simulate(motion, scene, body=BODY)
    assert not len(result.breaches)
    high = lowest(result.motion, left)
    return [high[round((falls + after) * fps)] for after in (-0.05, 0.3, 0.5)]


def test_a_leg_that_was_lifted_comes_down_at_once_when_nothing_is_under_it():
    """At 0.5 m/s it would be 0.19 m up after 0.3 s, and 0.09 m after 0.5 s.

    What the body and the knee do between wall and piston is a matter of chance: it kicks a leg up
    as it falls in one of eight cases or two.
    """
    before, soon, later = np.transpose([on_a_piston(f) for f in np.linspace(1.8, 2.15, 8)])
    assert (before > 0.25).sum() >= 7
    assert (soon < 0.1).sum() >= 6
    assert later.max() < 0.06


def test_who_is_turned_off_the_motion_stands_on_level_feet():
    """A post that pushes one hip back turns somebody; soles stay on the ground and level."""
    fps = 60.0
    motion = standing(0.0, frames=120, fps=fps)
    scene = floor(top=-0.0012)
    t = np.arange(120) / fps
    hip = BODY.joints(motion[0])[hp.JOINT_NAMES.index("left_hip")]
    front = BODY.vertices(motion[0])[:, 1].min()
    y = front - 0.06 + np.interp(t, [0.2, 1.2], [0.0, 0.3])
    track = np.column_stack([np.full_like(t, hip[0] + 0.06), y, np.full_like(t, hip[2] + 0.05)])
    scene.add_moving("post", hp.Box((0.1, 0.1, 0.3)), track, fps=fps)
    result = hp.simulate(motion, scene, body=BODY)
    turned = rot.angles(result.motion.rotations[:, 0], result.reference.rotations[:, 0])
    assert turned.max() > np.radians(5.0)
    sole = BODY.vertices(result.motion)[:, FEET, 2].min(axis=1)
    assert sole.min() > -0.0012 + STANDS[0]
    assert np.abs(sole - sole[0]).max() < 0.02
    assert hp.metrics.stance_slide(result).simulated.mean_mm < 1.5  # [mm] a frame


@pytest.mark.parametrize("shake", [0, 2])
def test_who_is_turned_by_a_jamb_stays_on_its_foot(shake):
    """The path goes on as recorded, the legs are turned: the foot went aside by 58 mm with it."""
    (motion,), scene, (body,) = set_up(Case("push", "jamb", shake=shake), None)
    result = hp.simulate(motion, scene, body=body)
    forward = rot.rotate(rot.exp(result.motion.rotations[:, 0]), [0.0, 0.0, 1.0])
    asked = rot.rotate(rot.exp(motion.rotations[:, 0]), [0.0, 0.0, 1.0])
    turned = (forward[:, :2] * asked[0, :2]).sum(axis=1)  # who walks straight turns by 5 degrees
    begin = int((turned < np.cos(np.deg2rad(12.0))).argmax())
    assert begin > 60
    ankle = body.joints(result.motion)[begin:, hp.JOINT_NAMES.index("right_ankle"), :2]
    assert np.linalg.norm(ankle[9] - ankle[0]) < 0.04  # [m] in 0.3 s


def test_who_was_stopped_by_a_table_goes_round_it_and_steps_back_to_the_path():
    """Blocked, waiting, round the table, and beside the reference that stands meanwhile."""
    fps = 30.0
    walked = gait(BODY, Walk(distance=5.0, speed=1.2), fps)
    still = 330  # the way takes 7 to 9 s, as it meets the table once more or not
    motion = walked.with_frames(
        np.concatenate([walked.translation, np.repeat(walked.translation[-1:], still, 0)]),
        np.concatenate([walked.rotations, np.repeat(walked.rotations[-1:], still, 0)]),
    )
    scene = floor()
    scene.add_static("table", hp.Box((0.8, 1.6, 0.75)), position=(2.0, 0.1, 0.375))
    result = hp.simulate(motion, scene, body=BODY)
    off = np.linalg.norm((result.motion.translation - result.reference.translation)[:, :2], axis=1)
    assert off.max() > 3.0
    assert off[-1] < 0.02
    # The last two metres the reference stands: the person goes there by steps of its own.
    back = np.flatnonzero(off > 2.0)[-1]
    assert np.nanmean(hp.metrics.stance_slide(result).slide[back:]) < 0.004  # [m] a frame
    assert not result.lost_time.any()
    assert not len(result.breaches)
