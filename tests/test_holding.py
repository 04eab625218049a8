"""Things held to a part of a person: rigid, heavy, in the way of others, and let go of."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from people import t_pose, violent

from halfphysics import rotations as rot
from halfphysics.body import Body
from halfphysics.errors import InputError
from halfphysics.motion import Motion
from halfphysics.scene import Scene
from halfphysics.settings import Settings
from halfphysics.shapes import Box, Plane, Sphere
from halfphysics.simulator import Simulator
from halfphysics.skeleton import JOINT_INDEX, PARENTS
from halfphysics.strength import limits_of

HAND = JOINT_INDEX["right_wrist"]
SHOULDER = JOINT_INDEX["right_shoulder"]
PARTS = Settings(contact="parts")
G = 9.81
STICK = Box((0.6, 0.03, 0.03))
DOOR = """
<mujoco><worldbody><body name="leaf"><joint type="hinge" axis="0 0 1"/>
<geom type="box" size="0.4 0.02 1" mass="20"/></body></worldbody></mujoco>
"""


@pytest.fixture(scope="module")
def body():
    return Body.default()


def pointing(frames=60, swing=None, path=None, fps=30.0):
    """Upright, facing +x, the right arm stretched ahead; `swing` (T,) turns it sideways [rad]."""
    motion = t_pose(np.zeros((frames, 3)) if path is None else path, fps)
    rotations = motion.rotations.copy()
    ahead = np.full(len(rotations), np.pi / 2) + (0.0 if swing is None else swing)
    rotations[:, SHOULDER, 1] = ahead
    return Motion(motion.translation, rotations, fps)


def in_front(body, pose, out=0.55, **options):
    """Options of a thing `out` [m] in front of the right wrist, along +x."""
    at = body.joints(pose)[HAND] + [out, 0.0, 0.0]
    return {"position": at, "mass": 1.0} | options


def holding(body, motion, shape=STICK, settings=PARTS, scene=None, part="right_wrist", **options):
    """A simulator at the motion's first pose that holds "stick"."""
    scene = Scene() if scene is None else scene
    scene.add_object("stick", shape, **in_front(body, motion[0], **options))
    simulator = Simulator(scene, body=body, settings=settings, fps=motion.fps)
    simulator.reset(motion[0])
    simulator.attach("stick", part)
    return simulator


def place_in_part(body, frame, part=HAND, name="stick"):
    """Pose of the held thing in the part's frame: position (3,) and matrix (3, 3)."""
    x, q = body.joint_frames(frame.pose)
    back = rot.conjugate(q[part])
    at, turn = frame.objects[name]
    return rot.rotate(back, at - x[part]), rot.to_matrix(rot.multiply(back, turn))


def corners(size, pose):
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    return pose[0] + rot.rotate(pose[1], 0.5 * signs * np.asarray(size))


def same(a, b):
    """Are two frames equal to the last bit?"""
    assert (a.pose.translation == b.pose.translation).all()
    assert (a.pose.rotations == b.pose.rotations).all()
    assert (a.torque == b.torque).all()
    for name in a.objects:
        for x, y in zip(a.objects[name], b.objects[name], strict=True):
            assert (x == y).all()
    assert (a.contacts.impulse == b.contacts.impulse).all()


# -- rigid, and heavy ----------------------------------------------------------------------


@pytest.mark.parametrize(
    "settings",
    [PARTS, Settings.paper(contact="parts"), Settings()],
    ids=["parts", "paper", "skin"],
)
@pytest.mark.parametrize("part", ["right_wrist", "head", "pelvis"])
def test_it_moves_with_the_part_as_the_motion_says(body, settings, part):
    """At 15 m/s and through half turns; nothing is in the way: the reference, to rounding."""
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
    """Mean generalised force (nv,) of the held things alone, by MuJoCo, at `poses` (N, nq)."""
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
    """Against MuJoCo's inverse dynamics of the held thing alone, frame by frame."""
    settings = Settings(contact="parts", record="substeps")
    motion = violent(12, seed=1)
    options = {"mass": 2.0, "com": (0.1, 0.02, 0.0), "quaternion": rot.exp([0.3, 0.1, -0.5])}
    simulator = holding(body, motion, settings=settings, **options)
    before = None
    for t in range(1, len(motion)):
        start = np.array(simulator.world.stepper.qpos())
        frame = simulator.step(motion[t])
        world, after = simulator.world, np.array(simulator.world.stepper.qvel())
        if before is None:
            before = after  # nobody knows how the first pose was come to
        poses = np.concatenate([start[None], frame.substeps[:-1]])
        force = inverse_dynamics(world, before, after, 1 / 30, poses)
        expected = world.torques(force[3:].reshape(-1, 3))[0]
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
        body, motion, mass=1.0, settings=Settings(contact="parts", strength="human")
    )
    for t in range(1, len(motion)):
        frame = simulator.step(motion[t])
        np.testing.assert_allclose(body.joints(frame.pose), body.joints(motion[t]), atol=1e-12)
    assert 10.0 < np.linalg.norm(frame.torque[SHOULDER]) < 80.0  # of 80


