"""Modes that run in plain MuJoCo: their behaviour, correct and incorrect."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics import metrics
from halfphysics.base import rotations as rot
from halfphysics.baselines import EngineKinematic, EngineVelocity
from halfphysics.baselines.engine.kinematic import between
from halfphysics.bench.mujoco_loop import MujocoLoop
from halfphysics.body.body import Body
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.results.result import Result
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import simulate
from halfphysics.simulation.simulator import Simulator
from support.kicks import before_the_foot, swing
from support.people import MIDDLE, SOLES, along_x, violent

KINEMATIC, VELOCITY = EngineKinematic(), EngineVelocity()
ENGINE = pytest.mark.parametrize(
    "settings", [KINEMATIC, VELOCITY], ids=lambda settings: type(settings).__name__
)


@pytest.fixture(scope="module")
def body():
    return Body.default()


def walled():
    """A wall of 10 mm at x = 0.3."""
    scene = Scene()
    scene.add_static("wall", Box((0.01, 6.0, 6.0)), position=(0.3, 0.0, 0.0))
    return scene


def speeds(result, name):
    """Speed of an object before every frame but the first (T - 1,) [m/s]."""
    way = np.diff(result.objects[name].position, axis=0)
    return np.linalg.norm(way, axis=1) * result.fps


def kicked(body, mass, settings):
    """Speed of a weightless ball of 22 cm after a leg's swing has kicked it [m/s]."""
    ball = {"radius": 0.11, "ahead": 0.39, "height": 0.2}
    scene = before_the_foot(body, mass, **ball)
    return speeds(simulate(swing(body, 30.0), scene, body=body, settings=settings), "ball")[-1]


def test_mocap_bodies_walk_through_a_wall(body):
    motion = along_x(1.0, 40, start=-0.5)
    result = simulate(motion, walled(), body=body, settings=KINEMATIC)
    np.testing.assert_array_equal(result.motion.translation, motion.translation)
    np.testing.assert_array_equal(result.motion.rotations, motion.rotations)
    assert result.clearance.min() < -0.1
    assert result.clearance[0] > 0.0
    assert not len(result.contacts)  # no body could respond
    assert not result.lost_time.any()
    assert len(result.diagnostics) == 0


def test_clearance_is_what_the_parts_say(body):
    """Measured as in all modes, at the poses of the frames."""
    result = simulate(along_x(1.0, 40, start=-0.5), walled(), body=body, settings=KINEMATIC)
    np.testing.assert_array_equal(result.clearance, result.parts().clearance.min(axis=1))
    # The first frame is clear, and the native core gives the same distance there.
    start = Simulator(walled(), body=body).reset(result.motion[0])
    assert result.clearance[0] == pytest.approx(start.clearance, abs=1e-9)


def test_the_peer_is_stopped_softly(body):
    motion = along_x(1.0, 40, start=-0.5)
    result = simulate(motion, walled(), body=body, settings=VELOCITY)
    # Measured: 29 mm past its target, and held there.
    assert -0.1 < result.clearance.min() < -0.005
    assert result.motion.translation[-1, 0] < motion.translation[-1, 0] - 0.3


def test_mocap_bodies_are_blind_to_mass(body):
    light, heavy = (kicked(body, mass, KINEMATIC) for mass in (0.1, 1000.0))
    assert light > 1.0
    assert heavy == pytest.approx(light, rel=0.01)


def test_velocities_are_not(body):
    for kind in (Settings, EngineVelocity):
        light, heavy = (kicked(body, mass, kind()) for mass in (0.1, 1000.0))
        assert light > 1.0
        assert heavy < 0.3 * light, kind


def test_free_motion_is_followed(body):
    motion = violent(40)
    result = simulate(motion, body=body, settings=VELOCITY)
    assert metrics.mpjpe_global(result.motion, motion, body) < 1e-5
    assert np.isinf(result.clearance).all()


def test_it_is_the_peer_of_the_bench(body):
    """The same model and loop: the same motion, until contact amplifies rounding."""
    motion = swing(body, 30.0)
    scene = before_the_foot(body, 5.0)
    ours = simulate(motion, scene, body=body, settings=VELOCITY)
    peer = MujocoLoop(body, 30.0, 8, scene).run(motion)
    assert metrics.mpjpe_global(ours.motion, motion, body) > 1.0  # contact occurred
    assert metrics.mpjpe_global(ours.motion, peer, body) < 1e-3


