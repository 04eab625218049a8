"""HumanCLAW's measures: closed forms, and results made by simulation."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.metrics.humanclaw import motion_jerk, report
from halfphysics.results.contacts import Contacts
from halfphysics.results.object_track import ObjectTrack
from halfphysics.results.result import PersonResult
from support.live_frames import BODY, t_pose


def moved(path):
    """A T-pose that goes along a path (T, 3) at 30 fps."""
    path = np.asarray(path, dtype=np.float64)
    rotations = np.tile(t_pose().rotations, (len(path), 1, 1))
    return hp.Motion(t_pose().translation + path, rotations, 30.0)


def test_jerk_of_a_cubic_path_is_its_third_derivative():
    """x = j t^3 / 6 has the jerk j everywhere; the moving average only adds a line to it."""
    t = np.arange(90) / 30.0
    path = np.stack([0.5 * t**3 / 6.0, np.zeros(90), np.zeros(90)], axis=1)
    assert motion_jerk(moved(path), BODY) == pytest.approx(0.5, rel=1e-9)
    assert motion_jerk(moved(path * 0.0 + t[:, None]), BODY) == pytest.approx(0.0, abs=1e-9)


def test_jerk_of_a_turn_is_by_their_formula():
    """Articulation is frozen: only the root's turn counts, at joints of the rest pose."""
    turn = 0.8 * np.sin(3.0 * np.arange(60) / 30.0)
    motion = moved(np.zeros((60, 3)))
    rotations = motion.rotations.copy()
    base = hp.Motion(motion.translation, rotations, 30.0)
    from halfphysics.base import rotations as rot

    rotations[:, 0] = rot.log(
        rot.multiply(rot.exp(turn[:, None] * [0.0, 0.0, 1.0]), rot.exp(rotations[:, 0]))
    )
    still = hp.Motion(motion.translation, rotations, 30.0)
    rotations[:, 16] = np.random.default_rng(1).normal(size=(60, 3))
    restless = hp.Motion(motion.translation, rotations, 30.0)
    assert motion_jerk(restless, BODY) == motion_jerk(still, BODY) > motion_jerk(base, BODY)
    joints = BODY.joints(still)[:, :22]
    smooth = np.stack([joints[k : k + 3].mean(axis=0) for k in range(58)])
    third = smooth[24:] - 3 * smooth[16:-8] + 3 * smooth[8:-16] - smooth[:-24]
    expected = np.linalg.norm(third / (8 / 30) ** 3, axis=2).mean()
    assert motion_jerk(still, BODY) == pytest.approx(expected, rel=1e-9)
    assert np.isnan(motion_jerk(motion[:20], BODY))


