"""A person in the simulator: free motion is exact, walls stop it, balls fly, runs repeat."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.metrics import mpjpe, mpjpe_global
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.sequence import Sequence
from halfphysics.simulation.simulate import simulate
from halfphysics.simulation.simulator import Simulator
from support.as_it_is import as_it_is
from support.judges.person_hulls import CONTACTS, pieces_of
from support.people import along_x, follow, violent

EXACT_MM = 1e-6  # the goal; measured about 1e-12
CLIPS = ("kick1", "kick3", "side_jump1", "single_foot_jump2", "squat3", "walk1")
DRIVES = {
    "time constant": {"drive_time": 0.02},
    "algorithm 1": {"drive_time": None},
}


@pytest.fixture(scope="module")
def body():
    return Body.default()


def wall():
    """1 cm thick, at x = 0.5."""
    scene = Scene()
    scene.add_static("wall", Box((0.01, 6.0, 6.0)), position=(0.5, 0.0, 0.0))
    return scene


def corners(simulator, qpos):
    """World corners (n, 3) of a person's collision shapes, without the contact code."""
    (pieces,) = pieces_of(simulator)
    return pieces.at(np.atleast_2d(qpos)).corners


@pytest.mark.slow
@pytest.mark.parametrize("substeps", [1, 4, 8])
@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("clip", [*CLIPS, "violent"])
def test_free_motion_is_followed_exactly(request, body, clip, drive, substeps):
    if clip == "violent":
        motion = violent()
    else:
        folder = request.getfixturevalue("shared_data")
        motion = Motion.load(folder / "motion" / f"asap_{clip}.npz")
    for stiffness in (0.0, 1.0):
        settings = as_it_is(substeps=substeps, stiffness=stiffness, **DRIVES[drive])
        _, corrected, _ = follow(motion, None, body, settings)
        assert mpjpe(motion, corrected, body) <= EXACT_MM
        assert mpjpe_global(motion, corrected, body) <= EXACT_MM


def test_the_violent_motion_is_violent(body):
    motion = violent()
    joints = body.joints(motion)
    speed = np.linalg.norm(np.diff(joints, axis=0), axis=2) * motion.fps
    assert speed.max() >= 15.0


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [0.0, 1.0, 10.0])
@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("contact", CONTACTS)
def test_walking_into_a_wall(body, contact, drive, stiffness):
    """1.5 m/s into 1 cm, N = 8: it stops, keeps its offset when free, and walks on when turned."""
    settings = as_it_is(
        contact=contact, stiffness=stiffness, substeps=8, record="substeps", **DRIVES[drive]
    )
    motion = along_x(1.5, 90, start=-0.4, turn=60)
    frames, corrected, simulator = follow(motion, wall(), body, settings)
    face = 0.495
    poses = np.concatenate([frame.substeps for frame in frames[1:]])
    assert corners(simulator, poses)[..., 0].max() <= face
    x = corrected.translation[:, 0]
    assert motion.translation[60, 0] > 2.0  # the motion goes on for 2 m
    assert x.max() < 0.5
    # Stopped: pressed against the wall for a second it hardly moves.
    assert abs(x[60] - x[50]) < 0.02
    touching = np.array([len(f.contacts.part) > 0 for f in frames])
    offset = corrected.translation - motion.translation
    free = ~touching[1:] & ~touching[:-1]
    change = np.linalg.norm(np.diff(offset, axis=0), axis=1)[free]
    runs = np.flatnonzero(~touching)
    before, after = runs[runs < 30], runs[runs > 60]
    assert len(before) > 3
    assert len(after) > 10
    assert change.max() <= 1e-3
    for run in (before, after):
        assert np.ptp(offset[run], axis=0).max() <= 1e-3
    # After the turn it walks with the motion.
    assert x[-1] - x[65] == pytest.approx(-1.5 * 24 / 30, abs=2e-3)


def kick(fps=30.0, mass=0.5, settings=None, body=None):
    """The right leg swings through a ball on the floor in front of it, and back."""
    n = round(fps) + 1
    t = np.arange(n) / fps
    motion = along_x(0.0, n, start=0.0, fps=fps)
    rotations = motion.rotations.copy()
    rotations[:, 2, 0] = 0.4 - 1.2 * np.sin(np.pi * np.clip((t - 0.3) / 0.4, 0, 1))
    motion = motion.with_frames(motion.translation, rotations)
    motion = motion.grounded(body, 0.002)
    toe = body.joints(motion)[0, 11]
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_object("ball", Sphere(0.11), mass=mass, position=(toe[0] + 0.55, toe[1], 0.11))
    scene.add_object("far", Sphere(0.11), mass=mass, position=(-1.0, 1.5, 0.11))
    return simulate(motion, scene, body=body, settings=settings)


