"""Held objects: fixed to a part of a person, with mass, and in contact with others."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.body.strength import limits_of
from halfphysics.geometry.shapes import Box, Sphere
from halfphysics.motion.skeleton import JOINT_INDEX, PARENTS
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator
from support.as_it_is import as_it_is
from support.held import (
    HAND,
    PARTS,
    SHOULDER,
    STICK,
    G,
    corners,
    holding,
    in_front,
    place_in_part,
    pointing,
)
from support.people import t_pose, violent


@pytest.fixture(scope="module")
def body():
    return Body.default()


# -- rigid, and heavy ----------------------------------------------------------------------


@pytest.mark.parametrize(
    "settings",
    [PARTS, Settings.paper(contact="parts"), as_it_is()],
    ids=["parts", "paper", "skin"],
)
@pytest.mark.parametrize("part", ["right_wrist", "head", "pelvis"])
def test_it_moves_with_the_part_as_the_motion_says(body, settings, part):
    """At 15 m/s and through half turns; without contact it equals the reference, to rounding."""
    motion, joint = violent(20, seed=4), JOINT_INDEX[part]
    options = {"com": (0.05, 0.0, -0.1), "quaternion": rot.exp([0.4, -0.3, 0.9]), "mass": 3.0}
    simulator = holding(body, motion, settings=settings, part=part, **options)
    assert dict(simulator.held) == {"stick": (0, part)}
    asked = body.joints(motion)
    first = None
    for t in range(1, len(motion)):
        frame = simulator.step(motion[t])
        at, turn = place_in_part(body, frame, joint)
        first = first or (at, turn)
        assert np.abs(at - first[0]).max() < 1e-12
        assert np.abs(turn - first[1]).max() < 1e-12
        assert np.abs(body.joints(frame.pose) - asked[t]).max() < 1e-12
        assert len(frame.contacts.part) == 0


def test_it_is_tied_where_it_is(body):
    motion = pointing()
    scene = Scene()
    turn = rot.exp([0.4, -0.3, 0.9])
    scene.add_object("stick", STICK, **in_front(body, motion[0], quaternion=turn, com=(0.1, 0, 0)))
    simulator = Simulator(scene, body=body, settings=PARTS)
    simulator.reset(motion[0])
    simulator.attach("stick")
    at, quat = simulator.step(motion[0]).objects["stick"]
    np.testing.assert_allclose(at, scene.objects["stick"].position, atol=1e-12)
    np.testing.assert_allclose(quat, turn, atol=1e-12)


def inverse_dynamics(world, before, after, dt, poses):
    """Mean generalised force (nv,) of the held objects alone, by MuJoCo, at `poses` (N, nq)."""
    model, data = world.model, mujoco.MjData(world.model)
    held = [model.body(f"object/{name}").id for name in world.held]
    kept = model.body_mass.copy(), model.body_inertia.copy()
    for b in set(range(model.nbody)) - set(held):
        model.body_mass[b], model.body_inertia[b] = 0.0, 0.0
    model.dof_armature[:] = 0.0
    model.opt.gravity[:] = world.scene.gravity
    total = np.zeros(model.nv)
    for q in poses:
        data.qpos[:], data.qvel[:], data.qacc[:] = q, after, (after - before) / dt
        mujoco.mj_inverse(model, data)
        total += data.qfrc_inverse / len(poses)
    model.body_mass[:], model.body_inertia[:] = kept
    return total


def test_the_drive_exerts_what_it_weighs_and_what_moving_it_takes(body):
    """Against MuJoCo's inverse dynamics of the held object alone, frame by frame."""
    settings = as_it_is(contact="parts", record="substeps")
    motion = violent(12, seed=1)
    options = {"mass": 2.0, "com": (0.1, 0.02, 0.0), "quaternion": rot.exp([0.3, 0.1, -0.5])}
    simulator = holding(body, motion, settings=settings, **options)
    before = None
    for t in range(1, len(motion)):
        start = np.array(simulator.world.stepper.qpos())
        frame = simulator.step(motion[t])
        world, after = simulator.world, np.array(simulator.world.stepper.qvel())
        if before is None:
            before = after  # the motion before the first pose is unknown
        poses = np.concatenate([start[None], frame.substeps[:-1]])
        force = inverse_dynamics(world, before, after, 1 / 30, poses)
        expected = world.torques_from_core(force[3:].reshape(-1, 3))[0]
        np.testing.assert_allclose(frame.torque, expected, atol=1e-6 * np.abs(expected).max())
        before = after
    assert np.abs(frame.torque).max() > 10.0


