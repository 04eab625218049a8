"""Steps that conflicts forbid as a whole: margins are reduced, and the rest is made in pieces."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator
from support.as_it_is import as_it_is
from support.judges.person_hulls import CONTACTS
from support.people import FACING_X, t_pose

pytest.importorskip("coal")

from campaigns import attacks
from campaigns.clear import not_clear, run, set_up, throw_cases
from support.judges.clear_judge import Judge

DRIVES = pytest.mark.parametrize("drive", [None, 0.02], ids=["alg1", "tau"])
#: Throws that once lost 1 to 33 % of the time.
JAMMED = (
    "throw-tpose-plate-5x-60fps-N1-l0-alg1",
    "throw-curled-sheet-5x-30fps-N2-l10-alg1",
    "throw-curled-mesh_pole-5x-30fps-N4-l0-alg1",
    "throw-tumbling-stair-1x-30fps-N1-l1-alg1",
)
#: Largest lost share of the time.
LOST = 0.005
#: The margin, its reduced minimum, and the minimum gap: below the second only the solver's
#: residual reduces gaps [m].
CLEARANCE, LEAST, FLOOR = 1e-3, 1e-4, 2e-5
#: Of the case whose budget ends; speed of the ball beside it [m/s], and its spin [rad/s].
SUBSTEPS, BALL, SPIN = 8, 3.0, 400.0


@pytest.fixture(scope="module")
def body():
    return Body.default()


@pytest.mark.slow
@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize("name", JAMMED)
def test_a_jam_takes_no_time(name, contact):
    row = run(next(c for c in throw_cases() if c.id == name), contact=contact)
    assert row["touched"] > 0
    assert not not_clear(row)
    assert row["lost"] <= LOST


def alley(width, z=0.0):
    """Two walls that face each other across y, open to both ends."""
    scene = Scene()
    for side in (-1.0, 1.0):
        scene.add_static(
            f"wall{side:+g}", Box((4.0, 0.2, 4.0)), position=(0.0, side * (0.5 * width + 0.1), z)
        )
    return scene


def arms_out(body, frames, fps=30.0):
    """From arms down to the T-pose and back, the pelvis at the origin."""
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = FACING_X
    down = 1.2 * np.abs(np.linspace(-1.0, 1.0, frames))
    rotations[:, 16, 2], rotations[:, 17, 2] = -down, down
    motion = Motion(np.zeros((frames, 3)), rotations, fps)
    return motion.with_frames(-body.joints(motion)[:, 0], rotations)


@pytest.mark.slow
@DRIVES
@pytest.mark.parametrize("substeps", [1, 4, 8])
@pytest.mark.parametrize("contact", CONTACTS)
def test_arms_that_do_not_fit_between_walls_stop_nobody(body, contact, drive, substeps):
    """The targets are 0.2 m inside each wall: the arms stay out, and return the same way."""
    motion = arms_out(body, 61)
    settings = Settings(contact=contact, substeps=substeps, drive_time=drive, record="substeps")
    simulator = Simulator(alley(1.3), body=body, settings=settings, fps=30.0)
    frames = [simulator.reset(motion[0])] + [simulator.step(motion[t]) for t in range(1, 61)]
    verdict = Judge(simulator).judge(simulator.world.start([motion[0]])[0], frames[1:])
    assert verdict.clear
    assert verdict.gap >= FLOOR
    assert sum(len(f.contacts.part) > 0 for f in frames) > 10
    assert sum(f.lost_time for f in frames) == 0.0
    # The reduced margins recover: no wall is near at the end, and the joints reach their targets.
    turned = rot.log(
        rot.multiply(
            rot.conjugate(rot.exp(motion[60].rotations[1:])), rot.exp(frames[60].pose.rotations[1:])
        )
    )
    assert np.linalg.norm(turned, axis=-1).max() < 0.02


@DRIVES
@pytest.mark.parametrize("contact", CONTACTS)
def test_a_clearance_that_gave_way_is_regained(body, contact, drive):
    """Walls press from both sides at a little under the clearance; then the pressing ends."""
    frames = 60
    motion = arms_out(body, 2 * frames - 1)
    settings = Settings(contact=contact, substeps=8, drive_time=drive)
    simulator = Simulator(alley(1.3), body=body, settings=settings, fps=30.0)
    simulator.reset(motion[0])
    pressed = [simulator.step(motion[t]).clearance for t in range(1, frames)]
    assert FLOOR <= min(pressed) <= CLEARANCE
    # The reference pose is the body's own: no target pulls on the arms.
    held = simulator.step(motion[frames - 1]).pose
    gaps = [simulator.step(held).clearance for _ in range(30)]
    assert gaps[-1] >= 0.98 * CLEARANCE
    assert gaps[-1] <= 2 * CLEARANCE


def test_a_state_resumes_bit_for_bit_where_steps_are_made_in_pieces():
    case = next(c for c in throw_cases() if c.id == JAMMED[0])
    motion, scene = set_up(case, None)
    settings = Settings(substeps=case.substeps, stiffness=case.stiffness, drive_time=case.drive)

    def simulator():
        return Simulator(scene, body=Body.default(), settings=settings, fps=case.fps)

    a = simulator()
    a.reset(motion[0])
    states, poses = [], []
    for t in range(1, len(motion)):
        poses.append(a.step(motion[t]).pose)
        states.append(a.get_state())
    b = simulator()
    for t in range(6, len(motion) - 1, 3):
        b.set_state(states[t - 1])
        assert b.step(motion[t + 1]).pose.rotations.tobytes() == poses[t].rotations.tobytes()


@DRIVES
def test_who_is_jammed_does_not_hold_up_the_others(body, drive):
    """One is thrown into a plate, with steps so coarse that they are split; another walks
    by without contact and follows its motion exactly."""
    case = next(c for c in throw_cases() if c.id == JAMMED[0])
    motion, scene = set_up(case, None)
    aside = np.array([0.0, 30.0, 0.0])
    walk = t_pose(aside + np.linspace(0.0, 1.0, len(motion))[:, None] * [1.0, 0.0, 0.0], case.fps)
    settings = Settings(substeps=case.substeps, stiffness=0.0, drive_time=drive)
    if drive is not None:
        settings = Settings(substeps=case.substeps, drive_time=drive)
    simulator = Simulator(scene, body=[body, body], settings=settings, fps=case.fps)
    simulator.reset([motion[0], walk[0]])
    touched = 0
    for t in range(1, len(motion)):
        frame = simulator.step([motion[t], walk[t]])
        touched += len(frame.contacts.part) > 0
        np.testing.assert_allclose(frame.poses[1].translation, walk[t].translation, atol=1e-12)
    assert touched > 0


def exhausted(spin=0.0):
    """Somebody limp who starts deep inside a soup of triangles, and a ball that flies elsewhere.

    `spin`: of the ball [rad/s]. The ball's place along its way after every frame [m], the frames,
    and their work in budgets."""
    attack = attacks.set_up(attacks.Case("limp_soup", 453000, fuzz=True))
    attack.scene.add_object("ball", Sphere(0.1), mass=1.0, position=(50.0, 0.0, 50.0))
    settings = Settings(record="substeps", **attack.settings)
    simulator = Simulator(attack.scene, body=attacks.body(), settings=settings, fps=attack.fps)
    simulator.reset(attack.motions[0][0])
    simulator.set_velocity("ball", (BALL, 0.0, 0.0), (spin, 0.0, 0.0))
    x, frames, work = [50.0], [], []
    for t in range(1, 13):
        frames.append(simulator.step(attack.motions[0][t]))
        x.append(frames[-1].objects["ball"][0][0])
        work.append(simulator.world.stepper.frame_work())
    return np.array(x), frames, work


def test_where_a_budget_ends_the_rest_of_the_frame_is_made_in_few_steps():
    """Nobody else loses time by that, and every frame has all its substeps."""
    x, frames, work = exhausted()
    assert max(work) > 1.0
    assert all(len(frame.substeps) == SUBSTEPS for frame in frames)
    joined = [not np.diff(frame.substeps[-4:], axis=0).any() for frame in frames]
    assert any(joined)
    assert not any(np.array(joined)[np.array(work) < 0.9])
    np.testing.assert_allclose(np.diff(x), BALL / 30.0, rtol=0, atol=1e-12)


def test_parts_that_a_budget_leaves_out_are_lost_time_and_said():
    """A ball that turns fast makes each substep in parts, which are not joined."""
    x, frames, work = exhausted(spin=SPIN)
    lost = np.array([frame.lost_time for frame in frames])
    behind = 1.0 / 30.0 - np.diff(x) / BALL
    assert max(work) > 1.0
    assert behind.max() > 1e-3
    assert behind.min() > -1e-12
    assert (behind <= lost + 1e-12).all()
    assert (lost <= 1.0 / 30.0 + 1e-12).all()


def add_heap(scene, corner, **options):
    """18 flush boxes of 1, 10 and 100 kg that fall at 3 m/s, from `corner` on."""
    for i in range(18):
        layer, row, column = i // 9, i % 9 // 3, i % 3
        place = np.add(corner, (0.2 * column, 0.2 * row, 0.201 * layer))
        scene.add_object(
            f"box{i}", Box((0.2, 0.2, 0.2)), mass=10.0 ** (i % 3), position=place,
            velocity=(0.0, 0.0, -3.0), **options,
        )  # fmt: skip


def test_who_lost_time_by_it_does_not_arrive_behind_a_wall(body):
    """A heap that jams and a ball that spins end the budget of somebody who comes to a wall,
    touching nothing."""
    scene = Scene()
    scene.add_static("wall", Box((0.1, 3.0, 3.0)), position=(0.40, 0.0, 0.0))
    scene.add_static("floor", Plane(), position=(0.0, 0.0, -3.0))
    for side in (-0.35, 0.35):
        scene.add_static(f"side{side}", Box((0.1, 2.0, 1.0)), position=(10.0 + side, 0.0, -2.5))
    add_heap(scene, (9.8, -0.2, -2.895))
    scene.add_object("ball", Sphere(0.03), mass=0.05, position=(5.0, 0.0, 0.0),
                     angular_velocity=(0.0, 0.0, 300.0))  # fmt: skip
    motion = t_pose(0.1 * np.arange(5)[:, None] * [1.0, 0.0, 0.0])
    simulator = Simulator(scene, body=body, settings=as_it_is(), fps=30.0)
    simulator.reset(motion[0])
    lost = 0.0
    for t in range(1, len(motion)):
        frame = simulator.step(motion[t])
        lost += frame.lost_time
        assert frame.clearance > LEAST
        assert not len(frame.breaches)
    assert lost > 0.05, "the budget ends"


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_what_no_time_is_left_for_gains_no_speed(restitution):
    """Flush boxes of 1, 10 and 100 kg that fall on the floor end their budget frame after frame."""
    scene = Scene()
    scene.add_static("floor", Plane(), restitution=restitution)
    add_heap(scene, (0.0, 0.0, 0.105), restitution=restitution)
    simulator = Simulator(scene, body=[], settings=Settings(), fps=30.0)
    simulator.reset([])
    lost, speed = [], []
    for _ in range(40):
        lost.append(simulator.step([]).lost_time)
        speed.append(np.abs(simulator.world.stepper.qvel().reshape(-1, 6)[:, :3]).max())
    assert sum(lost) > 0.2, "they stick"
    assert max(speed) < 3.5
