"""Prescribed poses: the motion is unchanged, passes through walls and ignores mass."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import metrics, scenarios
from halfphysics.base import rotations as rot
from halfphysics.baselines import (
    Interpolated,
    Kinematic,
    Positions,
    from_options,
    options_of,
    with_options,
)
from halfphysics.body.body import Body
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.geometry.shapes import Box, Mesh, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import simulate
from halfphysics.simulation.simulator import Simulator
from support.as_it_is import as_it_is
from support.doors import ACROSS, DOOR
from support.kicks import before_the_foot, swing
from support.people import MIDDLE, SOLES, along_x, violent

KINEMATIC, POSITIONS, INTERPOLATED = Kinematic(), Positions(), Interpolated()
#: Interpolated to 1,020 Hz at 30 fps.
FINE = Interpolated(substeps=34)
ALL = pytest.mark.parametrize(
    "settings", [KINEMATIC, POSITIONS, INTERPOLATED, FINE], ids=["K", "P", "I", "fine"]
)
PUSHING = pytest.mark.parametrize(
    "settings", [POSITIONS, INTERPOLATED, FINE], ids=["P", "I", "fine"]
)
#: No object that leaves people at depenetration_speed is faster than this multiple of it.
THROWN = 3.0


@pytest.fixture(scope="module")
def body():
    return Body.default()


def same(motion, other):
    return np.array_equal(motion.translation, other.translation) and np.array_equal(
        motion.rotations, other.rotations
    )


def track(result, name):
    thing = result.objects[name]
    return np.hstack([thing.position, thing.quaternion])


def speeds(result, name):
    """Speed of an object's origin from frame to frame [m/s]."""
    way = np.linalg.norm(np.diff(result.objects[name].position, axis=0), axis=1)
    return way * result.fps


def alone(scene, motion, substeps=None):
    """Poses of the objects at a motion's frames without people: name -> (7,), for every frame."""
    simulator = Simulator(scene, body=[], settings=Settings(substeps=substeps), fps=motion.fps)
    frames = [simulator.reset([])] + [simulator.step([]) for _ in range(len(motion) - 1)]
    return [{name: np.hstack(pose) for name, pose in f.objects.items()} for f in frames]


def walled(wall=True, thickness=0.01):
    """A wall across the way, a ball in front of it, a falling ball behind it, a box far away."""
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, SOLES))
    if wall:
        scene.add_static("wall", Box((thickness, 6.0, 6.0)), position=(0.3, 0.0, 0.0))
    scene.add_object("ball", Sphere(0.1), mass=1.0, position=(0.1, MIDDLE + 0.1, SOLES + 0.1))
    scene.add_object("falls", Sphere(0.1), mass=1.0, position=(0.6, MIDDLE, 2.0))
    scene.add_object("box", Box((0.3, 0.2, 0.1)), mass=1.0, position=(-9.0, MIDDLE, SOLES + 0.05))
    return scene


@ALL
@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_nobody_is_stopped(body, settings, contact):
    motion = along_x(1.0, 40, start=-0.5)
    settings = dataclasses.replace(settings, contact=contact)
    result = simulate(motion, walled(), body=body, settings=settings)
    assert same(result.motion, motion)
    assert result.clearance.min() < -0.005  # in the wall
    assert result.clearance[-1] > 0.0  # and past it
    assert not len(result.contacts[(result.contacts.person == 0) & (result.contacts.other < 2)])
    # The clearance is the distance of that pose, in every mode.
    start = Simulator(walled(), body=body, settings=as_it_is(contact=contact)).reset(motion[0])
    assert result.clearance[0] == start.clearance
    assert (result.people[0].torque == 0.0).all()
    stopped = simulate(motion, walled(), body=body, settings=as_it_is(contact=contact))
    assert stopped.clearance.min() > 0.0


@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_kinematic_people_touch_nothing(body, contact):
    """Objects touch only each other, as without people: bit for bit."""
    motion = violent(40)
    settings = dataclasses.replace(KINEMATIC, contact=contact)
    scene = walled()
    result = simulate(motion, scene, body=body, settings=settings)
    assert same(result.motion, motion)
    assert (result.contacts.person == -1).all()
    expected = alone(scene, motion)
    for name in scene.objects:
        assert np.array_equal(track(result, name), [f[name] for f in expected]), name
    assert track(result, "falls")[-1, 2] < 0.0  # gravity acts


