"""People who start inside an obstacle come out: steadily, soon, and without disturbing the rest.

A few cases of each kind run always; `HALFPHYSICS_STARTS=n` runs n of each, from
`HALFPHYSICS_STARTS_SEED` on. The judge is tested on synthetic runs.
"""

from __future__ import annotations

import os
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("coal")
pytest.importorskip("trimesh")

from campaigns.starts import FREE, KINDS, LATEST, SHARE, SOON, complaints, line, run, summary
from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Mesh
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX as J
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulator import Simulator
from support.as_it_is import as_it_is
from support.starts import cases as starts
from support.starts import objects as starts_things
from support.starts.cases import Case
from support.starts.groups import groups_at
from support.starts.judge import StartJudge
from support.starts.meshes import union_mesh
from support.starts.solids import EXACT, Hulls, box, ground

MANY = int(os.environ.get("HALFPHYSICS_STARTS", "1"))
#: Seeds not used for tuning.
SEED = int(os.environ.get("HALFPHYSICS_STARTS_SEED", "1000"))


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_out_of_it_steadily_and_soon(kind):
    rows = [run(Case(kind, SEED + i), "skin", None) for i in range(MANY)]
    report = "\n".join(f"{line(r)}\n  {text}" for r in rows for text in complaints(r))
    if MANY > 1:
        print(f"\n{summary(rows)}\n{report}")
    assert not report, report
    soon = np.mean([r["out"] is not None and r["out"] <= SOON for r in rows])
    assert soon >= SHARE


# -- the cases -------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", starts.KINDS)
def test_cases_start_as_deep_as_they_say(kind):
    start = starts.build(Case(kind, 7), "parts")
    posed = starts.hulls("parts").at(start.motion[:2])
    groups = groups_at(posed, 0, start.solids)
    assert max(g.depth for g in groups) == pytest.approx(start.depth, abs=1e-6)
    assert 0.005 <= start.depth <= 0.11


@pytest.mark.slow
@pytest.mark.parametrize("kind", starts.KINDS)
def test_cases_stand_in_the_scene_where_the_judge_looks(kind):
    """The centre of every solid is inside a static; all corners of a sheet are in its face."""
    for seed in range(2):
        start = starts.build(Case(kind, seed), "parts")
        for solid in start.solids:
            middle = solid.centre if solid.half is not None else solid.centre - (0, 0, 0.05)
            found = False
            for s in start.scene.statics.values():
                turn = rot.to_matrix(s.quaternion)
                if isinstance(s.shape, Mesh) and not s.shape.closed:
                    side = 0 if solid.near is None else solid.near
                    corners = s.shape.vertices @ turn.T + s.position
                    apart = corners @ solid.normals[side] - solid.offsets[side]
                    found |= np.abs(apart).max() < 1e-9
                else:
                    found |= s.shape.depth((middle - s.position)[None] @ turn)[0] > 0.004
            assert found, (seed, solid.name)


def test_the_same_seed_is_the_same_case():
    a, b = (starts.build(Case("shelf", 3), "parts") for _ in range(2))
    assert a.motion.translation.tobytes() == b.motion.translation.tobytes()
    assert a.motion.rotations.tobytes() == b.motion.rotations.tobytes()
    assert a.scene.statics.keys() == b.scene.statics.keys()


def test_boxes_that_touch_are_one_closed_surface():
    boxes = [((0, 0, 0), (1, 1, 1)), ((1, 0, 0), (2, 1, 0.5)), ((0.2, 0.2, 0.8), (0.5, 3, 2))]
    mesh = union_mesh(boxes)
    assert mesh.is_watertight
    assert len(mesh.split()) == 1
    shared = 0.3 * 0.8 * 0.2
    assert mesh.volume == pytest.approx(1.0 + 0.5 + 0.3 * 2.8 * 1.2 - shared, abs=1e-12)


# -- the judge -------------------------------------------------------------------------------


@cache
def _parts():
    return Hulls(starts.body(), "parts")


def _standing(frames):
    turns = np.zeros((frames, 55, 3))
    turns[:, 0] = starts_things.POSES["stand"](np.random.default_rng(0))[0]
    motion = Motion(np.zeros((frames, 3)), turns, 30.0)
    low = starts.body().vertices(motion, frames=0)[:, 2].min()
    return motion.with_frames(np.tile([0.0, 0.0, -low], (frames, 1)), turns)


