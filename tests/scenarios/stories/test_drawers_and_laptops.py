"""A drawer and a laptop's lid, moved by a hand: by their joints, to their stops, by its force."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.scenarios.props import chest, laptop
from halfphysics.scenarios.stories import close_laptop, open_drawer, open_laptop
from support.as_it_is import as_it_is
from support.joint_scenarios import MOVED, done
from support.judges.jointed import Jointed

#: Fingers whose joints have no stiffness bend rather than lift a lid.
LIMP = ("open_laptop", 0.0)
#: The hand is within this of the pushed link [m]: the clearance, 1 mm, and as much again.
TOUCH = 0.002
#: Pushing fingers bend back by this much [m], and touch at an angle.
GIVE = 0.025


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [0.0, 1.0])
@pytest.mark.parametrize("name", MOVED)
def test_it_moves_about_its_joint_to_its_stop_and_nobody_is_in_it(name, stiffness):
    _, result, thing, link, value = done(name, stiffness=stiffness)
    *_, start, end = MOVED[name]
    place, turn = thing.off()
    assert place < 1e-12
    assert turn < 1e-12
    assert thing.beyond() <= 0.0
    assert value[0] == start
    if (name, stiffness) != LIMP:
        np.testing.assert_allclose(np.abs(value - end).min(), 0.0, atol=1e-6)
        # A hand that unhooks may move it a little.
        assert abs(value[-1] - end) < 0.01 * abs(end - start)
    assert result.lost_time.sum() == 0.0
    force = np.linalg.norm(thing.force(link), axis=1)
    touched = np.flatnonzero(force > 0.5)
    assert len(touched) > 30
    # A light push: people move these objects with a few fingers.
    if (name, stiffness) != LIMP:
        assert 2.0 < force.max() < 25.0
    # Before the first contact it stood still.
    assert np.ptp(value[: touched[0]]) < 1e-6
    # Other joints keep their positions.
    own = [v for n, v in result.joints.items() if v is not value]
    assert all(np.ptp(v) == 0.0 for v in own)
    near = np.arange(max(0, touched[0] - 6), min(len(value), touched[-1] + 7), 2)
    gaps = thing.gap(near)
    assert gaps.min() > 0.0
    assert thing.gap(touched[2:-2:4], [link]).max() < TOUCH
    parts = {hp.JOINT_NAMES[p] for p in result.contacts.part[thing.rows(link)]}
    assert all(p.startswith("right_") for p in parts)


@pytest.mark.slow
@pytest.mark.parametrize("name", MOVED)
def test_the_motion_asked_for_goes_through_it(name):
    """The reference penetrates: the simulation prevents it, not the authored motion."""
    sequence, result, seen, *_ = done(name)
    asked, found = seen.penetration(sequence.motion), seen.penetration(result.motion)
    thing, link, *_ = MOVED[name]
    assert asked.by_name[f"{thing}/{link}"].max() > 3.0  # of half their 8 and 20 mm
    assert found.depth_max_mm == 0.0
    # The other judge detects it, too.
    frames = np.arange(0, len(sequence.motion), 4)
    assert seen.gap(frames, [link], sequence.motion).min() < -0.003


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [0.0, 1.0])
@pytest.mark.parametrize("name", MOVED)
def test_the_same_at_other_frame_rates(name, stiffness):
    *_, slow_thing, _, slow = done(name, 30.0, stiffness)
    *_, start, end = MOVED[name]
    way = abs(end - start)
    for fps in (60.0, 120.0):
        *_, thing, link, value = done(name, fps, stiffness)
        assert np.abs(value[:: round(fps / 30.0)] - slow).max() < 0.01 * way
        assert thing.result.lost_time.sum() == 0.0
        # And with the same push, over all of it [N s].
        given = np.linalg.norm(thing.force(link), axis=1).sum() / fps
        before = np.linalg.norm(slow_thing.force(link), axis=1).sum() / 30.0
        assert given == pytest.approx(before, rel=0.05)


@pytest.mark.parametrize("name", ["close_drawer", "open_drawer"])
def test_the_drawer_gets_what_the_hand_gives(name):
    """Impulse along the rail: momentum gained plus the loss to the rail's damping."""
    mass, damping = (hp.scenarios.options(name)[n] for n in ("mass", "damping"))
    sequence, _, thing, link, out = done(name, 120.0)
    fps, (*_, start, end) = sequence.motion.fps, MOVED[name]
    given = -np.cumsum(thing.force(link)[:, 0]) / fps  # the rail leads toward -x
    speed = np.gradient(out, 1.0 / fps)
    moved = np.abs(out - start) / abs(end - start)
    first = int(np.argmax(moved > 0.05))  # off its first stop, which also gave an impulse
    for share in (0.3, 0.5, 0.8):  # before contact with the other stop
        t = int(np.argmax(moved > share))
        expected = mass * (speed[t] - speed[first]) + damping * (out[t] - out[first])
        assert given[t] - given[first] == pytest.approx(expected, rel=0.02)
        assert abs(given[t]) > 1.0


