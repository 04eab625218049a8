"""Worlds side by side equal simulators, each for itself."""

import copy

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.envs.robots import ARM, ARM_XML, efforts, model_of
from halfphysics.envs.worlds import Plan, Worlds
from halfphysics.errors import InputError
from halfphysics.scenarios.acting.acting import Act

DT = 1.0 / 30.0


def plan(**changes):
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_articulated("robot", model_of(ARM_XML), position=(2.0, 0.0, 0.0))
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(0.6, -0.4, 1.0), com=(0, 0, 0.01))
    given = {
        "scene": scene,
        "bodies": (hp.Body.default(),),
        "motors": efforts("robot", ARM.effort),
        "watched": ("ball", "person/right_wrist", "robot/hand"),
        "groups": {"ball": ("ball",), "ground": ("floor",), "person": ("person/*",)},
    }
    return Plan(**(given | changes))


@pytest.fixture(scope="module")
def motion():
    act = Act(hp.Body.default())
    act.move(0.0, 0.5, right_hold=1.0, right_hand=(0.4, -0.3, 1.0))
    return act.motion(1.0, 30.0)


def test_a_world_is_a_simulator(motion):
    """The same bits, where no motor is told anything but to stay: their springs rest at 0."""
    worlds = Worlds(plan(motors={}, watched=("ball",), groups={"ball": ("ball",)}), 2, dt=DT)
    sim = hp.Simulator(worlds.plan.scene, body=hp.Body.default(), fps=30)
    sim.reset(motion[0])
    for i in range(2):
        worlds.start(i, [motion[0]])
    for pose in motion[1:]:
        frame = sim.step(pose)
        worlds.step(np.tile(worlds.coordinates([pose]), (2, 1)), np.zeros((2, 0)))
    for i in range(2):
        assert np.array_equal(worlds.person_pose(i).rotations, frame.pose.rotations)
        position, quaternion = frame.objects["ball"]
        place = worlds.place("ball")[i]  # of its centre of mass
        assert place[:3] == pytest.approx(
            position + rot.rotate(quaternion, [0, 0, 0.01]), abs=1e-12
        )


def test_what_is_watched_and_what_touches(motion):
    worlds = Worlds(plan(), 1, dt=DT)
    worlds.start(0, [motion[0]], {"robot/lift": 0.5}, {"ball": ((3.0, 3.0, 0.2), (1, 0, 0, 0))})
    assert worlds.place("ball")[0, :3] == pytest.approx([3.0, 3.0, 0.21])
    assert worlds.motors[0, 0, 1] == 0.5
    wrist = hp.Body.default().joints(motion[:2])[0, 21]
    assert worlds.place("person/right_wrist")[0, :3] == pytest.approx(wrist, abs=1e-9)
    for _ in range(30):
        worlds.step(worlds.coordinates([motion[0]])[None], np.array([[0, 0.5, 0, 0, 0, 0.0]]))
    # The ball lies: the floor bears its weight, and the ball presses on the floor.
    assert worlds.force("ball", "ground")[0, 2] == pytest.approx(9.81, rel=0.02)
    assert worlds.force("ground", "ball")[0, 2] == pytest.approx(-9.81, rel=0.02)
    assert worlds.load("ball", "ground")[0] >= 9.6
    assert not worlds.touched("person")[0]
    assert worlds.names[worlds.contacts(0).other[0]] == "floor"


def test_an_object_is_held_until_the_world_starts_again(motion):
    worlds = Worlds(plan(), 1, dt=DT)
    worlds.start(0, [motion[0]])
    place = worlds.place("ball")[0].copy()
    worlds.attach(0, "ball", "right_wrist")
    assert worlds.holds(0, "ball")
    for _ in range(10):
        worlds.step(worlds.coordinates([motion[0]])[None], np.zeros((1, 6)))
    assert worlds.place("ball")[0, :3] == pytest.approx(place[:3], abs=0.02)  # it does not fall
    worlds.start(0, [motion[0]])
    assert not worlds.holds(0, "ball")


def test_copied_worlds_have_what_was_seen_and_go_on(motion):
    """Contacts of the last frame, holds, motors: all bits."""
    worlds = Worlds(plan(), 2, dt=DT)
    for i in range(2):
        worlds.start(i, [motion[0]], None, {"ball": ((3.0, 3.0, 0.1), (1, 0, 0, 0))})
    targets = np.tile(worlds.coordinates([motion[1]]), (2, 1))
    rests = np.full((2, 6), 0.02)
    worlds.step(targets, rests)
    worlds.attach(1, "ball", "head")
    other = copy.deepcopy(worlds)
    assert other.holds(1, "ball")
    assert not other.holds(0, "ball")
    for _ in range(3):
        for i in range(2):
            mine, theirs = worlds.contacts(i), other.contacts(i)
            assert i or len(mine.part)
            np.testing.assert_array_equal(theirs.impulse, mine.impulse)
            np.testing.assert_array_equal(theirs.other, mine.other)
            pose, same = worlds.person_pose(i), other.person_pose(i)
            np.testing.assert_array_equal(same.rotations, pose.rotations)
        for seen in ("poses", "motors", "impulses"):
            np.testing.assert_array_equal(getattr(other, seen), getattr(worlds, seen))
        worlds.step(targets, rests, np.array([True, False]))
        other.step(targets, rests, np.array([True, False]))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"watched": ("bal",)}, "watched: found 'bal'"),
        ({"watched": ("person/right_hand",)}, "watched"),
        ({"motors": {"robot/pen": 1.0}}, "motors: found 'robot/pen'"),
        ({"motors": {"rabot/pan": 1.0}}, "robot/pan"),
    ],
)
def test_names_that_are_not_there(changes, words):
    with pytest.raises(InputError, match=words):
        Worlds(plan(**changes), 1, dt=DT)


FINGER = """<mujoco><worldbody><body name="finger" pos="0 0 1">
<joint name="x" type="slide" axis="1 0 0" stiffness="{0}" damping="{1}"/>
<geom type="box" size=".02 .02 .02" mass="0.1"/></body></worldbody></mujoco>"""


@pytest.mark.parametrize("substeps", [4, 8])
@pytest.mark.parametrize("beyond", [0.03, 0.05, 0.1, 0.2])
@pytest.mark.parametrize("gains", [(1500, 60), (4000, 900)])
def test_a_motor_that_is_stopped_presses_with_its_effort(gains, beyond, substeps):
    """A finger at a wall, however far beyond it is told to go: K (r - q) is over its effort."""
    scene = hp.Scene()
    scene.add_articulated("it", model_of(FINGER.format(*gains)))
    scene.add_static("wall", hp.Box((0.2, 1.0, 1.0)), position=(0.125, 0.0, 1.0))
    plan = Plan(
        scene=scene,
        bodies=(),
        motors={"it/x": 25.0},
        watched=("it/finger",),
        groups={"finger": ("it/finger",), "wall": ("wall",)},
    )
    worlds = Worlds(plan, 1, dt=1 / 30, settings=hp.Settings(substeps=substeps))
    worlds.start(0, [])
    for _ in range(20):
        worlds.step(np.zeros((1, 0)), np.array([[beyond]]))
    assert worlds.force("finger", "wall")[0] == pytest.approx([-25.0, 0.0, 0.0], abs=1e-6)
