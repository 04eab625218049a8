"""Whoever stands on a movable thing holds it by friction, up to the friction of its weight."""

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from support.as_it_is import as_it_is
from support.bent_knees import BODY, WEIGHT, G, mass, standing
from support.real_clips import real_clip

FPS = 240.0
TOP = 0.05  # of the boards [m]


def board(friction, floor=0.0, size=1.6, board_mass=20.0):
    """A board on a floor; `friction`: with people."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object(
        "board", hp.Box((size, size, TOP)), mass=board_mass, position=(0.0, 0.0, TOP / 2 + 1e-4)
    )
    scene.friction("floor", "board", floor)
    scene.friction("person", "board", friction)
    return scene


def placed(motion, up):
    """The same, so much higher [m]."""
    return motion.with_frames(motion.translation + np.array([0.0, 0.0, up]), motion.rotations)


def set_off(scene, velocity, frames, motion, spin=(0.0, 0.0, 0.0), settings=WEIGHT):
    """Poses of the board after it is set off under somebody who has stood on it for 0.3 s."""
    sim = hp.Simulator(scene, body=BODY, fps=FPS, settings=settings)
    sim.reset(motion[0])
    for t in range(1, 72):
        sim.step(motion[t])
    sim.set_velocity("board", velocity, spin)
    return [sim.step(motion[72 + k]).objects["board"] for k in range(frames)]


def plate(joint, inertia="1 1 1", spring=""):
    """A plate of 2 m, its top at z = 0, on one joint."""
    return f"""<mujoco><worldbody><body name="plate" pos="0 0 -0.025">
    <inertial pos="0 0 0" mass="20" diaginertia="{inertia}"/>
    <joint name="joint" {joint} {spring}/>
    <geom type="box" size="1 1 .025"/></body></worldbody></mujoco>"""


@pytest.mark.parametrize("mu", [0.05, 0.3])
def test_a_board_that_slides_under_somebody_is_slowed_down_by_the_friction_of_its_weight(mu):
    path = set_off(board(mu), (2.0, 1.0, 0.0), 12, standing(90, FPS, top=TOP))
    speed = np.diff([pose[0][:2] for pose in path], axis=0) * FPS
    slowing = -np.diff(speed, axis=0).mean(axis=0) * FPS
    expected = mu * mass() * G / 20.0 * np.array([2.0, 1.0]) / np.sqrt(5.0)
    np.testing.assert_allclose(slowing, expected, rtol=0.01)


def test_it_stops_there_and_stays():
    path = set_off(board(0.5), (0.3, 0.0, 0.0), 60, standing(140, FPS, top=TOP))
    x = np.array([pose[0][0] for pose in path])
    # v^2 / (2 mu m g / M), less half a substep: it moves by the velocity at its end.
    assert x[-1] == pytest.approx(0.3**2 / (mass() * G / 20.0) - 0.5 * 0.3 / FPS, rel=0.02)
    assert np.ptp(x[30:]) < 1e-5


def test_without_friction_it_slides_on():
    path = set_off(board(0.0), (0.3, 0.0, 0.0), 60, standing(140, FPS, top=TOP))
    speed = np.diff([pose[0][0] for pose in path]) * FPS
    np.testing.assert_allclose(speed, 0.3, atol=1e-6)


def test_who_has_no_weight_holds_nothing():
    motion = standing(140, FPS, top=TOP + 0.01)
    path = set_off(board(0.5), (0.3, 0.0, 0.0), 60, motion, settings=as_it_is())
    speed = np.diff([pose[0][0] for pose in path]) * FPS
    np.testing.assert_allclose(speed, 0.3, atol=1e-6)


@pytest.mark.parametrize(("push", "moves"), [(0.95, False), (1.1, True)])
def test_what_pushes_less_than_friction_moves_nothing(push, moves):
    """A plate on a track, pulled by a spring that is far away."""
    mu, stiffness = 0.4, 10.0
    pull = push * mu * mass() * G
    spring = f'stiffness="{stiffness}" springref="{pull / stiffness}"'
    scene = hp.Scene()
    scene.add_articulated("plate", plate('type="slide" axis="1 0 0"', spring=spring))
    scene.friction("person", "plate", mu)
    x = hp.simulate(standing(400, FPS), scene, body=BODY, settings=WEIGHT).joints["plate/joint"]
    if not moves:  # once what it went before the weight was there is over
        assert np.ptp(x[-60:]) < 1e-6
        return
    went = x[119] - x[60]
    time, first = 59 / FPS, (x[60] - x[59]) * FPS
    free = (pull - mu * mass() * G) / 20.0
    assert went == pytest.approx(first * time + 0.5 * free * time**2, rel=0.1)


def test_a_turntable_is_held_with_the_lever_of_where_one_stands():
    mu, inertia, radius = 0.2, 60.0, 0.8
    scene = hp.Scene()
    scene.add_articulated(
        "plate",
        plate('type="hinge" axis="0 0 1"', f"{inertia} {inertia} {inertia}"),
        velocities={"joint": 2.0},
    )
    scene.friction("person", "plate", mu)
    motion = standing(60, FPS, at=(radius, 0.0))
    angle = hp.simulate(motion, scene, body=BODY, settings=WEIGHT).joints["plate/joint"]
    slowing = -np.diff(angle, n=2)[30:].mean() * FPS**2
    # 2 %: a foot is not a point.
    assert slowing == pytest.approx(mu * mass() * G * radius / inertia, rel=0.02)


def test_a_turntable_stops_under_who_stands_on_its_axis():
    """By the moment of two feet that stand apart."""
    mu, inertia = 0.2, 5.0
    scene = hp.Scene()
    scene.add_articulated(
        "plate",
        plate('type="hinge" axis="0 0 1"', f"{inertia} {inertia} {inertia}"),
        velocities={"joint": 1.0},
    )
    scene.friction("person", "plate", mu)
    angle = hp.simulate(standing(240, FPS), scene, body=BODY, settings=WEIGHT).joints["plate/joint"]
    turning = np.diff(angle) * FPS
    slowing = (turning[20] - turning[60]) / (40 / FPS)
    # Feet are 0.1 to 0.25 m from the axis.
    assert 0.1 < slowing * inertia / (mu * mass() * G) < 0.25
    assert np.abs(turning[-60:]).max() < 1e-6


@pytest.mark.parametrize("fps", [30.0, 60.0, 240.0])
def test_soles_that_come_down_and_leave_do_not_hold_what_goes_along(fps):
    """What a point bears before it has a speed, and while it loses its load, is no brake."""
    speed, count = 0.12, int(1.5 * fps)
    motion = standing(count, fps, top=TOP)
    time = np.arange(count) / fps
    way = np.stack([speed * time, 0.0 * time, 2.0 * np.maximum(time - 1.0, 0.0)], axis=1)
    motion = motion.with_frames(motion.translation + way, motion.rotations)
    sim = hp.Simulator(board(0.5), body=BODY, fps=fps, settings=WEIGHT)
    sim.reset(motion[0])
    sim.set_velocity("board", (speed, 0.0, 0.0))
    for t in range(1, count):
        sim.step(motion[t])
        assert sim.velocity("board")[0][0] == pytest.approx(speed, abs=1e-6)


@pytest.mark.parametrize("fps", [60.0, 120.0])
def test_a_recorded_walk_over_a_board(fps):
    """Points before and behind it carry 1e-300 of the weight: nothing is divided by that."""
    clip = real_clip("asap_walk1.npz").resample(fps)
    low = BODY.vertices(clip[:2])[0, :, 2].min()
    motion = placed(clip, TOP + 1.3e-3 - low)
    scene = board(0.6, floor=0.6, size=6.0, board_mass=60.0)
    result = hp.simulate(motion, scene, body=BODY, settings=WEIGHT)
    # Friction of the floor, with the board's own weight besides, is the stronger one.
    went = result.objects["board"].position - result.objects["board"].position[0]
    assert np.abs(went).max() < 1e-3


def test_who_leans_over_the_edge_of_its_feet_breaks_nothing():
    """At some angles a patch is left with 1e-310 of the weight."""
    for lean in (*np.arange(-0.4, 0.4, 0.04), 0.324, 0.328):
        motion = standing(12, 120.0, top=TOP)
        rotations = motion.rotations.copy()
        rotations[:, 0, 0] += lean
        for side in ("left", "right"):
            rotations[:, hp.JOINT_NAMES.index(f"{side}_ankle"), 0] -= lean
        motion = motion.with_frames(motion.translation, rotations)
        low = BODY.vertices(motion[:2])[0, :, 2].min()
        motion = placed(motion, TOP + 0.0012 - low)
        sim = hp.Simulator(board(0.3, size=3.0), body=BODY, fps=120.0, settings=WEIGHT)
        sim.reset(motion[0])
        sim.set_velocity("board", (0.1, 0.0, 0.0))
        for t in range(1, 12):
            position, turn = sim.step(motion[t]).objects["board"]
        assert np.isfinite(position).all()
        assert np.isfinite(turn).all()


def test_what_a_person_passes_through_is_neither_held_nor_stood_on():
    scene = board(0.5)
    scene.ignore("person", "board")
    motion = standing(140, FPS, top=TOP)
    path = set_off(scene, (0.3, 0.0, 0.0), 60, motion)
    speed = np.diff([pose[0][0] for pose in path]) * FPS
    np.testing.assert_allclose(speed, 0.3, atol=1e-6)
    result = hp.simulate(motion, scene, body=BODY, settings=WEIGHT)
    # It stands on the floor under it.
    assert result.motion.translation[-1, 2] - motion.translation[-1, 2] == pytest.approx(
        -TOP, abs=0.005
    )


def test_steps_that_are_cut_short_have_the_friction_of_a_whole_one():
    """At most: light things fall fast, the solver is given little to do, and time is lost."""
    rng = np.random.default_rng(1)
    mu, heavy, fps = 0.02, 200.0, 15.0
    scene = board(mu, size=4.0, board_mass=heavy)
    for k in range(30):
        at = np.array([1.2, 0.0, 0.3 + 0.12 * (k // 2)]) + rng.uniform(-0.15, 0.15, 3)
        shape = (hp.Box((0.3, 0.02, 0.02)), hp.Sphere(0.03), hp.Box((0.1, 0.1, 0.1)))[k % 3]
        scene.add_object(f"thing{k}", shape, mass=0.05, position=at, velocity=(0.0, 0.0, -12.0))
        scene.friction(f"thing{k}", "board", 0.0)
    settings = as_it_is(weight=True, substeps=1, max_sweeps=1)
    motion = standing(60, fps, top=TOP)
    sim = hp.Simulator(scene, body=BODY, fps=fps, settings=settings)
    sim.reset(motion[0])
    sim.set_velocity("board", (2.0, 0.0, 0.0))
    most, before, shortened = mu * mass() * G / (heavy * fps), 2.0, 0
    for t in range(1, 40):
        shortened += int(sim.step(motion[t]).diagnostics["shortened"])
        now = sim.velocity("board")[0][0]
        assert before - now < 1.001 * most
        before = now
    assert shortened


def test_soles_that_creep_take_a_board_along():
    """And only as fast as they go."""
    motion = standing(240, FPS, top=TOP)
    speed = np.array([0.06, -0.08, 0.0])
    time = np.maximum(np.arange(240) - 60, 0)[:, None] / FPS
    creeps = motion.with_frames(motion.translation + time * speed, motion.rotations)
    result = hp.simulate(creeps, board(0.5), body=BODY, settings=WEIGHT)
    went = np.diff(result.objects["board"].position[150:], axis=0).mean(axis=0) * FPS
    np.testing.assert_allclose(went[:2], speed[:2], atol=1e-4)
    off = hp.simulate(creeps, board(0.0), body=BODY, settings=WEIGHT)
    assert np.abs(off.objects["board"].position[:, :2]).max() < 1e-3


def test_who_turns_on_the_spot_turns_what_it_stands_on():
    motion = standing(240, FPS)
    rate = 0.4
    angle = rate * np.maximum(np.arange(240) - 60, 0) / FPS
    about = np.array([[0.0, 0.0, 1.0]]) * angle[:, None]
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.log(rot.multiply(rot.exp(about), rot.exp(motion.rotations[:, 0])))
    turns = motion.with_frames(motion.translation, rotations)
    scene = hp.Scene()
    scene.add_articulated("plate", plate('type="hinge" axis="0 0 1"', "2 2 2"))
    scene.friction("person", "plate", 0.5)
    joint = hp.simulate(turns, scene, body=BODY, settings=WEIGHT).joints["plate/joint"]
    assert np.diff(joint[150:]).mean() * FPS == pytest.approx(rate, rel=0.02)


def test_the_person_is_where_it_would_be_without():
    motion = standing(90, FPS, top=TOP)
    ends = []
    for mu in (0.0, 0.5):
        sim = hp.Simulator(board(mu), body=BODY, fps=FPS, settings=WEIGHT)
        sim.reset(motion[0])
        for t in range(1, 40):
            sim.step(motion[t])
        sim.set_velocity("board", (0.2, 0.0, 0.0))
        ends.append(sim.step(motion[40]).pose.translation)
    np.testing.assert_array_equal(*ends)


def test_a_saved_state_goes_on_to_the_bit():
    motion = standing(120, FPS, top=TOP)
    creeps = motion.with_frames(
        motion.translation + np.arange(120)[:, None] / FPS * [0.05, 0.0, 0.0], motion.rotations
    )
    sim = hp.Simulator(board(0.3), body=BODY, fps=FPS, settings=WEIGHT)
    ends = []
    for stop in (120, 50):
        sim.reset(creeps[0])
        for t in range(1, 120):
            if t == stop:
                state = sim.get_state()
                sim.step(motion[0])
                sim.set_state(state)
            frame = sim.step(creeps[t])
        ends.append(np.concatenate(frame.objects["board"]))
    np.testing.assert_array_equal(*ends)
    assert ends[0][0] > 0.005
