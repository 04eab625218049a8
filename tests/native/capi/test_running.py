"""Frames of the C library are those of `Simulator`, and continue from a saved state bit for bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import halfphysics as hp
from support.c_library import CError, CWorld


def both(name, first, count, **changes):
    """A scenario in Python and in C: yields (frame, world) after each of its frames from one on."""
    sequence = hp.scenarios.load(name)
    settings = replace(sequence.settings, **changes)
    motions = [m[first : first + count] for m in sequence.motions]
    bodies = [body or hp.Body.default() for body in sequence.bodies]
    sim = hp.Simulator(sequence.scene, body=bodies, settings=settings, fps=motions[0].fps)
    world = CWorld(hp.compile_world(sequence.scene, body=bodies, settings=settings))
    for i, motion in enumerate(motions):
        world.call("set_axes", i, np.array(motion.axes, dtype=np.float64))
    sim.reset([m[0] for m in motions])
    world.reset(*(m[0] for m in motions))
    for i in range(1, len(motions[0])):
        poses = [m[i] for m in motions]
        frame = sim.step(poses)
        world.step(*poses, dt=sim.dt)
        yield frame, world


@pytest.mark.parametrize(
    ("name", "first", "changes"),
    [
        ("kick_ball", 84, {}),
        ("lift_suitcase", 50, {}),
        ("shake_hands", 86, {}),
        ("grasp_glass", 0, {"self_contact": True}),
        ("push_door", 40, {"contact": "parts"}),
        ("sit_on_sofa", 40, {"stiffness": 0.3, "weight": False}),
    ],
)
def test_frames_are_those_of_python(name, first, changes):
    touched = 0
    for frame, world in both(name, first, 20, **changes):
        for i, pose in enumerate(frame.poses):
            translation, rotations = world.pose(i)
            assert np.array_equal(translation, pose.translation)
            assert np.array_equal(rotations, pose.rotations)
        for item, (position, quaternion) in frame.objects.items():
            # Poses of links are worked out along other formulas.
            tolerance = 1e-12 if "/" in item else 0.0
            assert np.abs(world.object(item)[0] - position).max() <= tolerance
            assert np.abs(world.object(item)[1] - quaternion).max() <= tolerance
        assert world.number("get_clearance") == frame.clearance
        assert world.number("get_lost_time") == frame.lost_time
        touched += len(frame.contacts.part)
        if touched > 100:
            break
        assert len(world.contacts()) == len(frame.contacts.part)
    assert touched > 0


def test_meshes_and_the_baseline_of_the_paper(tmp_path):
    scene = hp.Scene()
    rng = np.random.default_rng(0)
    floor = np.column_stack([4 * rng.random((60, 2)) - 2, 0.02 * rng.random(60)])
    faces = rng.permutation(60).reshape(-1, 3)
    scene.add_static("rubble", hp.Mesh(floor, faces))
    scene.add_object("box", hp.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0.4, 0, 0.3))
    settings = hp.Settings.paper()
    sim = hp.Simulator(scene, settings=settings)
    sim.save_world(tmp_path / "world.hpw")
    world = CWorld((tmp_path / "world.hpw").read_bytes())
    pose = hp.Pose((0, 0, 1.2), np.zeros((55, 3)))
    sim.reset(pose)
    world.reset(pose)
    for _ in range(20):
        frame = sim.step(pose)
        world.step(pose, dt=sim.dt)
    assert np.array_equal(world.object("box")[0], frame.objects["box"][0])
    assert np.array_equal(world.pose()[1], frame.pose.rotations)


def test_a_held_object_is_where_python_has_it(tmp_path):
    scene = hp.Scene()
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(0.8, 0, 1.2))
    sim = hp.Simulator(scene)
    pose = hp.Pose((0, 0, 1.2), np.zeros((55, 3)))
    sim.reset(pose)
    sim.attach("ball")
    sim.save_world(tmp_path / "held.hpw")
    world = CWorld((tmp_path / "held.hpw").read_bytes())
    world.reset(pose)
    sim.world.reset([pose])  # Simulator.reset would let go
    frame = sim.step(pose)
    world.step(pose, dt=sim.dt)
    assert np.abs(world.object("ball")[0] - frame.objects["ball"][0]).max() < 1e-12
    with pytest.raises(CError, match="does not move freely"):
        world.call("set_mass", "ball", 2.0)


def test_a_state_continues_bit_for_bit():
    sequence = hp.scenarios.load("lift_suitcase")
    motion = sequence.motion
    data = hp.compile_world(sequence.scene, settings=sequence.settings)
    first, second = CWorld(data), CWorld(data)
    for world in (first, second):
        world.call("set_axes", 0, np.array(motion.axes, dtype=np.float64))
    first.reset(motion[0])
    for i in range(1, 30):
        first.step(motion[i], dt=1 / motion.fps)
    second.load(first.save())
    assert np.array_equal(second.bodies(), first.bodies())
    for i in range(30, 40):
        for world in (first, second):
            world.step(motion[i], dt=1 / motion.fps)
        assert np.array_equal(second.bodies(), first.bodies())
        assert second.save() == first.save()


def test_a_state_of_another_world_or_a_damaged_one_is_refused():
    worlds = [
        CWorld(hp.compile_world(scene)) for scene in (hp.Scene(), hp.Scene(gravity=(0, 0, -1)))
    ]
    pose = hp.Pose((0, 0, 1.0), np.zeros((55, 3)))
    for world in worlds:
        world.reset(pose)
    state = worlds[0].save()
    with pytest.raises(CError, match="no state of this world") as caught:
        worlds[1].load(state)
    assert caught.value.status == 5
    before = worlds[0].bodies()
    for damaged in (b"", state[:-8], state[:-1] + bytes([state[-1] ^ 1]), state + bytes(8)):
        with pytest.raises(CError, match="no state of this world"):
            worlds[0].load(damaged)
    assert np.array_equal(worlds[0].bodies(), before)


def test_mistakes_change_nothing_and_are_named():
    world = CWorld(hp.compile_world(hp.Scene()))
    pose = hp.Pose((0, 0, 1.0), np.zeros((55, 3)))
    with pytest.raises(CError, match="call hp_reset first") as caught:
        world.step(pose, dt=1 / 30)
    assert caught.value.status == 4
    world.reset(pose)
    before = world.save()
    for dt in (0.0, -1.0, np.nan, np.inf, 11.0):
        with pytest.raises(CError, match="dt: found"):
            world.step(pose, dt=dt)
    bad = np.zeros(165)
    bad[7] = np.nan
    with pytest.raises(CError, match="rotations: found nan at index 7"):
        world.call("step", np.zeros(3), bad, 1 / 30)
    with pytest.raises(CError, match="translation is NULL"):
        world.call("step", None, np.zeros(165), 1 / 30)
    with pytest.raises(CError, match="too little room"):
        world.call("save", np.zeros(8), np.uint64(8).item(), np.zeros(1))
    assert world.save() == before