@PUSHING
def test_what_is_not_touched_rests(body, settings):
    """As without people: bit for bit."""
    scene, motion = walled(), along_x(1.0, 40, start=-0.5)
    result = simulate(motion, scene, body=body, settings=settings)
    box = track(result, "box")
    assert np.array_equal(box, [f["box"] for f in alone(scene, motion, settings.substeps)])
    assert np.abs(box - box[0]).max() < 1e-9
    assert np.abs(track(result, "ball")[-1, :3] - track(result, "ball")[0, :3]).max() > 0.05


def kicked(body, mass, **settings):
    """Fastest speed of a weightless ball after a kick that ends outside it [m/s]."""
    scene = before_the_foot(body, mass, radius=0.11, ahead=0.39, height=0.2)
    motion = swing(body, 30.0, back=False)
    return speeds(simulate(motion, scene, body=body, settings=from_options(settings)), "ball").max()


@pytest.mark.parametrize("pace", [0.5, 10.0])
@pytest.mark.parametrize("substeps", [None, 34])
@pytest.mark.parametrize("mode", ["positions", "interpolated"])
def test_they_are_blind_to_mass(body, mode, substeps, pace):
    asked = {"mode": mode, "substeps": substeps, "depenetration_speed": pace}
    light, heavy = (kicked(body, mass, **asked) for mass in (0.1, 1000.0))
    assert heavy == pytest.approx(light, rel=0.01)
    assert 0.2 * pace < light < THROWN * pace


def test_half_physics_is_not(body):
    light, heavy = (kicked(body, mass) for mass in (0.1, 1000.0))
    assert light > 5.0 * heavy


@pytest.mark.slow
@PUSHING
def test_a_suitcase_is_penetrated_and_stays(body, settings):
    """Figure 7. Half-physics lifts it by 0.35 m without a vertex of the skin inside."""
    story = scenarios.load("lift_suitcase", carry=1.0, shake=0.0)

    def lifted(**asked):
        settings = with_options(story.settings, asked)
        result = simulate(story.motion[:66], story.scene, body=story.body, settings=settings)
        height = result.objects["suitcase"].position[:, 2]
        found = metrics.penetration(
            result.motion, story.body, story.scene, objects=result.objects, threads=2
        )
        return height.max() - height[0], found.by_name["suitcase"].max()

    rise, depth = lifted(mode=options_of(settings)["mode"], substeps=settings.substeps)
    assert rise < 0.02
    assert depth > 30.0
    if settings is POSITIONS:
        rise, depth = lifted()
        assert rise > 0.3
        assert depth < 0.5


@pytest.mark.parametrize("substeps", [None, 3, 34])
def test_what_interpolated_means(body, substeps):
    """Root along straight lines, joints by SLERP the short way round, in every substep."""
    motion = violent(12)
    settings = Interpolated(substeps=substeps, record="substeps")
    scene = walled()
    result = simulate(motion, scene, body=body, settings=settings)
    n = settings.substeps_for(1.0 / motion.fps)
    recorded = result.substeps.motions[0]
    assert recorded.fps == n * motion.fps
    share = (np.arange(n) + 1.0) / n
    quats = rot.exp(motion.rotations)
    for t in range(len(motion) - 1):
        rows = slice(1 + t * n, 1 + (t + 1) * n)
        a, b = motion.translation[t], motion.translation[t + 1]
        np.testing.assert_allclose(
            recorded.translation[rows], a + share[:, None] * (b - a), atol=1e-12
        )
        turn = rot.log(rot.multiply(rot.conjugate(quats[t]), quats[t + 1]))
        expected = rot.multiply(quats[t], rot.exp(share[:, None, None] * turn))
        found = rot.exp(recorded.rotations[rows])
        away = rot.log(rot.multiply(rot.conjugate(expected), found))
        # Half turns between frames may take either way round.
        short = np.linalg.norm(turn, axis=-1) < np.pi - 1e-6
        assert short.mean() > 0.9
        np.testing.assert_allclose(away[:, short], 0.0, atol=1e-9)
    # Objects are also recorded at the substeps; the last of a frame is the frame.
    assert np.array_equal(
        result.substeps.objects["falls"].position[::n], result.objects["falls"].position
    )