@ENGINE
def test_a_ball_rests_on_the_floor(body, settings):
    motion = along_x(0.0, 31, start=-5.0, z=-SOLES + 0.01)
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object("ball", Sphere(0.1), mass=2.0, position=(0.0, 0.0, 0.1))
    result = simulate(motion, scene, body=body, settings=settings)
    position = result.objects["ball"].position
    np.testing.assert_allclose(position[-1], [0.0, 0.0, 0.1], atol=5e-4)  # soft contact sinks
    assert speeds(result, "ball")[10:].max() < 1e-3
    last = result.contacts[result.contacts.frame == 30]
    assert [result.names[i] for i in last.subject] == ["ball"]
    assert [result.names[i] for i in last.other] == ["floor"]
    assert (last.person == -1).all()
    assert (last.part == -1).all()
    assert (last.other_part == -1).all()
    # The contact carries the weight, upwards, at the ball's position.
    np.testing.assert_allclose(last.impulse[0] * result.fps, [0.0, 0.0, 2.0 * 9.81], atol=1e-6)
    np.testing.assert_allclose(last.normal[0], [0.0, 0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(last.position[0], [0.0, 0.0, 0.0], atol=5e-4)


def squeezed(body, settings):
    """A person glides at 0.5 m/s against a ball in front of a wall."""
    floor = SOLES - 0.01
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, floor))
    scene.add_static("wall", Box((0.2, 4.0, 4.0)), position=(0.6, 0.0, 1.0))
    scene.add_object("ball", Sphere(0.15), mass=1.0, position=(0.3, MIDDLE, floor + 0.15))
    return simulate(along_x(0.5, 70, start=-0.6), scene, body=body, settings=settings)


def test_a_squeezed_object_is_ejected(body):
    """Neither side yields: the ball leaves through the person at five times the person's speed.

    Measured: 2.7 m/s; the peer's stays under 0.6 m/s and before the person.
    """
    result = squeezed(body, KINEMATIC)
    assert speeds(result, "ball").max() > 2.0
    assert result.objects["ball"].position[-1, 0] < 0.0
    peer = squeezed(body, VELOCITY)
    assert speeds(peer, "ball").max() < 1.0
    assert peer.objects["ball"].position[-1, 0] > 0.3


def test_contacts_name_part_and_thing(body):
    result = simulate(swing(body, 30.0), before_the_foot(body, 5.0), body=body, settings=KINEMATIC)
    mine = result.contacts[result.contacts.person == 0]
    assert len(mine)
    leg = {"right_knee", "right_ankle", "right_foot"}
    assert {JOINT_NAMES[part] for part in mine.part} <= leg
    assert {result.names[other] for other in mine.other} == {"ball"}
    assert (mine.subject == -1).all()
    assert (mine.other_part == -1).all()
    np.testing.assert_allclose(np.linalg.norm(mine.normal, axis=1), 1.0, atol=1e-12)
    # The ball pushes the foot back, away from itself.
    assert (np.einsum("ij,ij->i", mine.impulse, mine.normal) >= 0.0).all()
    assert mine.impulse[:, 0].sum() < 0.0
    ball = result.objects["ball"].position[mine.frame]
    away = mine.position - ball
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), 0.3, atol=0.15)
    assert (np.einsum("ij,ij->i", away, mine.normal) > 0.0).all()


def test_what_pushes_is_what_the_ball_gets(body):
    """Impulses on a weightless ball sum to its momentum."""
    scene = before_the_foot(body, 5.0, radius=0.11, ahead=0.39, height=0.2)
    result = simulate(swing(body, 30.0), scene, body=body, settings=VELOCITY)
    on_foot = result.contacts[result.contacts.person == 0].impulse.sum(axis=0)
    track = result.objects["ball"].position
    momentum = 5.0 * (track[-1] - track[-2]) * result.fps
    np.testing.assert_allclose(-on_foot, momentum, atol=1e-6 * np.linalg.norm(momentum))


def test_two_people_push_each_other(body):
    motions = [along_x(0.5, 40, start=-0.8), along_x(0.0, 40, start=-0.3)]
    result = simulate(motions, settings=VELOCITY)
    assert result.names == ("person0", "person1")
    rows = result.contacts
    mine, its = rows[rows.person == 0], rows[rows.person == 1]
    assert len(mine) == len(its) > 0
    assert (mine.other == 1).all()
    assert (its.other == 0).all()
    np.testing.assert_array_equal(mine.part, its.other_part)
    np.testing.assert_allclose(mine.impulse, -its.impulse, atol=1e-12)
    assert (mine.impulse.sum(axis=0) @ [1.0, 0.0, 0.0]) < 0.0
    assert result.people[1].motion.translation[-1, 0] > -0.2  # pushed along
    # Mocap bodies cannot respond.
    kinematic = simulate(motions, settings=KINEMATIC)
    assert not len(kinematic.contacts)


