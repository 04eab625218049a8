"""`hp.fix`: what it finds, what it leaves, several people, scenes, mistakes."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.repair.report import measures
from support.damage import FLOATING, floating, noisy, sunk
from support.made_clips import standing
from support.real_clips import real_clip
from support.stools import room, seated

#: A clip that floats in all is put down to this [m].
DOWN = 0.005


def lowest(motion):
    return float(hp.Body.default().vertices(motion)[..., 2].min())


def test_who_stands_right_comes_back_bit_by_bit():
    asked = standing()
    repair = hp.fix(asked)
    assert repair.done == repair.left == ()
    assert repair.motion is asked


def test_who_floats_is_put_down():
    repair = hp.fix(floating(standing(), hp.Body.default()))
    assert abs(lowest(repair.motion)) < DOWN
    assert any("floated by 5.0 cm" in line for line in repair.done)
    error = {m.name: m for m in measures(repair)}["Float"]
    assert error.before > 1000 * FLOATING - 1.0
    assert error.after == 0.0


def test_the_origin_of_an_estimator_may_be_the_pelvis():
    high = standing()
    far = high.with_frames(high.translation + np.array([0.0, 0.0, 3.0]), high.rotations)
    repair = hp.fix(far)
    assert abs(lowest(repair.motion)) < DOWN
    assert any("floated by 300" in line for line in repair.done)


def test_where_no_sole_rests_the_height_stays():
    """Somebody who falls from far above: nothing tells where the ground is."""
    high = standing(20)
    time = np.arange(20) / 30.0
    fall = np.outer(50.0 - 2.0 * time - 0.5 * 9.81 * time**2, [0.0, 0.0, 1.0])
    motion = high.with_frames(high.translation + fall, high.rotations)
    repair = hp.fix(motion, plant=False)
    assert any("height and axes stay" in line for line in repair.left)
    asked = repair.result.people[0].reference
    assert np.array_equal(asked.translation, motion.translation)


def test_a_clip_that_is_right_though_no_sole_rests_comes_back():
    """Somebody sits on a bar stool: feet hang over the floor, and nothing floats."""
    motion, place = seated(0.75)
    repair = hp.fix(motion, room(0.75, place))
    assert repair.done == ()
    assert any("height and axes stay" in line for line in repair.left)
    assert repair.motion is motion


@pytest.mark.parametrize("kind", ["static", "object"])
def test_what_people_stand_on_may_be_an_object(kind):
    scene, height = hp.Scene(), 0.25
    scene.add_static("floor", hp.Plane())
    asked = standing()
    place = hp.Body.default().joints(asked)[0, 0]
    box, at = hp.Box((1.2, 1.2, height)), (place[0], place[1], 0.5 * height)
    if kind == "static":
        scene.add_static("podium", box, position=at)
    else:
        scene.add_object("podium", box, mass=40.0, position=at)
    asked = asked.with_frames(asked.translation + np.array([0.0, 0.0, height]), asked.rotations)
    repair = hp.fix(asked, scene)
    assert repair.done == repair.left == ()
    assert repair.motion is asked


def test_people_in_each_other_are_moved_apart():
    """They stand in each other in the middle of the clip only, and the docs promise under 5 mm."""
    one = standing(60)
    near = 1.5 - 1.2 * np.sin(np.pi * np.arange(60) / 59.0)
    other = one.with_frames(one.translation + np.outer(near, [1.0, 0.0, 0.0]), one.rotations)
    repair = hp.fix([one, other], plant=False, level=False)
    assert "people were inside each other: moved apart" in repair.done
    deepest = {m.name: m for m in measures(repair)}["deepest in the scene"]
    assert deepest.before > 20.0
    assert deepest.after < 5.0


def test_a_cutoff_from_half_the_rate_on_does_nothing():
    asked = standing()
    for cutoff in (15.0, 50.0):
        repair = hp.fix(asked, smooth=cutoff)
        assert repair.done == ()
        assert repair.motion is asked


def test_steps_can_be_left_out():
    bad = sunk(standing(), hp.Body.default())
    repair = hp.fix(bad, level=False, plant=False)
    assert not any("sunk" in line for line in repair.done)
    assert lowest(repair.motion) > -DOWN  # the simulation still keeps it out of the floor


def test_a_scene_is_respected():
    """Somebody glides ahead (along -y) into a wall and stays in it, the wall 0.5 m ahead."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    still = standing(60)
    pelvis = hp.Body.default().joints(still)[0, 0]
    scene.add_static("wall", hp.Box((4.0, 0.1, 3.0)), position=(0.0, pelvis[1] - 0.5, 1.5))
    way = np.outer(np.minimum(np.arange(60) / 40.0, 1.0), [0.0, -0.45, 0.0])
    ghost = still.with_frames(still.translation + way, still.rotations)
    repair = hp.fix(ghost, scene, plant=False)
    deepest = {m.name: m for m in measures(repair)}["deepest in the scene"]
    assert deepest.before > 40.0
    assert deepest.after < 1.0
    assert "Float" not in {m.name for m in measures(repair)}