def test_positions_jump(body, tmp_path):
    """Once per frame, at any distance: the pose holds in all substeps of the frame."""
    motion = along_x(20.0, 6, start=-2.0)
    settings = dataclasses.replace(POSITIONS, record="substeps")
    result = simulate(motion, walled(), body=body, settings=settings)
    recorded = result.substeps.motions[0]
    for t in range(len(motion) - 1):
        rows = slice(1 + 8 * t, 9 + 8 * t)
        np.testing.assert_allclose(
            recorded.translation[rows], np.tile(motion.translation[t + 1], (8, 1)), atol=1e-12
        )
    result.save(tmp_path / "result.npz")
    loaded = hp.Result.load(tmp_path / "result.npz")
    assert same(loaded.substeps.motions[0], recorded)
    assert loaded.settings == settings


@ALL
def test_a_state_is_all(body, settings):
    """A state in the middle of contacts; stepping frame by frame equals `simulate`."""
    motion, scene = swing(body, 30.0), before_the_foot(body, 0.5)
    simulator = Simulator(scene, body=body, settings=settings, fps=motion.fps)
    result = simulate(motion, scene, body=body, settings=settings)

    def on(first, last):
        return [np.hstack(simulator.step(motion[t]).objects["ball"]) for t in range(first, last)]

    frame = simulator.reset(motion[0])
    assert same(frame.pose, motion[0])
    on(1, 14)
    assert same(simulator.step(motion[14]).pose, motion[14])
    state = simulator.get_state()
    rest = on(15, len(motion))
    other = Simulator(scene, body=body, settings=settings, fps=motion.fps)
    other.set_state(state)
    again = [np.hstack(other.step(motion[t]).objects["ball"]) for t in range(15, len(motion))]
    assert np.array_equal(rest, again)
    assert np.array_equal(rest, track(result, "ball")[15:])