def test_who_is_not_gives_way(body):
    """30 kg at arm's length: first the wrist, then the arm comes down, and swings; nothing exerts
    more than it can, and with a sixteenth of the step it is the same."""
    limits = limits_of("human", body)[1]
    ways = []
    for substeps in (8, 128):
        motion = pointing(16)
        settings = Settings(contact="parts", strength="human", substeps=substeps)
        simulator = holding(
            body, motion, shape=Box((0.1, 0.1, 0.1)), out=0.3, mass=30.0, settings=settings
        )
        frames = [simulator.step(motion[t]) for t in range(1, 16)]
        ways.append([f.objects["stick"][0] for f in frames])
        shares = np.array([np.linalg.norm(f.torque, axis=1) / limits for f in frames])
        assert np.max(shares) <= 1.03
        assert shares[0][HAND] > 0.97  # 12 of the 88 N m that it would take
        assert shares[8][SHOULDER] > 0.97
    np.testing.assert_allclose(*ways, atol=0.05)  # of first order: g h t alone is 2 cm
    assert ways[0][0][2] - ways[0][-1][2] > 0.6


def test_limp_arms_and_what_hangs_on_them_gain_no_energy(body):
    """An arm without strength, 10 kg in the hand: a pendulum, for 5 s, as heavy as that."""
    arm = [f"right_{j}" for j in ("shoulder", "elbow", "wrist")]
    settings = Settings(contact="parts", strength=dict.fromkeys(arm, 0.0))
    motion = pointing(2)
    simulator = holding(
        body, motion, shape=Box((0.1, 0.1, 0.1)), out=0.3, mass=10.0, settings=settings
    )
    top = simulator.world.things[0].pose(simulator.world.stepper.qpos())[0][2]
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
    settings = Settings(contact=contact, record="substeps")
    simulator = holding(body, motion, scene=scene, settings=settings)
    first, pushed, nearest = None, 0.0, np.inf
    for t in range(1, frames):
        frame = simulator.step(motion[t])
        place = simulator.world.things[0]
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
    assert 0.0 < nearest < 1.1e-3  # of 1 mm asked
    assert pushed > 5.0
    hand = body.joints(frame.pose)[HAND, 0]
    assert hand < body.joints(motion[-1])[HAND, 0] - 0.3  # it asked to go this much farther
    assert np.linalg.norm(frame.torque[SHOULDER]) > 1.0


def test_what_it_hits_flies(body):
    """A bat that swings at a ball at rest, without and with weight in it."""
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
            settings=Settings(contact="parts", record="substeps"),
        )
        clear = np.inf
        for t in range(1, len(motion)):
            frame = simulator.step(motion[t])
            world = simulator.world
            for q in frame.substeps:
                at = {thing.name: thing.pose(q) for thing in world.things}
                local = rot.rotate(rot.conjugate(at["stick"][1]), at["ball"][0] - at["stick"][0])
                out = np.maximum(np.abs(local) - 0.5 * np.asarray(STICK.size), 0.0)
                clear = min(clear, np.linalg.norm(out) - 0.08)
        assert clear > 0.0
        speeds.append(simulator.velocity("ball")[0])
    for v in speeds:
        assert v[1] < -2.0  # the stick's middle comes at 3 m/s


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
    assert frame.poses[1].translation[0] > path[-1, 0] + 0.05  # held up
    assert frame.poses[0].translation[0] < -0.01  # pushed back