def _made_up(heights, solids, turn=None):
    """The verdict on feet in the floor whose lowest point moves through `heights` (S + 1,) [m]."""
    frames = (len(heights) - 1) // 8
    motion = _standing(frames + 1)
    settings = as_it_is(record="substeps")
    simulator = Simulator(Scene(), body=starts.body(), settings=settings, fps=30.0)
    asked = motion.with_frames(
        motion.translation + np.array([0.0, 0.0, heights[0]]), motion.rotations
    )
    poses = []
    for k in range(1, len(heights)):
        turns = motion.rotations[0].copy()
        if turn is not None:
            turns[J["neck"]] = (turn * min(1.0, k / 8), 0.0, 0.0)
        at = motion.translation[:2] + np.array([0.0, 0.0, heights[k]])
        moved = motion[:2].with_frames(at, np.stack([turns] * 2))
        poses.append(simulator.world.start([moved[0]])[0])
    poses = np.array(poses).reshape(frames, 8, -1)
    results = [SimpleNamespace(substeps=poses[f]) for f in range(frames)]
    return StartJudge(simulator, solids).judge(asked, results)


def _rise(speed=0.5, depth=0.05, steps=80):
    return np.minimum(-depth + speed / 240.0 * np.arange(steps + 1), 0.001)


def test_the_judge_is_content_with_a_steady_rise():
    v = _made_up(_rise(), [ground()])
    assert v.depth == pytest.approx(0.05, abs=1e-9)
    assert v.out == pytest.approx(0.05 / 0.5, abs=1 / 240)
    assert v.skin_out <= v.out + 1e-9
    assert max(v.deeper_pair, v.deeper_worst, v.deeper_way) <= 1e-9
    assert v.again == 0.0
    assert v.fast == pytest.approx(0.5, abs=1e-6)
    assert v.free <= 1e-9
    assert v.root == pytest.approx(0.051, abs=1e-9)
    assert v.end_gap == pytest.approx(0.001, abs=1e-9)


def test_the_judge_sees_two_micrometres_deeper():
    heights = _rise()
    heights[11] = heights[10] - 2e-6
    v = _made_up(heights, [ground()])
    assert v.deeper_way == pytest.approx(2e-6, abs=1e-9)
    assert v.deeper_pair > EXACT


def test_the_judge_sees_who_falls_back():
    heights = _rise()
    heights[60:] = -0.002
    assert _made_up(heights, [ground()]).again == pytest.approx(0.002, abs=1e-9)


def test_the_judge_sees_a_free_joint_move():
    assert _made_up(_rise(), [ground()], turn=2 * FREE).free == pytest.approx(2 * FREE, rel=1e-6)


def test_the_judge_knows_who_never_leaves():
    v = _made_up(np.full(81, -0.03), [ground()])
    assert v.out > LATEST
    assert v.skin_out > LATEST


def test_depths_by_coal_are_those_of_the_minkowski_difference():
    """EPA against the plain definition: the least distance of the origin to a face of B - A."""
    from scipy.spatial import ConvexHull

    posed = _parts().at(_standing(2))
    rng = np.random.default_rng(3)
    looked = 0
    for h in rng.permutation(len(_parts()))[:12]:
        points = posed.points[h][0]
        middle = points.mean(axis=0)
        half = rng.uniform(0.02, 0.2, size=3)
        reach = points[rng.integers(len(points))]
        at = reach + 0.7 * half * rng.choice([-1.0, 1.0], size=3)
        solid = box("box", at - half, at + half)
        depth = posed.depth(int(h), 0, solid)
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
        difference = ((points - at)[:, None] - corners[None]).reshape(-1, 3)
        plain = -ConvexHull(difference).equations[:, 3].max()
        assert depth == pytest.approx(max(0.0, plain), abs=1e-7), middle
        looked += depth > EXACT
        # Moved out by the separating vector it is clear; slightly less is not.
        for side in range(6):
            n = solid.normals[side]
            way = posed.way_out(int(h), 0, solid, n)
            if way > 0.0:
                assert posed.depth(int(h), 0, solid, (way + 1e-6) * n) == 0.0
                assert posed.depth(int(h), 0, solid, (way - 1e-5) * n) > 0.0
    assert looked >= 6


def test_through_a_thin_wall_it_is_the_near_side_that_counts():
    """A wall through both hands of a T-pose: parts beyond it belong to the group."""
    posed = _parts().at(_standing(2))
    wrist = posed.joints[0, J["left_wrist"]]
    x = np.sign(wrist - posed.joints[0, 0])
    axis = int(np.abs(wrist - posed.joints[0, 0])[:2].argmax())
    low, high = wrist - 2.0, wrist + 2.0
    low[axis], high[axis] = wrist[axis] - 0.005, wrist[axis] + 0.005
    wall = box("wall", low, high, near=2 * axis + (1 if x[axis] > 0 else 0))
    (group,) = groups_at(posed, 0, [wall])
    names = {int(_parts().joint[h]) for h in group.inside}
    assert J["left_middle3"] in names
    assert J["right_wrist"] not in names
    side = np.concatenate([posed.points[h][0][:, axis] for h in group.inside])
    beyond = (x[axis] * (side - wrist[axis])).max() + 0.005
    assert group.depth == pytest.approx(beyond, abs=1e-9)