def test_held_still_every_joint_on_the_way_bears_its_moment(body):
    motion = pointing(4)
    simulator = holding(body, motion, mass=2.0)
    for t in range(1, 4):
        frame = simulator.step(motion[t])
    x, q = body.joint_frames(frame.pose)
    weight, at = np.array([0.0, 0.0, 2.0 * G]), frame.objects["stick"][0]
    between, j = set(), HAND
    while j >= 0:
        between.add(j)
        j = PARENTS[j]
    for j in range(55):
        moment = np.cross(at - x[j], weight) if j in between else np.zeros(3)
        np.testing.assert_allclose(
            frame.torque[j], rot.rotate(rot.conjugate(q[j]), moment), atol=1e-9
        )
    simulator.release("stick")
    assert (simulator.step(motion[0]).torque == 0.0).all()


def test_without_gravity_it_weighs_nothing(body):
    simulator = holding(body, pointing(3), scene=Scene(gravity=0.0), mass=50.0)
    assert (simulator.step(pointing(3)[0]).torque == 0.0).all()


# -- strength ------------------------------------------------------------------------------


def test_who_is_strong_enough_carries_it_to_rounding(body):
    motion = pointing(20, swing=0.2 * np.sin(np.arange(20) * 0.3))
    simulator = holding(
        body, motion, mass=1.0, settings=as_it_is(contact="parts", strength="human")
    )
    for t in range(1, len(motion)):
        frame = simulator.step(motion[t])
        np.testing.assert_allclose(body.joints(frame.pose), body.joints(motion[t]), atol=1e-12)
    assert 10.0 < np.linalg.norm(frame.torque[SHOULDER]) < 80.0  # limit 80


def test_who_is_not_gives_way(body):
    """30 kg at arm's length: first the wrist, then the arm comes down, and swings; no joint exceeds
    its limit, and with a sixteenth of the step the motion is the same."""
    limits = limits_of("human", body)[1]
    ways = []
    for substeps in (8, 128):
        motion = pointing(16)
        settings = as_it_is(contact="parts", strength="human", substeps=substeps)
        simulator = holding(
            body, motion, shape=Box((0.1, 0.1, 0.1)), out=0.3, mass=30.0, settings=settings
        )
        frames = [simulator.step(motion[t]) for t in range(1, 16)]
        ways.append([f.objects["stick"][0] for f in frames])
        shares = np.array([np.linalg.norm(f.torque, axis=1) / limits for f in frames])
        assert np.max(shares) <= 1.0 + 1e-6
        assert shares[0][HAND] > 0.97  # 12 of the 88 N m needed to hold it
        assert shares[8][SHOULDER] > 0.97
    np.testing.assert_allclose(*ways, atol=0.05)  # first order: g h t alone is 2 cm
    assert ways[0][0][2] - ways[0][-1][2] > 0.6


def test_limp_arms_and_what_hangs_on_them_gain_no_energy(body):
    """An arm without strength, 10 kg in the hand: a pendulum of that mass, for 5 s."""
    arm = [f"right_{j}" for j in ("shoulder", "elbow", "wrist")]
    settings = as_it_is(contact="parts", strength=dict.fromkeys(arm, 0.0))
    motion = pointing(2)
    simulator = holding(
        body, motion, shape=Box((0.1, 0.1, 0.1)), out=0.3, mass=10.0, settings=settings
    )
    top = simulator.world.objects[0].pose(simulator.world.stepper.qpos())[0][2]
    lowest = top
    for t in range(150):
        frame = simulator.step(motion[0])
        at, v = frame.objects["stick"][0], simulator.velocity("stick")[0]
        energy = G * (at[2] - top) + 0.5 * v @ v  # per kg, without its spin
        assert energy < 1e-3 * G
        for j in arm:
            assert np.linalg.norm(frame.torque[JOINT_INDEX[j]]) < 0.01
        lowest = min(lowest, at[2])
        if t == 2:  # 0.1 s
            assert top - at[2] > 0.8 * 0.5 * G * 0.1**2
    assert top - lowest > 0.5


# -- in the way ----------------------------------------------------------------------------


@pytest.mark.parametrize("fps", [30.0, 120.0])
@pytest.mark.parametrize("contact", ["parts", "skin"])
def test_a_wall_that_it_meets_stops_the_hand(body, contact, fps):
    """Walking at 1.5 m/s with a stick held ahead: it stays out, in every substep."""
    frames = int(1.2 * fps)
    path = np.zeros((frames, 3))
    path[:, 0] = 1.5 * np.arange(frames) / fps
    motion = pointing(path=path, fps=fps)
    scene = Scene()
    tip = body.joints(motion[0])[HAND, 0] + 0.55 + 0.3
    scene.add_static("wall", Box((1, 8, 8)), position=(tip + 0.6 + 0.5, 0, 0))
    settings = as_it_is(contact=contact, record="substeps")
    simulator = holding(body, motion, scene=scene, settings=settings)
    first, pushed, nearest = None, 0.0, np.inf
    for t in range(1, frames):
        frame = simulator.step(motion[t])
        place = simulator.world.objects[0]
        for q in frame.substeps:
            gap = tip + 0.6 - corners(STICK.size, place.pose(q))[:, 0].max()
            nearest = min(nearest, gap)
        at, turn = place_in_part(body, frame)
        first = first or (at, turn)
        assert np.abs(at - first[0]).max() < 1e-9
        assert np.abs(turn - first[1]).max() < 1e-9
        touched = frame.contacts
        for k in range(len(touched.part)):
            assert touched.person[k] == -1
            assert simulator.names[touched.subject[k]] == "stick"
            assert simulator.names[touched.other[k]] == "wall"
            pushed -= touched.impulse[k, 0]
    assert 0.0 < nearest < 1.1e-3  # the margin is 1 mm
    assert pushed > 5.0
    hand = body.joints(frame.pose)[HAND, 0]
    assert hand < body.joints(motion[-1])[HAND, 0] - 0.3  # the motion goes this much farther
    assert np.linalg.norm(frame.torque[SHOULDER]) > 1.0