# -- let go --------------------------------------------------------------------------------


def test_let_go_it_flies_on_as_a_free_body(body):
    """With the material velocity of the part: as a thing that starts so by itself, to 1e-9 m."""
    swing = 0.6 * np.sin(np.arange(20) * 0.5)
    motion = pointing(20, swing=swing)
    options = {"mass": 0.7, "com": (0.1, 0.02, 0.0), "out": 0.6}
    simulator = holding(body, motion, **options)
    for t in range(1, 12):
        frame = simulator.step(motion[t])
    position, quat = frame.objects["stick"]
    # The shoulder turns at one rate within a frame.
    v, w = simulator.velocity("stick")
    x = body.joints(frame.pose)[SHOULDER]
    rate = (swing[11] - swing[10]) * 30
    np.testing.assert_allclose(w, [0, 0, rate], atol=1e-9)
    np.testing.assert_allclose(v, np.cross(w, position - x), atol=1e-9)
    simulator.release("stick")
    np.testing.assert_allclose(simulator.velocity("stick"), (v, w), atol=1e-12)
    alone = Scene()
    alone.add_object(
        "stick",
        STICK,
        mass=0.7,
        com=(0.1, 0.02, 0.0),
        position=position,
        quaternion=quat,
        velocity=v,
        angular_velocity=w,
    )
    free = Simulator(alone, body=[])
    free.reset([])
    for _ in range(12, 20):
        x, y = simulator.step(motion[11]), free.step([])
        np.testing.assert_allclose(x.objects["stick"][0], y.objects["stick"][0], atol=1e-9)
        np.testing.assert_allclose(x.objects["stick"][1], y.objects["stick"][1], atol=1e-9)
    assert dict(simulator.held) == {}


@pytest.mark.parametrize("contact", ["parts", "skin"])
def test_let_go_in_the_hand_it_comes_out_gently(body, contact):
    """A ball through the palm: it never gets deeper, nothing jumps, and it ends outside."""
    motion = pointing(40)
    scene = Scene(gravity=0.0)
    scene.add_object(
        "ball", Sphere(0.05), mass=0.3, position=body.joints(motion[0])[HAND] + [0.08, 0.0, 0.0]
    )
    simulator = Simulator(scene, body=body, settings=Settings(contact=contact))
    simulator.reset(motion[0])
    simulator.attach("ball")
    for t in range(1, 5):
        frame = simulator.step(motion[t])
        assert len(frame.inside.person) == 0
    before, joints = frame.objects["ball"][0], body.joints(frame.pose)
    simulator.release("ball")
    depth = np.inf
    for t in range(5, 40):
        frame = simulator.step(motion[t])
        inside = frame.inside.depth.max(initial=0.0)
        assert inside <= depth + 1e-6
        depth = inside
        moved = np.linalg.norm(frame.objects["ball"][0] - before)
        assert moved < 0.85 / 30  # nobody is thrown
        assert np.abs(body.joints(frame.pose) - joints).max() < 0.85 / 30
        before, joints = frame.objects["ball"][0], body.joints(frame.pose)
    assert depth == 0.0


def test_let_go_against_a_wall_it_stays_out(body):
    """Pressed to a wall, then free: it falls along it."""
    path = np.zeros((60, 3))
    path[:, 0] = np.minimum(1.0 * np.arange(60) / 30, 0.6)
    motion = pointing(path=path)
    scene = Scene()
    tip = body.joints(motion[0])[HAND, 0] + 0.55 + 0.3
    scene.add_static("wall", Box((1, 8, 8)), position=(tip + 0.3 + 0.5, 0, 0))
    scene.add_static("floor", Plane(offset=-1.5))
    settings = Settings(contact="parts", record="substeps")
    simulator = holding(body, motion, scene=scene, settings=settings)
    for t in range(1, 60):
        if t == 30:
            simulator.release("stick")
        frame = simulator.step(motion[t])
        place = simulator.world.things[0]
        for q in frame.substeps:
            points = corners(STICK.size, place.pose(q))
            assert points[:, 0].max() < tip + 0.3
            assert points[:, 2].min() > -1.5
    assert points[:, 2].max() < -1.0


# -- states, and what comes and goes -------------------------------------------------------


