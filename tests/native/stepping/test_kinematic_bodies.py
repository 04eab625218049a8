"""Kinematic objects: they follow their trajectories; they push and carry by closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import simulate
from halfphysics.simulation.simulator import Simulator
from support.people import t_pose

G = 9.81
EXACT = 1e-9  # error of an untouched object [m]


def run(scene, seconds, fps=30.0, **settings):
    simulator = Simulator(scene, body=[], settings=Settings(**settings), fps=fps)
    frames = [simulator.reset([])]
    frames += [simulator.step([]) for _ in range(round(seconds * fps))]
    tracks = {
        name: tuple(np.array([f.objects[name][k] for f in frames]) for k in (0, 1))
        for name in scene.objects
    }
    return tracks, frames


def ride(acceleration, seconds, fps=240.0):
    """Positions (K, 3) along x from rest, z = 0."""
    t = np.arange(round(seconds * fps) + 1) / fps
    return np.outer(0.5 * acceleration * t**2, [1.0, 0.0, 0.0])


@pytest.mark.parametrize("loop", [False, True])
@pytest.mark.parametrize("fps", [30.0, 24.0, 100.0])
def test_lands_on_its_trajectory(fps, loop):
    rng = np.random.default_rng(3)
    positions = rng.normal(size=(40, 3)).cumsum(axis=0) * 0.1
    quaternions = rot.exp(rng.normal(size=(40, 3)).cumsum(axis=0) * 0.3)
    quaternions[::3] *= -1.0  # the same rotations
    scene = Scene()
    thing = scene.add_moving(
        "thing", Box((0.1, 0.2, 0.3)), positions, quaternions, fps=fps, loop=loop
    )
    tracks, _ = run(scene, 2.5)
    position, quaternion = tracks["thing"]
    time = np.arange(len(position)) / 30.0
    place, turn = thing.at(time)
    np.testing.assert_allclose(position, place, atol=EXACT)
    apart = rot.log(rot.multiply(rot.conjugate(turn), quaternion))
    assert np.abs(apart).max() < EXACT
    # Its pose is the given one at its own frames, before its end and after.
    k = np.flatnonzero(np.abs(time * fps - np.round(time * fps)) < 1e-9)
    row = np.round(time[k] * fps).astype(int)
    row = row % 40 if loop else np.minimum(row, 39)
    np.testing.assert_allclose(position[k], positions[row], atol=EXACT)


def test_a_platform_carries_a_box():
    """mu g > a: the box moves with the platform and keeps its place on it."""
    scene = Scene()
    scene.add_moving("deck", Box((2, 2, 0.1)), ride(2.0, 1.0) - [0, 0, 0.05], fps=240.0)
    scene.add_object("box", Box((0.2, 0.3, 0.2)), mass=3.0, friction=0.5, position=(0, 0, 0.1))
    tracks, frames = run(scene, 1.0, substeps=8)
    deck, box = tracks["deck"][0], tracks["box"][0]
    np.testing.assert_allclose(box - deck, np.tile([0, 0, 0.15], (len(box), 1)), atol=1e-5)
    assert box[-1, 0] == pytest.approx(1.0, abs=1e-5)
    assert max(f.lost_time for f in frames) == 0.0


def test_a_platform_that_starts_too_fast_slips_under_the_box():
    """mu g < a: the box has the acceleration mu g."""
    mu, a, seconds = 0.2, 6.0, 0.5
    scene = Scene()
    scene.add_moving("deck", Box((4, 2, 0.1)), ride(a, seconds) - [0, 0, 0.05], fps=240.0)
    scene.add_object("ball", Sphere(0.1), mass=3.0, friction=0.1, position=(0, 0, 0.1))
    scene.add_object("block", Box((0.3, 0.3, 0.1)), mass=1.0, friction=mu, position=(0, 0.5, 0.05))
    tracks, _ = run(scene, seconds, substeps=8)
    block = tracks["block"][0][:, 0]
    # Symplectic Euler: an offset of half a substep's way.
    np.testing.assert_allclose(block[-1], 0.5 * mu * G * seconds**2, atol=mu * G * seconds / 480)
    # A ball accelerates likewise while it slips: 7/2 mu g < a.
    ball = tracks["ball"][0][:, 0]
    np.testing.assert_allclose(ball[-1], 0.5 * 0.1 * G * seconds**2, atol=0.1 * G * seconds / 480)


@pytest.mark.parametrize(("restitution", "share"), [(0.0, 1.0), (0.5, 1.5), (1.0, 2.0)])
def test_a_ball_that_is_hit_flies(restitution, share):
    """Infinite mass at speed v: the ball leaves with (1 + e) v."""
    v = 2.0
    path = np.outer(np.arange(31) / 30.0 * v, [1.0, 0.0, 0.0])
    scene = Scene(gravity=0.0)
    scene.add_moving("bat", Box((0.1, 1, 1)), path, fps=30.0)
    scene.add_object(
        "ball", Sphere(0.1), mass=7.0, restitution=restitution, position=(0.5, 0.0, 0.0)
    )
    tracks, _ = run(scene, 1.0)
    ball, bat = tracks["ball"][0], tracks["bat"][0]
    np.testing.assert_allclose(bat, path, atol=EXACT)  # contact does not move it
    speed = np.diff(ball[-5:, 0]) * 30.0
    np.testing.assert_allclose(speed, share * v, atol=1e-4)  # tolerance / substep


def test_nothing_pushes_it():
    """A heavy, fast object hits it: it stays, and the object rebounds."""
    scene = Scene(gravity=0.0)
    scene.add_moving("post", Box((0.2, 0.2, 0.2)), [[0.0, 0.0, 0.0]], fps=30.0)
    scene.add_object(
        "ball",
        Sphere(0.1),
        mass=1e4,
        restitution=1.0,
        position=(-1, 0, 0),
        velocity=(5, 0, 0),
    )
    tracks, _ = run(scene, 1.0)
    assert np.abs(tracks["post"][0]).max() == 0.0
    assert (tracks["post"][1] == [1, 0, 0, 0]).all()
    assert np.diff(tracks["ball"][0][-3:, 0]) * 30 == pytest.approx(-5.0, abs=1e-4)


def test_it_meets_no_static():
    scene = Scene()
    scene.add_static("wall", Box((0.1, 2, 2)), position=(0.5, 0, 0))
    path = np.outer(np.linspace(0, 1, 31), [1.0, 0.0, 0.0])
    scene.add_moving("ghost", Box((0.2, 0.2, 0.2)), path, fps=30.0)
    tracks, frames = run(scene, 1.0)
    np.testing.assert_allclose(tracks["ghost"][0], path, atol=EXACT)
    assert all(len(f.contacts.part) == 0 for f in frames)


@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_a_wall_pushes_a_person(contact):
    """1.2 m at 1 m/s: the skin stays in front of the wall and the root moves with it."""
    body = Body.default()
    motion = t_pose(np.zeros((46, 3)))
    scene = Scene()
    path = np.zeros((46, 3))
    path[:, 0] = -1.0 + np.minimum(np.arange(46) / 30.0, 1.2)
    scene.add_moving("wall", Box((0.1, 3, 3)), path, fps=30.0)
    result = simulate(motion, scene, body=body, settings=Settings(contact=contact))
    wall = result.objects["wall"].position
    np.testing.assert_allclose(wall, path, atol=1e-9)
    moved = result.people[0].motion
    if contact == "skin":
        skin = body.vertices(moved)
        gap = skin[..., 0].min(axis=1) - (wall[:, 0] + 0.05)
        assert gap[0] > 0.1
        assert gap.min() > 0.0
        assert gap[36] < 2e-3  # the wall has pushed it all the way
    assert moved.translation[-1, 0] > 0.1
    assert np.abs(moved.translation[0]).max() == 0.0
    assert (result.contacts.impulse[:, 0] > 0).any()


def test_who_is_wedged_stops_the_wall():
    """A person between a moving and a fixed wall is not crushed: the moving wall waits."""
    body = Body.default()
    motion = t_pose(np.zeros((43, 3)))
    scene = Scene()
    scene.add_static("stop", Box((0.1, 3, 3)), position=(0.4, 0, 0))
    path = np.zeros((43, 3))
    path[:, 0] = -1.0 + 1.2 * np.arange(43) / 45.0
    scene.add_moving("wall", Box((0.1, 3, 3)), path, fps=30.0)
    with pytest.warns(HalfPhysicsWarning, match="no room from"):
        result = simulate(motion, scene, body=body)
    skin = body.vertices(result.people[0].motion)[..., 0]
    wall = result.objects["wall"].position[:, 0]
    assert (skin.min(axis=1) > wall + 0.05).all()
    assert (skin.max(axis=1) < 0.35).all()
    assert result.lost_time.sum() > 0
    assert wall[-1] < path[-1, 0] - 0.01  # behind its path


def test_runs_repeat_and_resume_to_the_bit():
    def make():
        scene = Scene()
        scene.add_static("floor", Plane())
        path = np.outer(np.arange(31) / 30.0 * 2.0, [1.0, 0.0, 0.0]) + np.array([0.0, 0.0, 0.2])
        scene.add_moving("bat", Box((0.1, 1, 0.3)), path, fps=17.0, loop=True)
        scene.add_object("ball", Sphere(0.1), mass=1.0, position=(0.5, 0.0, 0.1))
        return Simulator(scene, body=[])

    a, b = make(), make()
    a.reset([])
    b.reset([])
    for _ in range(10):
        a.step([])
    state = a.get_state()
    for _ in range(5):
        b.step([])
    b.set_state(state)
    for _ in range(20):
        x, y = a.step([]), b.step([])
        for name in x.objects:
            assert (x.objects[name][0] == y.objects[name][0]).all()
            assert (x.objects[name][1] == y.objects[name][1]).all()


def test_scene_files(tmp_path):
    scene = Scene()
    turns = rot.exp(np.random.default_rng(1).normal(size=(5, 3)))
    scene.add_moving("door", Box((1, 0.1, 2)), np.zeros((5, 3)), turns, fps=12.5, loop=True)
    scene.add_moving("lift", Box((1, 1, 0.1)), [[0, 0, 0], [0, 0, 1]], fps=1, friction=0.5)
    scene.add_object("ball", Sphere(0.1), mass=1.0)
    for suffix in ("yaml", "json"):
        scene.save(tmp_path / f"s.{suffix}")
        back = Scene.load(tmp_path / f"s.{suffix}")
        assert list(back.objects) == list(scene.objects) == ["ball", "door", "lift"]
        for name in ("door", "lift"):
            one, other = scene.objects[name], back.objects[name]
            assert (one.positions == other.positions).all()
            assert (one.quaternions == other.quaternions).all()
            assert (one.fps, one.loop, one.friction) == (other.fps, other.loop, other.friction)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"positions": [0, 0, 0]}, "positions"),
        ({"positions": []}, "positions"),
        ({"positions": [[0, 0, np.nan]]}, "row 0"),
        ({"quaternions": [[1, 0, 0, 0]] * 2}, "as many of both"),
        ({"quaternions": [[0, 0, 0, 0]]}, "no rotation"),
        ({"fps": 0}, "fps"),
        ({"loop": 1}, "loop"),
        ({"friction": -1}, "friction"),
        ({"shape": Plane()}, "Plane"),
    ],
)
def test_what_is_wrong_is_said(wrong, says):
    given = {"shape": Box((1, 1, 1)), "positions": [[0, 0, 0]], "fps": 30} | wrong
    with pytest.raises(InputError, match=says):
        Scene().add_moving("thing", **given)
