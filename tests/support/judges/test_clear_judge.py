"""The judge of `campaigns/test_clear.py` detects crossings, and nothing else."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Cylinder, Plane
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator
from support.barriers import BARRIERS, barrier, sheet
from support.judges.clear_judge import CHUNK, Judge, told_inside
from support.judges.person_hulls import CONTACTS, pieces_of
from support.people import FACING_X, t_pose
from support.throws import OBSTACLES, throw

trimesh = pytest.importorskip("trimesh")


@pytest.fixture(scope="module")
def body():
    return Body.default()


@pytest.fixture(params=CONTACTS)
def ghost(request):
    """The judge's verdict on an unconstrained motion."""
    return partial(_ghost, request.param)


def _ghost(contact, body, scene, motion):
    settings = Settings(contact=contact)
    simulator = Simulator(scene, body=body, settings=settings, fps=motion.fps)
    poses = np.array([simulator.world.start([motion[t]])[0] for t in range(len(motion))])
    return Judge(simulator).judge_poses(poses)


@pytest.mark.slow
@pytest.mark.parametrize("kind", OBSTACLES)
@pytest.mark.parametrize(("pose", "speed"), [("tpose", 20.0), ("curled", 3.0)])
def test_ghosts_are_seen(body, ghost, kind, pose, speed):
    rng = np.random.default_rng(OBSTACLES.index(kind))
    motion, scene = throw(pose, kind, speed, 30.0, body, rng)
    verdict = ghost(body, scene, motion)
    assert verdict.start > 0.0
    assert not verdict.clear


@pytest.mark.slow
@pytest.mark.parametrize("what", BARRIERS)
def test_a_jump_over_it_is_a_crossing(body, ghost, what):
    """No pose is near; every part with the static in its way has crossed."""
    shape = barrier(what)
    motion = t_pose([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], fps=20.0)
    scene = Scene()  # in the middle of the body: its root turns about the pelvis
    scene.add_static("it", shape, position=(0.0, body.joints(motion)[0, 0, 1], 0.0))
    verdict = ghost(body, scene, motion)
    assert not verdict.inside
    assert not verdict.clear
    names = {name for name, _, pose in verdict.crossed if pose == 1}
    crossed = {name.split("/")[1] for name in names}
    trunk = {"pelvis", "spine1", "spine2", "spine3", "neck", "head"}
    if "pole" in what:
        assert trunk <= crossed
        assert not any("wrist" in part or "foot" in part for part in crossed)
    else:
        (pieces,) = pieces_of(Simulator(scene, body=body, fps=20.0), ghost.args[0])
        assert names == set(pieces.names)


def test_being_inside_is_seen_at_once(body, ghost):
    scene = Scene()
    scene.add_static("it", Plane())
    verdict = ghost(body, scene, t_pose(np.outer([0.3, 0.29, 0.28], [0.0, 0.0, 1.0])))
    assert verdict.start < 0.0
    assert verdict.inside == {0, 1, 2}
    lowest = body.vertices(t_pose(np.zeros((2, 3))), frames=[0])[0, :, 2].min()
    assert verdict.gap == pytest.approx(0.28 + lowest, abs=1e-6)