def test_the_drawer_goes_with_the_finger_pads():
    """By the intended distance, from the contact with the front to the front's stop."""
    sequence, result, thing, link, out = done("close_drawer", 60.0, 1.0)
    skin = sequence.body.vertices(sequence.motion)
    part = np.argmax(sequence.body.weights, axis=1)
    hand = np.isin(part, [k for k, n in enumerate(hp.JOINT_NAMES) if n == "right_middle3"])
    ahead = np.array([v[hand, 0].max() for v in skin])
    front = result.objects["chest/top"].position[:, 0]
    pushing = (np.linalg.norm(thing.force(link), axis=1) > 0.5) & (out > 0.005)
    assert pushing.sum() > 20
    assert np.ptp(out[pushing]) > 0.2
    np.testing.assert_allclose(front[pushing], ahead[pushing], atol=GIVE)
    np.testing.assert_allclose(np.ptp(front), 0.28, atol=1e-6)
    assert ahead.max() > front.max() + 0.01  # and the reference goes on


def test_the_lid_gets_what_the_fingers_give():
    """Moment about the hinge: angular momentum, damping and weight."""
    mass, damping = (hp.scenarios.options("close_laptop")[n] for n in ("mass", "damping"))
    sequence, result, thing, link, angle = done("close_laptop", 120.0)
    fps, contacts = sequence.motion.fps, result.contacts
    rows = thing.rows(link)
    hinge = np.add(close_laptop.HINGE, (0.0, 0.0, laptop.hinge_height()))
    moment = np.zeros(len(angle))
    twist = np.cross(contacts.position[rows] - hinge, -contacts.impulse[rows])[:, 1]
    np.add.at(moment, contacts.frame[rows], twist)
    half = 0.5 * np.array([laptop.DEPTH, laptop.LID])
    about = mass * ((half**2).sum() * 4.0 / 3.0)
    # The lid's centre is this far before the hinge; its weight shuts the lid.
    before = half[0] * np.cos(angle) - half[1] * np.sin(angle)
    weight = np.cumsum(-mass * 9.81 * before) / fps
    speed = np.gradient(angle, 1.0 / fps)
    start = int(np.argmax(angle < angle[0] - 0.05))  # off the stop, which gives moments, too
    for share in (0.8, 0.5, 0.1):
        end = int(np.argmax(angle < share * angle[0]))
        expected = about * (speed[end] - speed[start]) + damping * (angle[end] - angle[start])
        given = moment[start + 1 : end + 1].sum() + weight[end] - weight[start]
        assert given == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("scenario", [close_laptop, open_laptop])
def test_the_lid_goes_with_the_fingers(scenario):
    name = scenario.__name__.rsplit(".", 1)[1]
    *_, angle = done(name, 30.0, 1.0)
    times = np.arange(len(angle)) / 30.0
    meant = scenario.lid_angle(times)
    moving = (meant > 0.1) & (meant < laptop.OPEN - 0.3)
    assert moving.sum() > 20
    assert np.abs(angle - meant)[moving].max() < GIVE / scenario.ALONG


