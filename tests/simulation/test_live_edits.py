"""A running simulation: pushes, and added and removed objects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from halfphysics import scenarios
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.simulation.live_edits import rebuilt
from halfphysics.simulation.simulator import Simulator
from support.people import along_x, t_pose


def as_parts(settings):
    return replace(settings, contact="parts")


def alone(scene):
    simulator = Simulator(scene, body=[])
    simulator.reset([])
    return simulator


def crate(gravity=0.0, **options):
    scene = Scene(gravity=gravity)
    given = {"mass": 2.5, "com": (0.05, -0.02, 0.1), "position": (1, 2, 3)} | options
    given.setdefault("quaternion", rot.exp([0.3, -0.8, 0.5]))
    scene.add_object("crate", Box((0.4, 0.3, 0.6)), **given)
    return scene


def test_an_impulse_is_mass_times_velocity_and_turns_about_the_centre():
    scene = crate(velocity=(1, 0, 0))
    simulator = alone(scene)
    thing = scene.objects["crate"]
    p, r, more = np.array([0.3, -1.2, 2.0]), np.array([1.1, 2.2, 2.9]), np.array([0.1, 0.0, -0.2])
    turn = rot.to_matrix(thing.quaternion)
    centre = thing.position + turn @ thing.com
    v0, w0 = simulator.velocity("crate")
    np.testing.assert_allclose(v0, [1, 0, 0], atol=1e-15)
    simulator.apply_impulse("crate", p, point=r, angular=more)
    v, w = simulator.velocity("crate")
    inertia = turn @ thing.inertia @ turn.T
    np.testing.assert_allclose(inertia @ (w - w0), np.cross(r - centre, p) + more, atol=1e-14)
    arm = turn @ thing.com
    before, after = v0 + np.cross(w0, arm), v + np.cross(w, arm)
    np.testing.assert_allclose(thing.mass * (after - before), p, atol=1e-14)
    simulator.step([])
    moved = simulator.step([]).objects["crate"]
    now = moved[0] + rot.rotate(moved[1], thing.com)
    np.testing.assert_allclose(now, centre + after * 2 / 30, atol=1e-12)  # the centre goes straight


def test_at_the_centre_it_does_not_turn():
    simulator = alone(crate())
    simulator.apply_impulse("crate", (0, 5, 0))
    v, w = simulator.velocity("crate")
    np.testing.assert_allclose(v, [0, 2, 0], atol=1e-15)
    assert np.abs(w).max() == 0.0


def test_a_velocity_that_is_set_is_that_of_a_start():
    moving = {"velocity": (1, -2, 0.5), "angular_velocity": (0.2, 3, -1)}
    a, b = alone(crate(9.81, **moving)), alone(crate(9.81))
    b.set_velocity("crate", moving["velocity"], moving["angular_velocity"])
    np.testing.assert_allclose(b.velocity("crate"), a.velocity("crate"), atol=1e-14)
    for _ in range(20):
        x, y = a.step([]).objects["crate"], b.step([]).objects["crate"]
    np.testing.assert_allclose(x[0], y[0], atol=1e-12)
    np.testing.assert_allclose(x[1], y[1], atol=1e-12)
    b.set_velocity("crate", (0, 0, 1))  # the spin stays
    np.testing.assert_allclose(b.velocity("crate")[1], a.velocity("crate")[1], atol=1e-12)


def test_gravity_is_a_vector_and_objects_start_with_their_velocity():
    g, v = np.array([1.0, -2.0, 0.5]), np.array([3.0, 1.0, -1.0])
    scene = Scene(gravity=g)
    scene.add_object("ball", Sphere(0.1), mass=1.0, velocity=v)
    simulator = Simulator(scene, body=[])
    simulator.reset([])
    n = simulator.settings.substeps_for(simulator.dt)
    for _ in range(30):
        frame = simulator.step([])
    h = simulator.dt / n
    # Symplectic Euler's own parabola.
    np.testing.assert_allclose(frame.objects["ball"][0], v + 0.5 * g * (1 + h), atol=1e-12)


def test_what_is_ignored_passes_through():
    scene = Scene(gravity=0.0)
    scene.add_object("a", Sphere(0.1), mass=1.0, position=(-1, 0, 0), velocity=(2, 0, 0))
    scene.add_object("b", Sphere(0.1), mass=1.0)
    scene.ignore("a", "b")
    simulator = alone(scene)
    frames = [simulator.step([]) for _ in range(30)]
    np.testing.assert_allclose(frames[-1].objects["a"][0], [1, 0, 0], atol=1e-12)
    assert (frames[-1].objects["b"][0] == 0.0).all()


def test_it_wakes_what_is_asleep():
    simulator = alone(crate(9.81, start="asleep"))
    assert (simulator.step([]).objects["crate"][0] == [1, 2, 3]).all()
    simulator.apply_impulse("crate", (0, 0, 0))
    for _ in range(30):
        frame = simulator.step([])
    assert frame.objects["crate"][0][2] < 0.0


def with_person():
    scene = Scene()
    scene.add_static("floor", Plane(offset=-5.0))
    scene.add_static("wall", Box((0.1, 6, 6)), position=(0.6, 0, 0))
    scene.add_static("desk", Box((1, 1, 0.1)), position=(-2, 0, 0))
    scene.add_object("book", Box((0.2, 0.3, 0.05)), mass=1, position=(-2, 0, 0.0752))
    scene.add_object("ball", Sphere(0.1), mass=1, position=(3, 0, 0), velocity=(1, 0, 0))
    return scene


def test_what_comes_and_goes_far_away_changes_nothing():
    """During a press against a wall, with a resting book nearer than the clearance."""
    body, motion = Body.default(), along_x(1.5, 40, start=-0.4)
    scene = with_person()
    a, b = (Simulator(scene, body=body) for _ in range(2))
    a.reset(motion[0])
    b.reset(motion[0])
    for t in range(1, 40):
        if t == 20:
            b.add_object("lamp", Sphere(0.1), mass=1.0, position=(0, 30, 0))
            assert "lamp" in b.names
        if t == 30:
            b.remove_object("lamp")
            assert b.names == a.names
        x, y = a.step(motion[t]), b.step(motion[t])
        # Only the order of equal candidates may differ.
        np.testing.assert_allclose(
            y.pose.translation, x.pose.translation, atol=1e-12 if t <= 20 else 1e-5
        )
        for name in scene.objects:
            np.testing.assert_allclose(y.objects[name][0], x.objects[name][0], atol=1e-6)
    assert list(scene.objects) == ["book", "ball"]  # the user's own
    assert x.clearance < 2e-3  # pressed


def test_what_comes_is_what_a_fresh_start_has():
    """An added ball behaves as the same ball in a simulation of its own."""
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object("box", Box((0.2, 0.2, 0.2)), mass=1, position=(3, 0, 0.1))
    late = alone(scene)
    for _ in range(7):
        late.step([])
    options = {"mass": 1.0, "position": (0, 0, 1), "velocity": (1, 0, 0), "restitution": 0.5}
    late.add_object("ball", Sphere(0.1), **options)
    fresh = Scene()
    fresh.add_static("floor", Plane())
    fresh.add_object("ball", Sphere(0.1), **options)
    alone_ = alone(fresh)
    for _ in range(40):
        x, y = late.step([]), alone_.step([])
        np.testing.assert_allclose(x.objects["ball"][0], y.objects["ball"][0], atol=1e-9)
    np.testing.assert_allclose(x.objects["box"][0], [3, 0, 0.1], atol=1e-6)


def test_what_is_taken_away_carries_nothing_any_more():
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object("stool", Box((0.3, 0.3, 0.5)), mass=2, position=(0, 0, 0.25))
    scene.add_object("vase", Box((0.1, 0.1, 0.2)), mass=1, position=(0, 0, 0.6))
    simulator = alone(scene)
    for _ in range(10):
        simulator.step([])
    simulator.remove_object("stool")
    for _ in range(30):
        frame = simulator.step([])
    assert set(frame.objects) == {"vase"}
    assert frame.objects["vase"][0][2] == pytest.approx(0.1, abs=2e-3)


def test_states_fit_and_old_frames_keep_their_names():
    body, motion = Body.default(), t_pose(np.zeros((30, 3)))
    simulator = Simulator(with_person(), body=body)
    old = simulator.reset(motion[0])
    before = simulator.get_state()
    simulator.add_object("brick", Box((0.1, 0.1, 0.1)), mass=3.0, position=(0, 0, 3))
    with pytest.raises(InputError, match="another simulator"):
        simulator.set_state(before)
    for t in range(1, 5):
        simulator.step(motion[t])
    state = simulator.get_state()
    first = [simulator.step(motion[t]) for t in range(5, 25)]
    simulator.set_state(state)
    again = [simulator.step(motion[t]) for t in range(5, 25)]
    for x, y in zip(first, again, strict=True):
        assert (x.pose.translation == y.pose.translation).all()
        assert (x.pose.rotations == y.pose.rotations).all()
        for name in x.objects:
            assert (x.objects[name][0] == y.objects[name][0]).all()
    assert set(old.objects) == {"book", "ball"}
    assert any(len(f.contacts.part) for f in first)  # the brick fell on the head


DOOR = """
<mujoco><worldbody><body name="leaf"><joint type="hinge" axis="0 0 1"/>
<geom type="box" size="0.4 0.02 1" mass="20"/></body></worldbody></mujoco>
"""


@pytest.mark.parametrize(
    ("do", "says"),
    [
        (lambda s: s.apply_impulse("crat", (0, 0, 1)), "did you mean 'crate'"),
        (lambda s: s.apply_impulse("crate", (0, 1)), "impulse"),
        (lambda s: s.apply_impulse("crate", (0, 0, 1), point="here"), "point"),
        (lambda s: s.set_velocity("crate", (0, 0, np.nan)), "velocity"),
        (lambda s: s.set_velocity("lift", (0, 0, 1)), "trajectory"),
        (lambda s: s.remove_object("wall"), "no object called 'wall'"),
        (lambda s: s.velocity("door/leaf"), "velocity: 'door/leaf' is articulated"),
        (lambda s: s.apply_impulse("door/leaf", (0, 0, 1)), "'door/leaf' is articulated"),
        (lambda s: s.remove_object("door"), "remove_object: 'door' is articulated"),
        (lambda s: s.velocity(np.zeros(2)), "no object called array"),
        (lambda s: s.add_object("crate", Sphere(1), mass=1), "already"),
        (lambda s: s.add_object("new", Sphere(1)), "mass="),
    ],
)
def test_what_is_wrong_is_said_and_changes_nothing(do, says):
    scene = crate()
    scene.add_moving("lift", Box((1, 1, 1)), [[9, 9, 9]], fps=30)
    scene.add_articulated("door", DOOR, position=(0, -9, 1))
    simulator = alone(scene)
    names, velocity = simulator.names, simulator.velocity("crate")
    with pytest.raises(InputError, match=says):
        do(simulator)
    assert simulator.names == names
    np.testing.assert_array_equal(simulator.velocity("crate"), velocity)
    with pytest.raises(InputError, match="reset"):
        Simulator(crate(), body=[]).apply_impulse("crate", (0, 0, 1))


@pytest.mark.parametrize("story", ["walk_into_wall", "kick_ball"])
def test_whoever_is_rebuilt_is_where_it_was(story):
    """In mid-air, in mid-step, at the wall: nobody is put on the ground anew."""
    sequence = scenarios.load(story)
    simulator = Simulator(
        sequence.scene, body=sequence.body, settings=as_parts(sequence.settings), fps=30.0
    )
    motion = sequence.motion
    hop = 0.3 * np.sin(np.linspace(0.0, 3.0 * np.pi, len(motion))) ** 2
    raised = motion.with_frames(motion.translation + np.outer(hop, (0, 0, 1)), motion.rotations)
    simulator.reset(raised[0])
    for t in range(1, len(raised)):
        simulator.step(raised[t])
        was = simulator.world.stepper
        again = rebuilt(simulator.world, simulator.world.made_of, True).stepper
        np.testing.assert_array_equal(again.qpos(), was.qpos())
        np.testing.assert_array_equal(again.qvel(), was.qvel())


def test_a_jump_goes_on_as_it_would_when_something_comes_far_away():
    clip = t_pose(np.tile((0.0, 0.0, 0.0), (60, 1)), fps=60.0).grounded(Body.default())
    since = np.arange(len(clip)) / clip.fps - 0.2  # it takes off [s]
    height = np.clip(3.0 * since - 0.5 * 9.81 * since**2, 0.0, None)
    motion = clip.with_frames(clip.translation + np.outer(height, (0, 0, 1)), clip.rotations)
    scene = Scene()
    scene.add_static("floor", Plane())
    a, b = (Simulator(scene, fps=60.0) for _ in range(2))
    a.reset(motion[0])
    b.reset(motion[0])
    for t in range(1, len(motion)):
        if t in (13, 14, 30, 47):
            b.add_object(f"lamp{t}", Sphere(0.1), mass=1.0, position=(0, 30 + t, 0.1))
        x, y = a.step(motion[t]), b.step(motion[t])
        np.testing.assert_array_equal(y.pose.translation, x.pose.translation)
        np.testing.assert_array_equal(y.pose.rotations, x.pose.rotations)