def test_what_it_hits_flies(body):
    """A bat swings at a ball at rest, without and with mass."""
    swing = np.concatenate([np.zeros(3), np.linspace(0, -1.2, 12), np.full(15, -1.2)])
    speeds = []
    for mass in (0.2, 5.0):
        motion = pointing(len(swing), swing=swing)
        scene = Scene(gravity=0.0)
        hand = body.joints(motion[0])[HAND]
        ball = hand + np.array([0.55 + 0.1, -0.25, 0.0])
        scene.add_object("ball", Sphere(0.08), mass=0.5, position=ball)
        simulator = holding(
            body,
            motion,
            scene=scene,
            mass=mass,
            settings=as_it_is(contact="parts", record="substeps"),
        )
        clear = np.inf
        for t in range(1, len(motion)):
            frame = simulator.step(motion[t])
            world = simulator.world
            for q in frame.substeps:
                at = {thing.name: thing.pose(q) for thing in world.objects}
                local = rot.rotate(rot.conjugate(at["stick"][1]), at["ball"][0] - at["stick"][0])
                out = np.maximum(np.abs(local) - 0.5 * np.asarray(STICK.size), 0.0)
                clear = min(clear, np.linalg.norm(out) - 0.08)
        assert clear > 0.0
        speeds.append(simulator.velocity("ball")[0])
    for v in speeds:
        assert v[1] < -2.0  # the stick's centre moves at 3 m/s


def test_it_meets_neither_its_holder_nor_what_the_holder_holds(body):
    motion = pointing(10)
    scene = Scene(gravity=0.0)
    at = body.joints(motion[0])[HAND]
    scene.add_object("ring", Box((0.3, 0.3, 0.3)), mass=1.0, position=at)
    scene.add_object("other", Box((0.3, 0.3, 0.3)), mass=1.0, position=at + np.array([0.1, 0, 0]))
    simulator = Simulator(scene, body=body, settings=PARTS)
    simulator.reset(motion[0])
    simulator.attach("ring")
    simulator.attach("other", "left_wrist")
    assert dict(simulator.held) == {"ring": (0, "right_wrist"), "other": (0, "left_wrist")}
    for t in range(1, 10):
        frame = simulator.step(motion[t])
        assert len(frame.contacts.part) == 0
        assert (frame.pose.translation == motion[t].translation).all()
    assert len(frame.inside.person) == 0


@pytest.mark.parametrize("shield", [False, True])
def test_it_meets_another_person_and_what_that_one_holds(body, shield):
    """One stands with a stick ahead, the other walks into it, with a shield or without."""
    a = pointing(55)
    path = np.zeros((55, 3))
    path[:, 0] = 3.0 - 1.5 * np.arange(55) / 30
    path[:, 1] = body.joints(a[0])[HAND, 1]
    b = t_pose(path)
    scene = Scene()
    scene.add_object("stick", STICK, **in_front(body, a[0]))
    ahead = body.joints(a[0])[HAND] + [2.45, 0.0, 0.0]
    scene.add_object("shield", Box((0.02, 0.5, 0.5)), mass=1.0, position=ahead)
    simulator = Simulator(scene, body=[body, body], settings=PARTS)
    simulator.reset([a[0], b[0]])
    simulator.attach("stick", person=0)
    if shield:
        simulator.attach("shield", "spine3", person=1)
    else:
        simulator.remove_object("shield")
    touched = set()
    for t in range(1, 55):
        frame = simulator.step([a[t], b[t]])
        c, names = frame.contacts, simulator.names
        for k in range(len(c.part)):
            who = names[c.subject[k]] if c.person[k] < 0 else int(c.person[k])
            touched.add((who, names[c.other[k]]))
    assert (("stick", "shield") if shield else (1, "stick")) in touched
    assert not touched & {(0, "stick"), (1, "shield")}
    assert len(frame.inside.person) == 0
    assert frame.poses[1].translation[0] > path[-1, 0] + 0.05  # stopped
    assert frame.poses[0].translation[0] < -0.01  # pushed back