def test_the_drawer_goes_with_the_hooked_fingers():
    *_, out = done("open_drawer", 30.0, 1.0)
    meant = open_drawer.meant(np.arange(len(out)) / 30.0, 0.015)
    moving = (meant > 0.03) & (meant < chest.TRAVEL)
    assert moving.sum() > 10
    assert np.abs(out - meant)[moving].max() < GIVE


@pytest.mark.parametrize("stiffness", [0.0, 1.0])
def test_a_door_that_swings_to_its_stop(stiffness):
    """The same judge, for a door whose hinge hardly holds it back."""
    sequence = hp.scenarios.load("push_door", damping=0.05)
    settings = as_it_is(stiffness=stiffness)
    result = hp.simulate(sequence.motion, sequence.scene, body=sequence.body, settings=settings)
    thing, angle = Jointed(result, "door"), result.joints["door/hinge"]
    assert max(thing.off()) < 1e-12
    assert thing.beyond() <= 0.0
    assert np.radians(110.0) - angle.max() < 1e-6
    assert result.lost_time.sum() == 0.0
    touched = np.flatnonzero(np.linalg.norm(thing.force("panel"), axis=1) > 0.5)
    assert len(touched) > 3
    near = np.arange(max(0, touched[0] - 6), min(len(angle), touched[-1] + 12), 3)
    assert thing.gap(near).min() > 0.0


@pytest.mark.parametrize("name", MOVED)
def test_motions_are_smooth_and_wrists_bend_as_wrists_do(name):
    fps = 120.0
    sequence = hp.scenarios.load(name, fps=fps)
    motion, body = sequence.motion, sequence.body
    joints = body.joints(motion)
    assert np.linalg.norm(np.diff(joints, axis=0), axis=-1).max() * fps < 3.0
    assert np.linalg.norm(np.diff(joints, 2, axis=0), axis=-1).max() * fps**2 < 40.0
    slow = body.joints(hp.scenarios.load(name, fps=30.0).motion)
    assert np.abs(joints[::4][: len(slow)] - slow).max() < 1e-9
    elbow, wrist, knuckle = (
        joints[:, hp.JOINT_NAMES.index(f"right_{n}")] for n in ("elbow", "wrist", "middle1")
    )
    fore, hand = wrist - elbow, knuckle - wrist
    cosine = np.sum(fore * hand, axis=1) / np.prod(
        [np.linalg.norm(v, axis=1) for v in (fore, hand)], axis=0
    )
    assert np.degrees(np.arccos(cosine)).max() < 95.0


def test_limp_fingers_bend_and_do_not_lift_the_lid():
    """The lid moves a person without stiffness, not the reverse; the fingers stay below it."""
    sequence, result, *_, angle = done("open_laptop")
    assert angle.max() < 0.5 * laptop.OPEN
    knuckles = [k for k, n in enumerate(hp.JOINT_NAMES) if n.startswith("right_middle")]
    wrist = hp.JOINT_NAMES.index("right_wrist")
    bent = np.abs(result.motion.rotations - sequence.motion.rotations)[:, [wrist, *knuckles]]
    firm = done("open_laptop", 30.0, 1.0)[1].motion.rotations - sequence.motion.rotations
    assert bent.max() > 2.0 * np.abs(firm[:, [wrist, *knuckles]]).max()


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("close_drawer", {"mass": 0.0}, "mass"),
        ("close_drawer", {"damping": -1.0}, "damping"),
        ("close_drawer", {"travel": chest.TRAVEL + 0.01}, "travel"),
        ("close_laptop", {"mass": 0.0}, "mass"),
        ("close_laptop", {"press": 1.0}, "press"),
        ("open_drawer", {"beyond": 0.2}, "beyond"),
        ("open_laptop", {"press": -0.1}, "press"),
        ("open_laptop", {"damping": -1.0}, "damping"),
    ],
)
def test_impossible_options_are_refused(name, options, words):
    with pytest.raises(InputError, match=words):
        hp.scenarios.load(name, **options)