@ENGINE
def test_twice_the_same_bits(body, settings):
    scene = before_the_foot(body, 5.0)
    first, second = (
        simulate(swing(body, 30.0), scene, body=body, settings=settings) for _ in range(2)
    )
    for a, b in (
        (first.motion.translation, second.motion.translation),
        (first.motion.rotations, second.motion.rotations),
        (first.objects["ball"].position, second.objects["ball"].position),
        (first.objects["ball"].quaternion, second.objects["ball"].quaternion),
        (first.contacts.impulse, second.contacts.impulse),
        (first.clearance, second.clearance),
    ):
        np.testing.assert_array_equal(a, b)


@pytest.mark.slow
@ENGINE
def test_saved_and_loaded(body, settings, tmp_path):
    result = simulate(swing(body, 30.0), before_the_foot(body, 5.0), body=body, settings=settings)
    result.save(tmp_path / "r.npz")
    back = Result.load(tmp_path / "r.npz")
    assert back.settings == settings
    np.testing.assert_array_equal(back.motion.rotations, result.motion.rotations)
    np.testing.assert_array_equal(back.objects["ball"].position, result.objects["ball"].position)
    np.testing.assert_array_equal(back.contacts.impulse, result.contacts.impulse)
    np.testing.assert_array_equal(back.clearance, result.clearance)
    assert back.summary() == result.summary()
    assert "touched ball" in back.summary()


def test_penetration_is_measured(body):
    result = simulate(along_x(1.0, 40, start=-0.5), walled(), body=body, settings=KINEMATIC)
    found = metrics.penetration(result.motion, body, walled(), objects=result.objects)
    assert found.depth_max_mm == pytest.approx(5.0, abs=0.1)  # the middle of a wall of 10 mm
    free = metrics.penetration(result.motion[:5], body, walled())
    assert free.depth_max_mm == 0.0


@ENGINE
def test_every_substep_is_kept(body, settings):
    motion, scene = swing(body, 30.0)[8:20], before_the_foot(body, 5.0)
    plain = simulate(motion, scene, body=body, settings=settings)
    every = type(settings)(record="substeps")
    kept = simulate(motion, scene, body=body, settings=every)
    assert kept.substeps is not None
    assert plain.substeps is None
    steps = kept.substeps.motions[0]
    assert len(steps) == 11 * 8 + 1
    assert steps.fps == 240.0
    np.testing.assert_array_equal(steps.rotations[::8], plain.motion.rotations)
    np.testing.assert_array_equal(steps.translation[::8], plain.motion.translation)
    ball = kept.substeps.objects["ball"].position
    np.testing.assert_array_equal(ball[::8], plain.objects["ball"].position)


def test_between_frames_lines_and_slerp():
    motion = violent(5)
    translation, rotations = between(motion, 3, 4)
    np.testing.assert_array_equal(translation[-1], motion.translation[3])
    np.testing.assert_array_equal(rotations[-1], motion.rotations[3])
    half = 0.5 * (motion.translation[2] + motion.translation[3])
    np.testing.assert_allclose(translation[1], half, atol=1e-14)
    was, now = rot.exp(motion.rotations[2]), rot.exp(motion.rotations[3])
    turned = np.abs(
        np.einsum("ij,ij->i", rot.exp(rotations[1]), rot.slerp(was, now, 0.5 * np.ones(55)))
    )
    np.testing.assert_allclose(turned, 1.0, atol=1e-12)


@ENGINE
def test_things_start_as_the_scene_says(body, settings):
    scene = Scene(gravity=0.0)
    scene.add_object(
        "thrown",
        Box((0.1, 0.2, 0.3)),
        mass=1.0,
        position=(0.0, 3.0, 5.0),
        velocity=(1.0, 0.0, 2.0),
        angular_velocity=(0.0, 0.0, 3.0),
    )
    way = [[2.0, 3.0, 3.0], [3.0, 3.0, 3.0]]
    scene.add_moving("lift", Box((0.1, 0.1, 0.1)), way, fps=1.0)
    result = simulate(along_x(0.0, 31, start=-5.0), scene, body=body, settings=settings)
    np.testing.assert_allclose(result.objects["thrown"].position[-1], [1.0, 3.0, 7.0], atol=1e-9)
    turn = rot.log(result.objects["thrown"].quaternion[-1])
    np.testing.assert_allclose(turn, [0.0, 0.0, 3.0], atol=1e-9)
    np.testing.assert_allclose(result.objects["lift"].position[15], [2.5, 3.0, 3.0], atol=1e-12)