@pytest.mark.parametrize("kind", ["plane", "box"])
def test_what_is_told_is_left_out_as_long_as_it_is_told(body, kind):
    """A person sinks into the ground: its feet, of which that is known until the second pose."""
    scene = Scene()
    lowest = body.vertices(t_pose(np.zeros((2, 3))), frames=[0])[0, :, 2].min()
    depths = np.array([0.01, 0.02, 0.03, 0.04])
    motion = t_pose(np.outer(-lowest - depths, [0.0, 0.0, 1.0]))
    box = Box((3.0, 3.0, 1.0))
    shape, position = (Plane(), (0, 0, 0)) if kind == "plane" else (box, (0, 0, -0.5))
    scene.add_static("it", shape, position=position)
    simulator = Simulator(scene, body=body, fps=motion.fps)
    poses = np.array([simulator.world.start([motion[t]])[0] for t in range(len(motion))])
    told = {(f"person/{part}", "it"): 1 for part in JOINT_NAMES}
    verdict = Judge(simulator).judge_poses(poses, told)
    assert verdict.start == pytest.approx(-0.01, abs=1e-6)
    assert verdict.inside == {2, 3}
    assert verdict.gap == pytest.approx(-0.04, abs=1e-6)
    forever = dict.fromkeys(told, len(poses))
    assert Judge(simulator).judge_poses(poses, forever).clear
    elsewhere = {(part, "another"): len(poses) for part, _ in told}
    assert Judge(simulator).judge_poses(poses, elsewhere).inside == {0, 1, 2, 3}


def _ground(kind):
    """A scene whose ground is the top of a box, or a plane."""
    scene, is_box = Scene(), kind == "box"
    shape = Box((3.0, 3.0, 1.0)) if is_box else Plane()
    scene.add_static("it", shape, position=(0.0, 0.0, -0.5 if is_box else 0.0))
    return scene


@pytest.mark.parametrize(
    ("kind", "depth", "clear"),
    [("box", 5e-5, True), ("box", 2e-4, False), ("plane", 5e-6, True), ("plane", 2e-5, False)],
)
def test_a_start_that_touches_need_not_be_told(body, kind, depth, clear):
    scene = _ground(kind)
    lowest = body.vertices(t_pose(np.zeros((2, 3))), frames=[0])[0, :, 2].min()
    motion = t_pose(np.outer([-lowest - depth, -lowest + 0.001], [0.0, 0.0, 1.0]))
    simulator = Simulator(scene, body=body, fps=motion.fps)
    poses = np.array([simulator.world.start([motion[t]])[0] for t in range(len(motion))])
    verdict = Judge(simulator).judge_poses(poses, {})
    assert verdict.start == pytest.approx(-depth, abs=1e-6)
    assert verdict.clear == clear
    assert not Judge(simulator).judge_poses(poses).clear


@pytest.mark.parametrize(("kind", "depth"), [("box", 5e-5), ("plane", 5e-6)])
def test_what_touched_at_the_start_may_not_touch_again(body, kind, depth):
    """A first step that is lost as a whole is no breach; a foot that comes back is one."""
    scene = _ground(kind)
    lowest = body.vertices(t_pose(np.zeros((2, 3))), frames=[0])[0, :, 2].min()
    heights = np.array([-depth, -depth, 0.001, -depth])
    motion = t_pose(np.outer(heights - lowest, [0.0, 0.0, 1.0]))
    simulator = Simulator(scene, body=body, fps=motion.fps)
    poses = np.array([simulator.world.start([motion[t]])[0] for t in range(len(motion))])
    assert Judge(simulator).judge_poses(poses, {}).inside == {3}


def _poses(simulator, heights):
    """Coordinates of a person whose lowest point is at these heights."""
    body = simulator.bodies[0]
    lowest = body.vertices(t_pose(np.zeros((2, 3))), frames=[0])[0, :, 2].min()
    motion = t_pose(np.outer(np.array(heights) - lowest, [0.0, 0.0, 1.0]))
    return np.array([simulator.world.start([motion[t]])[0] for t in range(len(motion))])


@pytest.mark.parametrize("start", [-1.1e-6, 0.0, 1e-9])
def test_what_touches_a_plane_at_the_start_may_not_sink(body, start):
    """What is let pass at the start is so deep, not whatever a start may be."""
    simulator = Simulator(_ground("plane"), body=body, fps=30.0)
    verdict = Judge(simulator).judge_poses(_poses(simulator, [start, *[-9.9e-6] * 3]), {})
    assert verdict.inside == {1, 2, 3}