def states(body):
    """A run with everything: wall, other things, held twice, let go; frames, states."""
    path = np.zeros((36, 3))
    path[:, 0] = 1.2 * np.arange(36) / 30
    motion = pointing(path=path, swing=0.2 * np.sin(np.arange(36) * 0.5))
    scene = Scene()
    tip = body.joints(motion[0])[HAND, 0] + 0.55 + 0.3
    scene.add_static("wall", Box((1, 8, 8)), position=(tip + 0.2 + 0.5, 0, 0))
    scene.add_object("ball", Sphere(0.1), mass=0.5, position=(tip + 0.05, -0.5, 0.3))
    scene.add_object(
        "cube", Box((0.1, 0.1, 0.1)), mass=0.5, position=(0.0, 1.2, 0.4), start="asleep"
    )
    scene.add_object("stick", STICK, **in_front(body, motion[0]))
    settings = Settings(contact="parts", strength="human", stiffness={"hands": 0.5})
    simulator = Simulator(scene, body=body, settings=settings)
    simulator.reset(motion[0])
    kept, frames = [], []
    for t in range(1, 36):
        if t == 4:
            simulator.attach("stick")
        if t == 12:
            simulator.attach("cube", "left_wrist")
        if t == 20:
            simulator.set_stiffness({"right_wrist": 0.2})
        if t == 24:
            simulator.release("stick")
        kept.append(simulator.get_state())
        frames.append(simulator.step(motion[t]))
    return simulator, motion, kept, frames


def test_a_state_says_who_holds_what_and_goes_on_bit_by_bit(body):
    simulator, motion, kept, frames = states(body)
    assert max(len(f.contacts.part) for f in frames) > 0
    assert dict(simulator.held) == {"cube": (0, "left_wrist")}
    other = Simulator(simulator.world.scene, body=body, settings=simulator.settings)
    for t in (14, 2, 30, 8, 22):
        for one in (simulator, other):
            one.set_state(kept[t])
            expected = {"stick"} if 3 <= t < 11 else {"stick", "cube"} if t < 23 else {"cube"}
            assert set(one.held) == (expected if t >= 3 else set())
            # Until somebody takes or leaves something.
            for k in range(t, min(t + 8, next((c for c in (3, 11, 19, 23) if c > t), 35))):
                same(one.step(motion[k + 1]), frames[k])


def test_twice_the_same(body):
    for a, b in zip(states(body)[3], states(body)[3], strict=True):
        same(a, b)


def test_a_reset_lets_go(body):
    motion = pointing(10)
    simulator = holding(body, motion)
    simulator.step(motion[1])
    first = simulator.reset(motion[0])
    assert dict(simulator.held) == {}
    fresh = Simulator(simulator.world.scene, body=body, settings=PARTS)
    same(first, fresh.reset(motion[0]))
    for t in range(1, 10):
        same(simulator.step(motion[t]), fresh.step(motion[t]))


def test_things_come_and_go_while_something_is_held(body):
    motion = pointing(20, swing=0.2 * np.sin(np.arange(20) * 0.4))
    simulator, alone = holding(body, motion, mass=2.0), holding(body, motion, mass=2.0)
    for t in range(1, 20):
        if t == 6:
            simulator.add_object("lamp", Sphere(0.1), mass=1.0, position=(0, 30, 0))
        if t == 12:
            simulator.remove_object("lamp")
        a, b = simulator.step(motion[t]), alone.step(motion[t])
        np.testing.assert_allclose(a.objects["stick"][0], b.objects["stick"][0], atol=1e-12)
        np.testing.assert_allclose(a.torque, b.torque, atol=1e-9)
    simulator.remove_object("stick")
    assert dict(simulator.held) == {}
    frame = simulator.step(motion[0])
    assert frame.objects == {}
    simulator.add_object("stick", STICK, **in_front(body, motion[0]))
    assert dict(simulator.held) == {}


