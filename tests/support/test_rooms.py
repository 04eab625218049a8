"""Rooms of other tests: the same each time, clear at the start, cut as finely as requested."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.simulation.simulator import Simulator
from support.judges.clear_judge import Judge
from support.people import along_x
from support.rooms import furnished, merged

#: Positions after merging and cutting [m].
ROUNDING = 1e-9


@pytest.fixture(scope="module")
def body():
    return Body.default()


@pytest.fixture(scope="module")
def walk(body):
    return along_x(1.0, 60, start=0.0).grounded(body, z=0.002)


@pytest.mark.parametrize("seed", range(4))
def test_the_first_pose_is_clear_and_the_way_is_not(shared_data, body, walk, seed):
    room = furnished(walk, body, shared_data / "meshes", seed)
    again = furnished(walk, body, shared_data / "meshes", seed)
    for a, b in zip(room.statics.values(), again.statics.values(), strict=True):
        np.testing.assert_array_equal(a.position, b.position)
        np.testing.assert_array_equal(a.shape.vertices, b.shape.vertices)
    judge = Judge(Simulator(room, body=body))
    poses = [judge.world.start([walk[t]])[0] for t in (0, len(walk) - 1)]
    gaps = [min(judge.gap_to(s, pose) for s in room.statics.values()) for pose in poses]
    assert gaps[0] > 0.001  # the floor is 2 mm below, all other items at least 2.5 mm away
    ghost = judge.judge_poses(np.array([judge.world.start([walk[t]])[0] for t in range(60)]))
    assert not ghost.clear


def test_merged_is_the_same_surface_in_as_many_triangles(shared_data, body, walk):
    room = furnished(walk, body, shared_data / "meshes", 0)
    given = [s.mesh() for s in room.statics.values()]
    area = sum(_area(np.asarray(v), np.asarray(f)) for v, f in given)
    for count in (10_000, 100_000):
        fine = merged(room, count).statics["room"].shape
        assert count - 3 < len(fine.faces) <= count
        assert _area(fine.vertices, fine.faces) == pytest.approx(area, rel=ROUNDING)
    lows = [
        judged.min(axis=0)
        for judged in (
            np.concatenate([s.mesh()[0] @ _turn(s).T + s.position for s in room.statics.values()]),
            fine.vertices,
        )
    ]
    np.testing.assert_allclose(lows[0], lows[1], atol=ROUNDING)


def _turn(static):
    from halfphysics.base import rotations as rot

    return rot.to_matrix(static.quaternion)


def _area(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
