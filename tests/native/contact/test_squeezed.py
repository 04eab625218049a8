"""Squeezed and wedged bodies: which conflicts reduce margins, which motion continues, the report.

No overlap occurs if a clear pose exists, at any pressure. If none exists the result says so.
In both cases no body flies off, no frame is slow, and unblocked limbs follow their motion.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import pytest

pytest.importorskip("coal")
pytest.importorskip("trimesh")

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX as J
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulator import Simulator
from support.as_it_is import as_it_is
from support.people import FACING_X
from support.starts.meshes import box_mesh, finely, union_mesh
from support.starts.objects_judge import ObjectJudge
from support.starts.solids import EXACT, Hulls, box, ground

pytestmark = pytest.mark.slow

#: No skin vertex exceeds the speed of the motion or of the hitting object by more [m/s]: a
#: hand whips when half a tonne hits its arm. An instability has tens.
FASTER = 6.0
#: Objects exceed their speed of fall or push by no more than this [m/s].
THROWN = 1.0
#: Unblocked joints are this near to their targets [rad].
FREE = np.deg2rad(1.0)
#: The same where a hard-pressed hand slips now and then, and the trunk jerks.
SLIPS = np.deg2rad(2.0)
#: The same where friction holds a body from both sides and contacts snap over: it nods by 17.
WEDGED = np.deg2rad(12.0)
#: Tolerance of the solver, at either of two sides [m].
SOLVED = as_it_is().tolerance
#: Displacement of a pressed body's root in a second [m]; its largest change between two frames [m].
CREEP, TREMBLE = 5e-3, 1e-4
#: The slowest run that still progresses [frames per second of processor time].
RATE = 5.0
#: A frame may take longer if other frames compensate [s].
GRACE = 2.0
#: Poses processed together: bounds the memory.
CHUNK = 240


@pytest.fixture(scope="module")
def body():
    return Body.default()


@pytest.fixture(scope="module")
def hulls(body):
    return Hulls(body, "skin")


@dataclass
class Run:
    """Results of a run in metres, seconds and radians."""

    frames: list
    gap: float  # minimum distance to a solid over all poses, negative: depth
    start: float  # the same at the first pose
    fast: float  # largest speed of a vertex, less the motion's own
    free: float  # largest deviation of the joints declared free
    things: dict
    rate: float

    @property
    def lost(self):
        return sum(f.lost_time for f in self.frames)


def upright(body, frames, fps=30.0, z=0.003, arms=1.25):
    """A person standing on z, the pelvis over the origin, facing +x, arms down."""
    turns = np.zeros((frames, 55, 3))
    turns[:, 0] = FACING_X
    turns[:, J["left_shoulder"]] = (0.0, 0.0, -arms)
    turns[:, J["right_shoulder"]] = (0.0, 0.0, arms)
    motion = Motion(np.zeros((frames, 3)), turns, fps)
    low = body.vertices(motion, frames=0)[:, 2].min()
    shift = np.array([*-body.joints(motion[0])[0, :2], z - low])
    return motion.with_frames(np.tile(shift, (frames, 1)), turns)


def waving(motion, joint="neck", size=0.3):
    """The same motion with one nodding joint."""
    turns = motion.rotations.copy()
    t = np.arange(len(motion)) / motion.fps
    swing = size * np.sin(2 * np.pi * t)[:, None] * [1.0, 0.0, 0.0]
    turns[:, J[joint]] = rot.log(rot.multiply(rot.exp(turns[:, J[joint]]), rot.exp(swing)))
    return motion.with_frames(motion.translation, turns)


def put(scene, solids, kind):
    """Boxes as statics: each a primitive or a mesh, or all of them in one mesh."""
    planes = [s for s in solids if s.half is None]
    boxes = [s for s in solids if s.half is not None]
    if kind == "merged":
        spans = [(s.centre - s.half, s.centre + s.half) for s in boxes]
        spans += [((-4, -4, s.centre[2] - 0.2), (4, 4, s.centre[2])) for s in planes]
        scene.add_static("all", finely(union_mesh(spans), 2))
        return
    for s in boxes:
        if kind == "boxes":
            scene.add_static(s.name, Box(tuple(2 * s.half)), position=s.centre)
        else:
            mesh = finely(box_mesh(-s.half, s.half), 2)
            scene.add_static(s.name, mesh, position=s.centre)
    for s in planes:
        scene.add_static(s.name, Box((8.0, 8.0, 0.4)), position=s.centre - (0, 0, 0.2))


def follow(body, hulls, motion, scene, solids, free=("neck",), **settings):
    settings = as_it_is(record="substeps", **settings)
    simulator = Simulator(scene, body=body, settings=settings, fps=motion.fps)
    begin = time.thread_time()  # other processes do not count
    simulator.reset(motion[0])
    frames = []
    for t in range(1, len(motion)):
        frames.append(simulator.step(motion[t]))
        took = time.thread_time() - begin
        assert took < GRACE + t / RATE, f"{t} frames in {took:.1f} s"
    count = settings.substeps_for(simulator.dt)
    start = simulator.world.start([motion[0]])[0]
    poses = np.concatenate([start[None], *(f.substeps for f in frames)])
    assert np.isfinite(poses).all()
    asked = np.linalg.norm(np.diff(body.vertices(motion), axis=0), axis=2).max() * motion.fps
    gaps, fast = [], 0.0
    for first in range(0, len(poses) - 1, CHUNK):
        some = poses[first : first + CHUNK + 1]
        posed = hulls.at(Motion(*simulator.world.people[0].pose(some, motion.axes), 1.0))
        gaps.append(_gaps(posed, solids))
        for a, b in zip(posed.skin[:-1], posed.skin[1:], strict=True):
            way = np.sqrt(np.einsum("ij,ij->i", b - a, b - a).max())
            fast = max(fast, way * count / simulator.dt - asked)
    mine = [J[j] for j in free]
    at = rot.exp(np.array([f.pose.rotations[mine] for f in frames]))
    wanted = rot.exp(motion.rotations[1:, mine])
    off = np.linalg.norm(rot.log(rot.multiply(rot.conjugate(wanted), at)), axis=2)
    things = ObjectJudge(simulator, solids).judge(motion, frames) if scene.objects else {}
    return Run(
        frames=frames,
        gap=float(np.concatenate(gaps).min()),
        start=float(gaps[0][0]),
        fast=float(fast),
        free=float(off.max()),
        things=things,
        rate=len(frames) / took,
    )


def _gaps(posed, solids):
    """Minimum distance of every pose to the solids: a lower bound if clear, else exact."""
    best = np.full(len(posed.joints), np.inf)
    for solid in solids:
        for h, points in enumerate(posed.points):
            apart = solid.separation(points)
            if solid.half is not None:
                for k in np.flatnonzero(apart < 0.0):
                    apart[k] = posed.distance(h, int(k), solid)
            best = np.minimum(best, apart)
    return best


def goes_on(run, hit=0.0, free=FREE):
    """Conditions that hold at any pressure; `hit`: speed of the hitting object [m/s]."""
    assert run.fast <= FASTER + hit
    assert run.free <= free
    assert run.rate >= RATE
    if run.things:
        assert run.things["thrown"] <= THROWN


def alley(width):
    return [
        ground(),
        box("left", (-1.0, 0.5 * width, 0.0), (1.0, 0.5 * width + 0.2, 2.2)),
        box("right", (-1.0, -0.5 * width - 0.2, 0.0), (1.0, -0.5 * width, 2.2)),
    ]


@pytest.mark.parametrize(("kind", "narrow"), [("boxes", 0.06), ("merged", 0.06), ("boxes", 0.16)])
def test_a_body_between_walls_too_near_to_each_other(body, hulls, kind, narrow):
    """The shoulders are 3 to 8 cm in each wall: at most they turn and are out."""
    motion = waving(upright(body, 46, arms=0.0))
    turns = motion.rotations.copy()
    # Both arms ahead, out of the walls.
    turns[:, J["left_shoulder"]] = (0.0, -1.6, 0.0)
    turns[:, J["right_shoulder"]] = (0.0, 1.6, 0.0)
    motion = motion.with_frames(motion.translation, turns)
    first = body.vertices(motion, frames=0)
    wide = np.ptp(first[:, 1])
    scene, solids = Scene(), alley(wide - narrow)
    put(scene, solids, kind)
    run = follow(body, hulls, motion, scene, solids)
    goes_on(run, free=WEDGED)
    assert run.gap < -0.02  # it is as narrow as intended
    assert run.gap >= run.start - EXACT  # and no depth increases
    assert min(f.clearance for f in run.frames) < -0.02  # the result reports it


@pytest.mark.parametrize("mass", [20.0, 500.0])
def test_a_heavy_box_slides_into_somebody_at_a_wall(body, hulls, mass):
    motion, hit = waving(upright(body, 46)), 1.5
    first = body.vertices(motion, frames=0)
    back, front = first[:, 0].min() - 0.004, first[:, 0].max()
    solids = [ground(), box("wall", (back - 0.2, -2.0, 0.0), (back, 2.0, 2.2))]
    scene = Scene()
    put(scene, solids, "boxes")
    scene.friction("person", "wall", 0.3)
    scene.add_object("box", Box((0.5, 0.8, 0.9)), mass=mass, friction=0.0,
                     position=(front + 0.3, 0.0, 0.451), velocity=(-hit, 0.0, 0.0))  # fmt: skip
    run = follow(body, hulls, motion, scene, solids)
    goes_on(run, hit)
    assert run.gap >= -EXACT
    assert run.things["fresh"] <= EXACT
    assert any(len(f.contacts.part) for f in run.frames)


@pytest.mark.parametrize("mass", [2.0, 80.0])
def test_a_heavy_box_falls_on_a_foot(body, hulls, mass):
    motion = waving(upright(body, 46))
    toes = body.joints(motion[0])[J["left_foot"]]
    scene, solids = Scene(), [ground()]
    put(scene, solids, "boxes")
    scene.add_object("box", Box((0.2, 0.2, 0.2)), mass=mass,
                     position=(toes[0] + 0.12, toes[1], 0.45))  # fmt: skip
    run = follow(body, hulls, motion, scene, solids)
    goes_on(run, hit=2.5)  # a fall of half a metre
    assert run.gap >= -EXACT
    assert run.things["fresh"] <= EXACT
    assert "box" in _touched(run, scene)


def _touched(run, scene):
    names = [*scene.statics, *scene.objects]
    others = {int(i) for f in run.frames for i in f.contacts.other if i < len(names)}
    return {names[i] for i in others}


def test_a_drawer_closes_on_a_hand(body, hulls):
    """A hand between the cabinet's frame and a heavy drawer that slides shut."""
    motion, hit = waving(upright(body, 46)), 1.0
    turns = motion.rotations.copy()
    turns[:, J["left_shoulder"]] = (0.0, -1.5, 0.0)
    motion = motion.with_frames(motion.translation, turns)
    mine = np.isin(np.asarray(body.weights).argmax(axis=1), [J["left_wrist"], *range(25, 40)])
    hand = body.vertices(motion, frames=0)[mine]
    (x0, low, z0), (x1, high, z1) = hand.min(axis=0), hand.max(axis=0)
    face = high + 0.02
    solids = [
        ground(),
        box("frame", (x0, face, z0 - 0.2), (x1 + 0.2, face + 0.3, z1 + 0.2)),
    ]
    scene = Scene(gravity=0.0)
    put(scene, solids, "boxes")
    # It would close flush with the frame; the hand is in between.
    size = 0.3
    scene.add_object(
        "drawer",
        Box((size, size, size)),
        mass=60.0,
        friction=0.1,
        position=(x0 + 0.05 + 0.5 * size, low - 0.1 - 0.5 * size, 0.5 * (z0 + z1)),
        velocity=(0.0, hit, 0.0),
    )
    run = follow(body, hulls, motion, scene, solids)
    goes_on(run, hit)
    assert run.gap >= -EXACT
    assert run.things["fresh"] <= EXACT
    assert {"frame", "drawer"} <= _touched(run, scene)