def test_what_sleeps_or_lies_somewhere_is_picked_up(body):
    path = np.zeros((30, 3))
    path[:, 2] = np.maximum(0.0, np.arange(30) - 5) / 30
    motion = pointing(path=path)
    at = body.joints(motion[0])[HAND] + [0.5, 0.0, 0.0]
    scene = Scene()
    scene.add_static("table", Box((0.4, 0.4, 0.1)), position=at - [0.0, 0.0, 0.1])
    scene.add_object("box", Box((0.1, 0.1, 0.1)), mass=1.0, position=at, start="asleep")
    scene.add_object("lid", Box((0.1, 0.1, 0.02)), mass=0.2, position=at + np.array([0, 0, 0.06]))
    simulator = Simulator(scene, body=body, settings=PARTS)
    simulator.reset(motion[0])
    for t in range(1, 5):
        simulator.step(motion[t])
    simulator.attach("box")
    for t in range(5, 30):
        frame = simulator.step(motion[t])
    np.testing.assert_allclose(frame.objects["box"][0], at + path[-1], atol=1e-3)
    np.testing.assert_allclose(
        frame.objects["lid"][0] - frame.objects["box"][0], [0, 0, 0.06], atol=3e-3
    )
    names = {simulator.names[k] for k in frame.contacts.subject} | {
        simulator.names[k] for k in frame.contacts.other
    }
    assert names == {"box", "lid"}


def test_a_ray_and_a_velocity_find_it(body):
    motion = pointing(10)
    simulator = holding(body, motion)
    frame = simulator.step(motion[1])
    at = frame.objects["stick"][0]
    hit = simulator.ray(at + np.array([0.0, 0.0, 1.0]), (0, 0, -1))
    assert hit.name == "stick"
    np.testing.assert_allclose(simulator.velocity("stick"), 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("do", "says"),
    [
        (lambda s: s.attach("stik"), "attach: there is no object called 'stik'; did you mean"),
        (lambda s: s.attach("wall"), "no object called 'wall'"),
        (lambda s: s.attach("stick", "hand"), "part: found 'hand', expected a joint's name"),
        (lambda s: s.attach("stick", "right_writs"), "did you mean 'right_wrist'"),
        (lambda s: s.attach("stick", 3), "part: found 3"),
        (lambda s: s.attach("stick", person=1), "person: found 1, expected 0 to 0"),
        (lambda s: s.attach("stick", person=-1), "person: found -1"),
        (lambda s: s.attach("stick", person=True), "person: found True"),
        (lambda s: s.attach("stick", person="me"), "person: found 'me'"),
        (lambda s: s.attach("cup"), "the left_wrist of 'person' holds it already"),
        (lambda s: s.attach("lift"), "moves along its trajectory"),
        (lambda s: s.attach("door"), "'door' is articulated"),
        (lambda s: s.attach("door/leaf"), "'door/leaf' is articulated"),
        (lambda s: s.release("stick"), "nobody holds 'stick'. Held: cup"),
        (lambda s: s.release("cu"), "release: there is no object called 'cu'"),
        (lambda s: s.release("door"), "'door' is articulated"),
        (lambda s: s.apply_impulse("cup", (0, 0, 1)), "left_wrist of 'person' holds 'cup'"),
        (lambda s: s.set_velocity("cup", (0, 0, 1)), "release\\('cup'\\) it first"),
    ],
)
def test_what_is_wrong_is_said_and_changes_nothing(body, do, says):
    motion = pointing(2)
    scene = Scene()
    scene.add_static("wall", Box((1, 1, 1)), position=(9, 0, 0))
    scene.add_object("stick", STICK, **in_front(body, motion[0]))
    scene.add_object("cup", Sphere(0.05), mass=0.3, position=(0, 2, 0))
    scene.add_moving("lift", Box((1, 1, 1)), [[9, 9, 9]], fps=30)
    scene.add_articulated("door", DOOR, position=(0, -9, 0))
    simulator = Simulator(scene, body=body, settings=PARTS)
    with pytest.raises(InputError, match="reset"):
        simulator.attach("stick")
    with pytest.raises(InputError, match="reset"):
        simulator.release("stick")
    simulator.reset(motion[0])
    simulator.attach("cup", "left_wrist")
    held, state = dict(simulator.held), simulator.get_state()
    with pytest.raises(InputError, match=says):
        do(simulator)
    assert dict(simulator.held) == held
    assert simulator.get_state().numbers == state.numbers
    empty = Simulator(scene, body=[])
    empty.reset([])
    with pytest.raises(InputError, match="nobody is there"):
        empty.attach("stick")