@PUSHING
@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_nothing_is_thrown(body, settings, contact):
    """Wild limbs among weightless objects: many hulls push at once, none flies off."""
    rng = np.random.default_rng(5)
    scene = Scene(gravity=0.0)
    shapes = [Sphere(0.1), Box((0.2, 0.2, 0.2)), Box((0.6, 0.05, 0.4)), Box((0.1, 1.0, 0.1))]
    for i, shape in enumerate(shapes):
        place = rng.uniform(-0.2, 0.2, 3) + 3.0 * np.array([i % 2, i // 2, 0.0])
        scene.add_object(f"thing{i}", shape, mass=10 ** rng.uniform(-1.0, 1.0), position=place)
    people = [
        (m := violent(40, seed=i)).with_frames(
            0.2 * m.translation + 3.0 * np.array([i % 2, i // 2, 0.0]), m.rotations
        )
        for i in range(4)
    ]
    settings = dataclasses.replace(settings, contact=contact)
    result = simulate(people, scene, body=body, settings=settings)
    for person, motion in zip(result.people, people, strict=True):
        assert same(person.motion, motion)
    touched = 0
    for name in scene.objects:
        assert np.isfinite(track(result, name)).all()
        touched += speeds(result, name).max() > 0.1
        # It may leave several times, each adding the full speed.
        assert speeds(result, name).max() < 4.0 * THROWN * settings.depenetration_speed, name
    assert touched == len(scene.objects)


@PUSHING
def test_what_is_squeezed(body, settings):
    """A ball between a wall and a person gliding at 0.5 m/s: pushed, jammed, left behind."""
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, SOLES))
    scene.add_static("wall", Box((0.2, 4.0, 4.0)), position=(0.6, 0.0, 0.0))
    scene.add_object("ball", Sphere(0.15), mass=1.0, position=(0.3, MIDDLE, SOLES + 0.15))
    motion = along_x(0.5, 90, start=-0.6)
    result = simulate(motion, scene, body=body, settings=settings)
    assert same(result.motion, motion)
    ball = result.objects["ball"].position
    assert speeds(result, "ball").max() < 4.0 * settings.depenetration_speed
    # The wall and the floor keep the ball out.
    assert ball[:, 0].max() < 0.5 - 0.15 + 1e-4
    assert ball[:, 2].min() > SOLES + 0.15 - 1e-4
    found = metrics.penetration(result.motion, body, scene, objects=result.objects, threads=2)
    assert found.by_name["ball"].max() > 20.0  # while it had no room
    assert found.by_name["wall"].max() > 50.0


def test_deeper_is_pushed_out_as_fast_as_asked(body):
    """A closed form: a ball that a hand is put into leaves at depenetration_speed."""
    for speed in (0.25, 1.0):
        motion = along_x(0.0, 12, start=0.0)
        scene = Scene(gravity=0.0)
        palm = body.joints(motion)[0, 20]
        scene.add_object("ball", Sphere(0.2), mass=3.0, position=palm + np.array([0.0, 0.35, 0.0]))
        path = motion.translation.copy()
        path[1:, 1] += 0.05  # one jump sideways
        motion = motion.with_frames(path, motion.rotations)
        settings = dataclasses.replace(POSITIONS, depenetration_speed=speed)
        result = simulate(motion, scene, body=body, settings=settings)
        assert speeds(result, "ball")[0] == pytest.approx(speed, rel=0.02)
        assert speeds(result, "ball").max() < 1.05 * speed


@PUSHING
def test_a_door_is_opened(body, settings):
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_articulated("door", DOOR, **ACROSS)
    motion = along_x(0.8, 90, start=-0.3).grounded(body, 0.002)
    result = simulate(motion, scene, body=body, settings=settings)
    angle = np.degrees(result.joints["door/hinge"])
    assert same(result.motion, motion)
    assert np.isfinite(angle).all()
    assert angle.max() > 5.0
    assert angle.min() > -5.01
    assert angle.max() < 100.01
    still = simulate(motion, scene, body=body, settings=KINEMATIC)
    assert np.abs(still.joints["door/hinge"]).max() < 1e-9


@ALL
def test_trajectories_and_sleepers(body, settings):
    """Kinematic objects and prescribed people pass each other; a pushed sleeper wakes."""
    path = np.array([[1.0, MIDDLE, 0.0], [-1.0, MIDDLE, 0.0]])
    scene = Scene(gravity=0.0)
    scene.add_moving("cart", Box((0.4, 0.4, 0.4)), path, fps=1.0)
    scene.add_object("lamp", Sphere(0.1), mass=1.0, position=(0.3, MIDDLE, 0.3), start="asleep")
    scene.ignore("cart", "lamp")
    motion = along_x(1.0, 31, start=-0.6)
    result = simulate(motion, scene, body=body, settings=settings)
    assert same(result.motion, motion)
    assert not result.lost_time.any()
    np.testing.assert_allclose(
        result.objects["cart"].position[:, 0], np.linspace(1.0, -1.0, 31), atol=1e-9
    )
    moved = np.abs(track(result, "lamp") - track(result, "lamp")[0]).max()
    assert moved == 0.0 if settings is KINEMATIC else moved > 0.02


def test_people_pass_through_each_other(body):
    motions = [along_x(1.0, 60, start=-1.0), along_x(-1.0, 60, start=1.0)]
    for settings in (KINEMATIC, POSITIONS, INTERPOLATED):
        result = simulate(motions, Scene(), body=body, settings=settings)
        assert all(same(p.motion, m) for p, m in zip(result.people, motions, strict=True))
        assert not len(result.contacts)


def test_inside_a_mesh_is_negative(body):
    """A wall of triangles, one layer of them."""
    corners = np.array([[0.3, y, z] for y in (-3.0, 3.0) for z in (-3.0, 3.0)])
    scene = Scene()
    scene.add_static("wall", Mesh(corners, np.array([[0, 1, 2], [1, 3, 2]])))
    result = simulate(along_x(1.0, 40, start=-0.5), scene, body=body, settings=KINEMATIC)
    assert result.clearance.min() < -0.01
    assert result.clearance[-1] > 0.0


def test_nothing_is_held(body):
    scene = Scene()
    scene.add_object("box", Box((0.1, 0.1, 0.1)), mass=1.0, position=(2.0, 0.0, 0.0))
    for settings in (KINEMATIC, POSITIONS, INTERPOLATED):
        simulator = Simulator(scene, body=body, settings=settings)
        simulator.reset(along_x(0.0, 2, start=0.0)[0])
        with pytest.raises(InputError, match="with the baseline"):
            simulator.attach("box")


def test_a_start_in_a_wall_is_no_news(body):
    """No contact would push a person out, so no promise is broken."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("error", HalfPhysicsWarning)
        result = simulate(along_x(0.0, 3, start=0.3), walled(), body=body, settings=KINEMATIC)
    assert not len(result.inside)
    assert result.clearance[0] < 0.0