@pytest.mark.parametrize("drive", DRIVES)
def test_a_kicked_ball_leaves_along_the_kick_and_an_untouched_one_stays(body, drive):
    result = kick(settings=as_it_is(**DRIVES[drive]), body=body)
    velocity = (result.objects["ball"].position[-1] - result.objects["ball"].position[-4]) * 10
    assert velocity[0] > 1.0
    assert abs(velocity[1]) < 0.5 * velocity[0]
    far = result.objects["far"].position
    assert np.abs(far - far[0]).max() < 1e-9
    ball = result.names.index("ball")
    mine = (result.contacts.other == ball) & (result.contacts.person == 0)
    assert mine.any()
    # The part is pushed back against the kick, and the normal points into the part.
    assert result.contacts.impulse[mine][:, 0].sum() < 0.0
    along = np.einsum("ij,ij->i", result.contacts.impulse[mine], result.contacts.normal[mine])
    assert (along > 0.0).all()


def test_simulate_and_simulator_give_the_same_bits_as_does_a_second_run(body):
    motion = along_x(1.5, 40, start=-0.4)
    first = simulate(motion, wall(), body=body, settings=as_it_is())
    second = simulate(motion, wall(), body=body, settings=as_it_is(threads=2))
    _, corrected, _ = follow(motion, wall(), body, as_it_is())
    for other in (second.motion, corrected):
        assert first.motion.translation.tobytes() == other.translation.tobytes()
        assert first.motion.rotations.tobytes() == other.rotations.tobytes()
    assert first.contacts.impulse.tobytes() == second.contacts.impulse.tobytes()


def test_frames_are_what_simulate_reports_and_survive_a_copy(body):
    """Two people meet, with an object in between: computed at once or one by one."""
    pair = [along_x(1.0, 40, start=-1.0), along_x(-1.0, 40, start=1.0)]
    scene = Scene()
    scene.add_object("ball", Sphere(0.1), mass=1.0, position=(0.0, 0.3, 0.2))
    result = simulate(pair, scene, body=[body, body])
    simulator = Simulator(scene, body=[body, body], fps=pair[0].fps)
    frames = [simulator.reset([m[0] for m in pair])]
    frames += [simulator.step([m[t] for m in pair]) for t in range(1, 40)]
    names = ("person", "part", "subject", "other", "other_part", "position", "normal", "impulse")
    for t, live in enumerate(frames):
        assert not live.pose.rotations.flags.writeable
        copy = pickle.loads(pickle.dumps(live))
        rows = result.contacts[result.contacts.frame == t]
        for frame in (live, copy):
            for name in names:
                np.testing.assert_array_equal(getattr(frame.contacts, name), getattr(rows, name))
            for pose, person in zip(frame.poses, result.people, strict=True):
                assert pose.rotations.tobytes() == person.motion.rotations[t].tobytes()
            position, quaternion = frame.objects["ball"]
            np.testing.assert_array_equal(position, result.objects["ball"].position[t])
            np.testing.assert_array_equal(quaternion, result.objects["ball"].quaternion[t])
            assert frame.clearance == result.clearance[t]
            assert frame.lost_time == result.lost_time[t]
            corrected = [person.corrected[t] for person in result.people]
            np.testing.assert_array_equal(frame.corrected, corrected)
    # Contacts between people are pairs of rows, one for each, of opposite sign.
    c = result.contacts
    people = result.names.index("person0")
    mutual = np.flatnonzero((c.person >= 0) & (c.other >= people))
    assert len(mutual) > 10
    first, second = mutual[::2], mutual[1::2]
    np.testing.assert_array_equal(c.other[first] - people, c.person[second])
    np.testing.assert_array_equal(c.other_part[first], c.part[second])
    np.testing.assert_array_equal(c.part[first], c.other_part[second])
    np.testing.assert_array_equal(c.impulse[first], -c.impulse[second])
    np.testing.assert_array_equal(c.normal[first], -c.normal[second])
    assert "contacts" in repr(frames[-1])


def test_a_state_resumes_bit_for_bit(body):
    motion = along_x(1.5, 40, start=-0.4)
    for settings in (as_it_is(), Settings.paper(1.0)):
        a = Simulator(wall(), body=body, settings=settings, fps=30)
        a.reset(motion[0])
        for t in range(1, 25):
            a.step(motion[t])
        state = a.get_state()
        expected = [a.step(motion[t]).pose for t in range(25, 35)]
        b = Simulator(wall(), body=body, settings=settings, fps=30)
        b.set_state(state)
        for t, pose in zip(range(25, 35), expected, strict=True):
            assert b.step(motion[t]).pose.rotations.tobytes() == pose.rotations.tobytes()


@pytest.mark.parametrize("contact", CONTACTS)
def test_clearance_is_the_smallest_distance(body, contact):
    motion = along_x(0.6, 30, start=-0.2)
    scene = wall()
    frames, _, simulator = follow(motion, scene, body, as_it_is(contact=contact))
    seen = 0
    for frame, clearance in ((f, f.clearance) for f in frames):
        qpos, _ = simulator.world.start([frame.pose])
        gap = 0.495 - corners(simulator, qpos)[..., 0].max()
        if gap < 0.05 - 1e-9:
            seen += 1
            assert clearance == pytest.approx(gap, abs=1e-9)
        else:
            assert clearance == np.inf
    assert seen > 5