@pytest.fixture(scope="module")
def pushed():
    """A person who walks into a wall with a T-pose's arm, and pushes a ball into another."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_static("wall", hp.Box((0.1, 2.0, 1.2)), position=(1.05, 0.0, 1.4))
    ball = hp.Sphere(0.15)
    scene.add_object("first", ball, mass=1.0, position=(0.42, 0.0, 0.151))
    scene.add_object("second", ball, mass=1.0, position=(0.77, 0.0, 0.151))
    scene.add_object("apart", ball, mass=1.0, position=(0.0, 3.0, 0.151))
    way = np.zeros((40, 3))
    way[:, 0] = np.minimum(np.arange(40) / 30.0, 0.6)
    return hp.simulate(moved(way), scene, body=BODY, settings=hp.Settings(weight=False))


def test_collisions_are_above_the_floor_and_by_part(pushed):
    found = report(pushed, floor=0.0)
    contacts = pushed.contacts
    wall = pushed.names.index("wall")
    frames = np.unique(contacts.frame[(contacts.person == 0) & (contacts.other == wall)])
    assert len(frames) > 0
    assert found.collision_percent == pytest.approx(100.0 * len(frames) / 40)
    assert found.collision_groups["arm and hand"] == found.collision_percent
    assert found.collision_groups["leg and foot"] == 0.0, "feet touch the floor only"
    halves = report(pushed, floor=0.0, step_starts=[0, 20])
    assert halves.collision_percent == 50.0 * len(set((frames >= 20).tolist()))


def test_what_was_moved_through_another_counts(pushed):
    found = report(pushed)
    tracks = pushed.objects
    assert (found.disturbed, found.escaped) == (2, 0)
    path = {
        name: np.linalg.norm(np.diff(tracks[name].position, axis=0), axis=1).sum()
        for name in ("first", "second", "apart")
    }
    assert path["apart"] < 1e-3 < path["second"]
    # The way of the frame in which an object is first touched lies before that frame.
    whole = (path["first"] + path["second"]) / 2
    assert whole - 0.05 < found.disturbance <= whole


@pytest.mark.parametrize("starts", [[], [3, 2], [0, 40], [0.5], [[0]]])
def test_steps_that_are_none_are_said(pushed, starts):
    with pytest.raises(InputError, match="step_starts"):
        report(pushed, step_starts=starts)


def test_what_goes_its_own_way_disturbs_nothing():
    """A belt that a person touches carries a cup along: neither is the person's doing."""
    frames = 31
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    path = np.zeros((frames, 3))
    path[:, 0], path[:, 2] = np.arange(frames) / 30.0, 0.1
    upright = np.tile([1.0, 0.0, 0.0, 0.0], (frames, 1))
    scene.add_moving("belt", hp.Box((4.0, 4.0, 0.2)), path, upright, fps=30.0)
    scene.add_object("cup", hp.Sphere(0.05), mass=0.2, position=(1.0, 0.0, 0.25))
    names = ("floor", *scene.objects, "person")
    belt, cup = names.index("belt"), names.index("cup")
    motion = moved(path)
    carried = {
        "belt": ObjectTrack(position=path, quaternion=upright),
        "cup": ObjectTrack(position=np.add(path, (1.0, 0.0, 0.15)), quaternion=upright),
    }
    contacts = Contacts(
        frame=np.array([1, 2]),
        person=np.array([0, -1]),
        part=np.array([10, -1]),
        other=np.array([belt, belt]),
        position=np.zeros((2, 3)),
        normal=np.tile([0.0, 0.0, 1.0], (2, 1)),
        impulse=np.tile([0.0, 0.0, 1.0], (2, 1)),
        subject=np.array([-1, cup]),
        other_part=np.array([-1, -1]),
    )
    person = PersonResult(name="person", motion=motion, reference=motion, body=BODY)
    result = hp.Result(
        people=(person,),
        objects={name: carried[name] for name in scene.objects},
        scene=scene,
        names=names,
        contacts=contacts,
        clearance=np.zeros(frames),
        lost_time=np.zeros(frames),
        settings=hp.Settings(),
    )
    found = report(result)
    assert found.disturbed == 0
    assert np.isnan(found.disturbance)


CABINET = """
<mujoco><worldbody><body name="case" pos="0 0 1"><geom type="box" size=".3 .3 .3"/>
<body name="door" pos="0 -.35 0"><joint axis="0 0 1"/><geom type="box" size=".3 .02 .3" mass="1"/>
</body></body></worldbody></mujoco>"""


def test_what_no_joint_moves_is_fixed(tmp_path):
    """A cabinet's case is, as a static is; its door is not."""
    path = tmp_path / "cabinet.xml"
    path.write_text(CABINET)
    scene = hp.Scene()
    scene.add_static("wall", hp.Box((0.1, 0.1, 0.1)), position=(9.0, 9.0, 9.0))
    scene.add_articulated("cabinet", path, position=(3.0, 0.0, 0.0))
    result = hp.simulate(moved(np.zeros((10, 3))), scene, body=BODY)
    for name, percent in (("wall", 50.0), ("cabinet/case", 50.0), ("cabinet/door", 0.0)):
        contacts = Contacts(
            frame=np.arange(5, 10),
            person=np.zeros(5, dtype=int),
            part=np.full(5, 20),
            subject=np.full(5, -1),
            other=np.full(5, result.names.index(name)),
            other_part=np.full(5, -1),
            position=np.tile([0.0, -0.5, 1.0], (5, 1)),
            normal=np.tile([0.0, -1.0, 0.0], (5, 1)),
            impulse=np.tile([0.0, -5.0, 0.0], (5, 1)),
        )
        touched = dataclasses.replace(result, contacts=contacts)
        assert report(touched, floor=0.0).collision_percent == percent, name


@pytest.mark.parametrize("floor", ["low", float("nan"), [0.0, 1.0]])
def test_what_is_no_result_and_no_floor(pushed, floor):
    with pytest.raises(InputError, match=r"result: expected a halfphysics\.Result"):
        report(pushed.people[0].motion)
    with pytest.raises(InputError, match="floor: "):
        report(pushed, floor=floor)