def test_two_people_have_one_ground():
    body = hp.Body.default()
    one = floating(standing(), body)
    other = one.with_frames(one.translation + np.array([0.0, 1.5, 0.0]), one.rotations)
    repair = hp.fix([one, other])
    heights = [lowest(motion) for motion in repair.motions]
    assert max(map(abs, heights)) < DOWN
    assert len(repair.originals) == len(repair.result.people) == 2


def test_what_comes_out_keeps_its_file_and_says_what_came_in():
    walk = real_clip("asap_walk1.npz")
    repair = hp.fix(walk)
    assert repair.motion.origin is not None
    assert repair.motion.origin.format == walk.origin.format
    assert repair.motion.recorded is None
    assert np.array_equal(repair.result.people[0].recorded.translation, walk.translation)


def test_the_same_input_gives_the_same_bytes():
    walk = real_clip("asap_walk1.npz")[:40]
    made = [hp.fix(walk).motion for _ in range(2)]
    assert np.array_equal(made[0].rotations, made[1].rotations)
    assert np.array_equal(made[0].translation, made[1].translation)


def test_a_second_repair_finds_nothing():
    body = hp.Body.default()
    bad = noisy(real_clip("asap_kick1.npz").grounded(body)[:70], body)
    once = hp.fix(bad)
    assert any("kept in place" in line for line in once.done)
    again = hp.fix(once.motion)
    assert again.done == ()
    assert again.motion is once.motion


def test_mistakes_are_one_message():
    with pytest.raises(InputError, match="expected a Motion"):
        hp.fix([])
    with pytest.raises(InputError, match="found 40 frames at 30 fps beside 30"):
        hp.fix([standing(30), standing(40)])
    with pytest.raises(InputError, match="found 1, expected one for each of 2"):
        hp.fix([standing(), standing()], body=[hp.Body.default()])
    with pytest.raises(InputError, match="smooth"):
        hp.fix(standing(), smooth=-1.0)
    for wrong, way in (("clip.npz", "Motion.load"), (None, "found None"), (3, "found 3")):
        with pytest.raises(InputError, match=rf"motion: .*expected a halfphysics\.Motion|{way}"):
            hp.fix(wrong)
    with pytest.raises(InputError, match=r"such as its \.motion"):
        hp.fix(hp.simulate(standing()))


@pytest.mark.parametrize(
    ("option", "wrong", "message"),
    [
        ("scene", "room.yaml", r"scene: found 'room\.yaml'.*Scene\.load"),
        ("body", "SMPLX.npz", r"body: found 'SMPLX\.npz'.*Body\.load"),
        ("body", [3], "body: found 3"),
        ("body", 3, "body: found 3"),
        ("settings", {"stiffness": 1.0}, "settings: found .*Settings"),
    ],
)
def test_wrong_options_are_named(option, wrong, message):
    with pytest.raises(InputError, match=message):
        hp.fix(standing(), **{option: wrong})