def test_root_recovers(body):
    """The root returns to its path after the wall, and stays clear."""
    motion = along_x(1.0, 120, start=-0.4, turn=30)
    held = along_x(1.0, 200, start=-0.4, turn=30)
    held = held.with_frames(
        np.concatenate([held.translation[:60], np.repeat(held.translation[60:61], 140, axis=0)]),
        held.rotations,
    )
    del motion
    frames, corrected, _ = follow(held, wall(), body, as_it_is(root="recover"))
    np.testing.assert_allclose(corrected.translation[-1], held.translation[-1], atol=1e-4)
    assert min(f.clearance for f in frames) > 0.0
    _, stayed, _ = follow(held, wall(), body, as_it_is(root="stay"))
    assert np.linalg.norm(stayed.translation[-1] - held.translation[-1]) > 0.1


def test_a_start_inside_something_is_said(body):
    motion = along_x(0.0, 3, start=0.45)
    with pytest.warns(HalfPhysicsWarning, match=r"start is not clear: .* mm inside") as said:
        simulate(motion, wall(), body=body)
    assert said[0].filename == __file__


def test_mistakes(body):
    simulator = Simulator(Scene(), body=body)
    pose = along_x(1.0, 2, 0.0)[0]
    with pytest.raises(InputError, match=r"reset\(pose\) first"):
        simulator.step(pose)
    with pytest.raises(InputError, match=r"one halfphysics\.Pose per person"):
        simulator.reset("pose")
    simulator.reset(pose)
    with pytest.raises(InputError, match="dt: found -1"):
        simulator.step(pose, dt=-1)
    with pytest.raises(InputError, match="of another simulator"):
        Simulator(wall(), body=[body, body]).set_state(simulator.get_state())
    for dt in (10**400, True):
        with pytest.raises(InputError, match="dt: found"):
            simulator.step(pose, dt=dt)
    with pytest.raises(InputError, match=r"expected a halfphysics\.Motion"):
        simulate("clip.npz")


@pytest.mark.parametrize(
    ("arguments", "way"),
    [
        ({"motion": "clip.npz"}, r"Load it: halfphysics\.Motion\.load\('clip\.npz'\)"),
        ({"scene": "room.yaml"}, r"Load it: halfphysics\.Scene\.load\('room\.yaml'\)"),
        ({"body": Path("SMPLX.npz")}, r"Load it: halfphysics\.Body\.load\(.*SMPLX\.npz"),
        (
            {"settings": {"stiffness": 2.0}},
            r"expected halfphysics\.Settings of these",
        ),
        ({"motion": Sequence(along_x(1.0, 2, 0.0), Scene())}, r"s\.motion, with s\.scene"),
        ({"motion": iter([along_x(1.0, 2, 0.0)])}, "or a list of them"),
        ({"stiffness": np.ones(55)}, r"found shape \(55,\), expected \(2,\) or \(2, 55\)"),
        ({"stiffness": [[1.0], [1.0, 2.0]]}, r"expected numbers \(2,\) or \(2, 55\)"),
    ],
)
def test_mistakes_have_a_way_out(arguments, way):
    with pytest.raises(InputError, match=way):
        simulate(**({"motion": along_x(1.0, 2, 0.0)} | arguments))


def test_a_scene_that_is_changed_later_changes_no_simulator(body):
    """What it was made of is its own: resets, rays, states and holds know nothing of the rest."""
    motion, scene = along_x(1.0, 5, 0.0), Scene()
    scene.add_object("ball", Sphere(0.05), mass=0.1, position=(1.0, 0.0, 1.0))
    simulator = Simulator(scene, body=body)
    first = simulator.reset(motion[0])
    scene.add_object("box", Box((0.2, 0.2, 0.2)), mass=1.0, position=(0.0, 3.0, 0.0))
    scene.add_static("wall", Box((1.0, 1.0, 1.0)), position=(0.0, 5.0, 0.0))
    again = simulator.reset(motion[0])
    assert set(again.objects) == set(first.objects) == {"ball"}
    assert simulator.ray((0.0, 2.0, 0.0), (0.0, 1.0, 0.0)) is None
    simulator.attach("ball")
    assert set(simulator.step(motion[1]).objects) == {"ball"}
    simulator.set_state(simulator.get_state())
    simulator.reset(motion[0])


@pytest.mark.parametrize("dt", [0.0, -1.0, 11.0, 1e9, np.inf, np.nan, "long", True, "0.1"])
def test_impossible_frames(body, dt):
    motion = along_x(1.0, 3, 0.0)
    simulator = Simulator(Scene(), body=body)
    simulator.reset(motion[0])
    with pytest.raises(InputError, match="dt"):
        simulator.step(motion[1], dt=dt)
    with pytest.raises(InputError, match="person"):
        simulator.set_stiffness(1.0, person="a")
