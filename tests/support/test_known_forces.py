"""What is known to act: things that are carried, and other people, in simulated results."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.support.known_forces import givers_of
from support import standing
from support.people import t_pose

G = 9.81


@pytest.fixture(scope="module")
def body():
    return hp.Body.default(stature=1.75, mass=70.0)


@pytest.fixture(scope="module")
def holding(body):
    """A person with a box of 10 kg across both forearms."""
    level = {
        "left_shoulder": (0.0, 0.0, -1.45),
        "right_shoulder": (0.0, 0.0, 1.45),
        "left_elbow": (0.0, -1.7, 0.0),
        "right_elbow": (0.0, 1.7, 0.0),
    }
    motion = standing.standing(body, arms=level, frames=120)
    elbow = body.joints(motion[0])[[18, 19]].mean(axis=0)
    wrist = body.joints(motion[0])[[20, 21]].mean(axis=0)
    middle = 0.1 * elbow + 0.9 * wrist
    skin = body.vertices(motion[0])[
        np.isin(body.weights.argmax(axis=1), [18, 19, 20, 21, *range(25, 55)])
    ]
    top = skin[np.abs(skin[:, 0] - middle[0]) < 0.07, 2].max()
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object(
        "box", hp.Box((0.12, 0.7, 0.1)), mass=10.0, position=(*middle[:2], top + 0.051)
    )
    return hp.simulate(motion, scene, body=body, settings=hp.Settings(stiffness=10.0))


def test_who_holds_ten_kilograms_stands_on_both_weights(holding):
    support = holding.people[0].support
    late = slice(80, 110)
    carried = holding.objects["box"].position[late, 2]
    assert np.ptp(carried) < 0.01, "the box is not held"
    assert support.names == ("floor", "box")
    on_floor, _ = support.surface("floor")
    by_box, _ = support.surface("box")
    assert by_box[late, 2] == pytest.approx(-10.0 * G, rel=0.01)
    assert on_floor[late, 2] == pytest.approx(80.0 * G, rel=0.01)
    assert np.abs(support.residual[late, :3]).max() < 0.01 * 80.0 * G
    assert not support.unsupported[late].any()


def test_the_arms_bear_it(holding):
    """The elbows' torques are larger by half the box's weight times its arm."""
    person = holding.people[0]
    bare = hp.support.estimate(person.motion, holding.scene, body=person.body)
    with_box = np.linalg.norm(person.support.torque[90, [18, 19]], axis=-1)
    without = np.linalg.norm(bare.torque[90, [18, 19]], axis=-1)
    assert (with_box > without + 3.0).all()


def test_only_what_moves_is_known(holding):
    assert givers_of(holding.scene, holding.names, len(holding.names) - 1) == [1]


def test_support_is_computed_once_and_not_saved(holding, tmp_path):
    person = holding.people[0]
    assert person.support is person.support
    holding.save(tmp_path / "r.npz")
    loaded = hp.Result.load(tmp_path / "r.npz").people[0].support
    assert np.array_equal(loaded.total, person.support.total)


def test_two_people_push_each_other(body):
    """Forces between two people are equal and opposite, and both stand on the floor."""
    arms = {"left_shoulder": (0.0, -1.4, 0.0), "right_shoulder": (0.0, 1.4, 0.0)}
    one = standing.standing(body, arms=arms, frames=40)
    pelvis = body.rest_joints[0]
    place = one.translation + pelvis
    meet = body.vertices(one[0])[:, 0].max() + 0.01
    opposite = place.copy()
    opposite[:, 0] = 2.0 * meet - place[:, 0]
    turned = one.rotations.copy()
    half = rot.exp([0.0, 0.0, np.pi])
    turned[:, 0] = rot.log(rot.multiply(half, rot.exp(one.rotations[:, 0])))
    other = hp.Motion(opposite - pelvis, turned, one.fps)
    nearer = np.outer(np.linspace(0.0, 0.05, 40), [1.0, 0.0, 0.0])
    one = hp.Motion(one.translation + nearer, one.rotations, one.fps)
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    result = hp.simulate([one, other], scene, body=[body, body])
    first, second = (person.support for person in result.people)
    pushed = first.force[:, first.names.index(result.people[1].name)]
    back_on = second.force[:, second.names.index(result.people[0].name)]
    assert np.abs(pushed).max() > 5.0, "they do not touch"
    assert pushed == pytest.approx(-back_on, abs=1e-6 + 1e-3 * np.abs(pushed).max())
    for support in (first, second):
        assert np.abs(support.weight_percent - 100.0)[5:-5].max() < 25.0


def test_a_person_of_no_result_has_no_support(holding):
    alone = dataclasses.replace(holding.people[0], body=holding.people[0].body, surroundings=None)
    with pytest.raises(hp.errors.InputError, match="no result that it is of"):
        _ = alone.support


def test_a_touch_long_before_a_jump_takes_no_flight_away(body):
    """The filter leaves traces of any force everywhere: none of them holds a jumper up."""
    fps, frames, off, speed = 30.0, 75, 1.6, 2.0
    since = np.arange(frames) / fps - off
    height = np.clip(speed * since - 0.5 * G * since**2, 0.0, None) * (since > 0.0)
    stand = t_pose(np.zeros((frames, 3)), fps).grounded(body)
    motion = hp.Motion(stand.translation + np.outer(height, (0.0, 0.0, 1.0)), stand.rotations, fps)
    found = []
    for touched in (False, True):
        scene = hp.Scene()
        scene.add_static("floor", hp.Plane())
        if touched:
            scene.add_object(
                "ball", hp.Sphere(0.1), mass=0.4, position=(0.8, -0.4, 1.25), velocity=(-4, 0, 0)
            )
        result = hp.simulate(motion, scene, body=body)
        if touched:
            ball = result.names.index("ball")
            felt = result.contacts.frame[result.contacts.other == ball]
            assert len(felt)
            assert felt.max() < off * fps - 20
        found.append(result.people[0].support)
    alone, hit = found
    assert alone.airborne.sum() > 10
    np.testing.assert_array_equal(hit.airborne, alone.airborne)
    late = slice(int(off * fps) - 10, None)
    np.testing.assert_allclose(hit.residual_percent[late], alone.residual_percent[late], atol=0.1)
    # Where the ball neither touches nor carries it has no centre of pressure.
    cop = np.isfinite(hit.surface("ball")[1]).all(axis=1)
    cop[hit.pressure.frame[hit.pressure.surface == hit.names.index("ball")]] = False
    assert cop.any()
    assert np.abs(np.flatnonzero(cop)[:, None] - felt).min(axis=1).max() <= 5