@pytest.mark.parametrize("mass", [10.0, 300.0])
def test_between_two_boxes_that_are_pushed_together(body, hulls, mass):
    motion, hit = waving(upright(body, 46)), 1.2
    scene, solids = Scene(), [ground()]
    put(scene, solids, "boxes")
    for name, side in (("ahead", 1.0), ("behind", -1.0)):
        scene.add_object(name, Box((0.5, 0.8, 0.6)), mass=mass, friction=0.0,
                         position=(0.7 * side, 0.0, 0.301),
                         velocity=(-hit * side, 0.0, 0.0))  # fmt: skip
    run = follow(body, hulls, motion, scene, solids)
    # Boxes of 300 kg that start up to 2 mm elsewhere: from 4.7 to 7.8 m/s.
    goes_on(run, hit + 0.8)
    assert run.gap >= -EXACT
    assert run.things["fresh"] <= EXACT
    assert {"ahead", "behind"} <= _touched(run, scene)


@pytest.mark.parametrize("kind", ["merged"])
def test_a_hand_in_a_corner_for_ten_seconds(body, hulls, kind):
    """The motion continues into the corner for eight seconds, hand first, and stays there."""
    motion = waving(upright(body, 301))
    turns = motion.rotations.copy()
    turns[:, J["left_shoulder"]] = (0.0, -1.5, 0.0)
    t = np.arange(len(motion)) / motion.fps
    way = 0.15 * (1.0 - np.cos(np.pi * np.minimum(t / 8.0, 1.0)))
    path = motion.translation + np.outer(way, [1.0, 0.4, 0.0])
    motion = motion.with_frames(path, turns)
    tips = body.joints(motion[0])[J["left_middle3"]]
    x, y = tips[0] + 0.1, tips[1] + 0.1
    solids = [
        ground(),
        box("ahead", (x, -2.0, 0.0), (x + 0.2, y + 0.2, 2.2)),
        box("aside", (-0.5, y, 0.0), (x, y + 0.2, 2.2)),
    ]
    scene = Scene()
    put(scene, solids, kind)
    run = follow(body, hulls, motion, scene, solids, free=("neck", "right_elbow", "left_knee"))
    goes_on(run, free=SLIPS)
    assert run.gap >= -EXACT
    assert run.lost <= 0.01 * len(motion) / motion.fps
    # In the last second it creeps at most, without trembling.
    last = np.array([f.pose.translation for f in run.frames[-30:]])
    assert np.ptp(last, axis=0).max() <= CREEP
    assert np.abs(np.diff(last, 2, axis=0)).max() <= TREMBLE


@pytest.mark.parametrize("kind", ["boxes", "merged"])
def test_a_thing_between_statics_that_leave_no_room(body, hulls, kind):
    """A box 1 cm inside three objects that overlap each other: it may stay, or leave slowly."""
    motion = waving(upright(body, 46))
    solids = [
        ground(),
        box("left", (0.9, 0.09, 0.0), (1.3, 0.5, 1.0)),
        box("right", (0.9, -0.5, 0.0), (1.3, -0.09, 1.0)),
        box("behind", (1.29, -0.5, 0.0), (1.6, 0.5, 1.0)),
    ]
    scene = Scene()
    put(scene, solids, kind)
    scene.add_object("box", Box((0.2, 0.2, 0.2)), mass=5.0, position=(1.2, 0.0, 0.15))
    run = follow(body, hulls, motion, scene, solids)
    goes_on(run)
    assert run.things["depth"] > 0.009
    assert run.things["deeper"] <= 2 * SOLVED