@ENGINE
def test_what_moves_as_told_pushes(body, settings):
    scene = Scene(gravity=0.0)
    scene.add_object("ball", Sphere(0.1), mass=1.0, position=(0.3, 3.0, 0.0))
    way = [[0.0, 3.0, 0.0], [1.0, 3.0, 0.0]]
    scene.add_moving("piston", Box((0.2, 0.2, 0.2)), way, fps=1.0)
    result = simulate(along_x(0.0, 31, start=-5.0), scene, body=body, settings=settings)
    assert result.objects["ball"].position[-1, 0] > 1.15  # the piston's face is at 1.1 m
    assert {result.names[i] for i in result.contacts.other} <= {"ball", "piston"}


@ENGINE
def test_a_door_moves_on_its_hinge(body, settings):
    motion = along_x(1.0, 30, start=-0.6)
    scene = Scene(gravity=0.0)
    scene.add_articulated("door", DOOR, position=(0.2, MIDDLE - 0.5, 0.0))
    result = simulate(motion, scene, body=body, settings=settings)
    angle = result.joints["door/hinge"]
    assert angle[0] == 0.0
    assert np.abs(angle).max() > 0.2
    track = result.objects["door/leaf"]
    turned = np.linalg.norm(rot.log(track.quaternion), axis=1)
    np.testing.assert_allclose(turned, np.abs(angle), atol=1e-9)
    touched = result.contacts[result.contacts.person == 0]
    assert {result.names[i] for i in touched.other} == {"door/leaf"}


DOOR = """
<mujoco><worldbody><body name="leaf">
  <joint name="hinge" type="hinge" axis="0 0 1"/>
  <geom type="box" size="0.02 0.5 1" pos="0 0.5 0" mass="10"/>
</body></worldbody></mujoco>
"""


@ENGINE
def test_what_is_unstable_is_said(body, settings, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log where it is
    scene = Scene(gravity=1e11)
    scene.add_object("ball", Sphere(0.1), mass=1.0)
    with pytest.raises(InputError, match=r"MuJoCo became unstable before frame 1 \(0\.03 s\)"):
        simulate(along_x(0.0, 5, start=-3.0), scene, body=body, settings=settings)


@ENGINE
def test_what_it_does_not_heed_is_said(body, settings):
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, -5.0))
    scene.add_object("ball", Sphere(0.1), mass=1.0, restitution=0.5)
    scene.add_object("lamp", Sphere(0.1), mass=1.0, position=(3.0, 0.0, 0.0), start="asleep")
    motion = along_x(0.0, 3, start=-9.0)
    with pytest.warns(HalfPhysicsWarning) as said:
        simulate(motion, scene, body=body, settings=settings)
    words = [str(w.message) for w in said]
    assert len(words) == 2
    assert words[0].startswith("'ball': restitution is not heeded")
    assert words[1].startswith("'lamp': starts awake")
    assert {w.filename for w in said} == {__file__}


@ENGINE
@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"strength": "human"}, "strength"),
        ({"self_contact": True}, "self_contact"),
        ({"root": "recover"}, "root"),
        ({"stiffness": {"arms": 2.0}}, "stiffness"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_it_has_not_is_refused(settings, changed, named):
    with pytest.raises(InputError, match=f"{named}.*MuJoCo"):
        type(settings)(**changed)


@ENGINE
def test_firmness_over_time_is_refused(body, settings):
    motion = along_x(0.0, 3, start=0.0)
    with pytest.raises(InputError, match="without joint stiffness"):
        simulate(motion, body=body, settings=settings, stiffness=np.ones(3))


@ENGINE
def test_frame_by_frame_is_refused(body, settings):
    motion = along_x(0.0, 3, start=0.0)
    with pytest.raises(InputError, match=r"Use halfphysics\.simulate"):
        Simulator(body=body, settings=settings).reset(motion[0])
    running = Simulator(body=body)
    running.reset(motion[0])
    with pytest.raises(InputError, match=r"Use halfphysics\.simulate"):
        Simulator(body=body, settings=settings).set_state(running.get_state())