@pytest.mark.parametrize(("kind", "depth"), [("box", 5e-5), ("plane", 5e-6)])
def test_who_stays_where_it_touches_is_left_out_for_as_long(body, kind, depth):
    """For more poses than are judged together; and then it comes back."""
    simulator = Simulator(_ground(kind), body=body, fps=30.0)
    heights = [*[-depth] * (CHUNK + 6), 0.001, -depth]
    verdict = Judge(simulator).judge_poses(_poses(simulator, heights), {})
    assert verdict.inside == {CHUNK + 7}


def test_a_run_tells_what_is_inside_and_until_when(body):
    """The hands in a wall at the start: of them alone it is told, until they are out."""
    scene = Scene()
    motion = t_pose(np.zeros((30, 3)), fps=30.0)
    reach = body.vertices(motion, frames=[0])[0, :, 1].max()
    scene.add_static("wall", Box((1.0, 0.2, 1.0)), position=(0.0, reach + 0.07, 0.0))
    simulator = Simulator(
        scene, body=body, settings=Settings(record="substeps", substeps=4), fps=30.0
    )
    frames = [simulator.reset(motion[0])]
    frames += [simulator.step(motion[t]) for t in range(1, len(motion))]
    told = told_inside(simulator.world, frames)
    assert told
    assert all(part.startswith("person/left_") and other == "wall" for part, other in told)
    last = max(k for k, f in enumerate(frames) if len(f.inside))
    ends = np.cumsum([len(f.substeps) for f in frames])
    assert 0 < last < len(frames) - 1
    assert max(told.values()) == ends[last + 1]
    start = simulator.world.start([motion[0]])[0]
    verdict = Judge(simulator).judge(start, frames[1:], told)
    assert verdict.start < -0.02
    assert verdict.clear


@pytest.mark.parametrize("steps", [2, 5, 40])
@pytest.mark.parametrize("turns", [0.0, 0.4])
def test_passing_by_is_no_crossing(body, ghost, turns, steps):
    """A person between two sheets and two poles, 5 mm from its finger tips and its head."""
    t = np.linspace(-1.0, 1.0, steps + 1)
    rotations = np.zeros((len(t), 55, 3))
    rotations[:, 0] = rot.log(
        rot.multiply(rot.exp(np.outer(turns * t, [1.0, 0.0, 0.0])), rot.exp(FACING_X))
    )
    motion = Motion(np.outer(t, [1.0, 0.0, 0.0]), rotations, 10.0)
    everywhere = np.concatenate([body.vertices(motion, frames=[k])[0] for k in range(len(t))])
    low, high = everywhere.min(axis=0) - 0.005, everywhere.max(axis=0) + 0.005
    # The finger tips move in circles between the poses.
    low, high = low - turns * 0.2, high + turns * 0.2
    scene = Scene()
    flat = rot.exp([0.0, np.pi / 2, 0.0])
    scene.add_static("over", sheet(), position=(0.0, 0.0, high[2]), quaternion=flat)
    scene.add_static("under", Plane(), position=(0.0, 0.0, low[2]))
    scene.add_static("left", Cylinder(0.01, 4.0), position=(0.0, high[1] + 0.01, 0.0))
    pole = trimesh.creation.cylinder(0.01, height=4.0)
    scene.add_static("right", pole, position=(0.0, low[1] - 0.01, 0.0))
    assert ghost(body, scene, motion).clear


def test_around_an_edge_is_no_crossing(body, ghost):
    """Up in front of a sheet's edge, over it and down behind it: three steps, one each way."""
    scene = Scene()
    scene.add_static("it", sheet(), position=(0.0, 0.0, -2.5))  # its edge at z = -0.5
    path = [[-0.6, 0.0, -0.8], [-0.6, 0.0, 1.5], [0.6, 0.0, 1.5], [0.6, 0.0, -0.8]]
    assert ghost(body, scene, t_pose(path, fps=10.0)).clear
    assert not ghost(body, scene, t_pose(path[::3], fps=10.0)).clear
