"""The judges' pieces of people are those that the core keeps clear."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator
from support.judges.person_hulls import CONTACTS, pieces_of
from support.people import violent

#: Some dozens of products of numbers around one [m].
ROUNDING = 1e-12


@pytest.fixture(scope="module", params=["default", "blend shapes"])
def body(request):
    plain = Body.default()
    if request.param == "default":
        return plain
    rng = np.random.default_rng(3)
    return replace(plain, posedirs=1e-3 * rng.normal(size=(len(plain.rest_vertices), 3, 486)))


@pytest.fixture(params=CONTACTS)
def simulator(body, request):
    return Simulator(Scene(), body=body, settings=Settings(contact=request.param))


def poses_of(simulator, count):
    motion = violent(count)
    return np.array([simulator.world.start([pose])[0] for pose in motion])


@pytest.mark.slow
def test_pieces_are_those_of_the_core(simulator):
    (pieces,) = pieces_of(simulator)
    poses = poses_of(simulator, 4)
    at = pieces.at(poses)
    assert len(pieces.names) == len(simulator.world.shape_part)
    for t, pose in enumerate(poses):
        for i in range(len(pieces.names)):
            core = np.asarray(simulator.world.stepper.shape_points(pose, i))
            mine = at.points(i, t)
            assert len(core) == len(mine)
            # The core's corners have their own order.
            order = [np.lexsort(np.round(p, 9).T) for p in (core, mine)]
            assert np.abs(core[order[0]] - mine[order[1]]).max() <= ROUNDING


def test_boxes_are_around_the_corners(simulator):
    (pieces,) = pieces_of(simulator)
    at = pieces.at(poses_of(simulator, 2))
    for t in (0, 1):
        for i in range(len(pieces.names)):
            np.testing.assert_array_equal(at.low[t, i], at.points(i, t).min(axis=0))
            np.testing.assert_array_equal(at.high[t, i], at.points(i, t).max(axis=0))


@pytest.mark.slow
def test_ways_lead_from_pose_to_pose_and_are_no_longer_than_is_said(simulator):
    (pieces,) = pieces_of(simulator)
    at = pieces.at(poses_of(simulator, 12)[::2])
    shares = np.linspace(0.0, 1.0, 33)
    for i in range(0, len(pieces.names), 7):
        for t in (0, 2, 4):
            way = np.array([at.between(i, t, share) for share in shares])
            assert np.abs(way[0] - at.points(i, t)).max() <= ROUNDING
            assert np.abs(way[-1] - at.points(i, t + 1)).max() <= ROUNDING
            travelled = np.linalg.norm(np.diff(way, axis=0), axis=2).sum(axis=0).max()
            assert 0.0 < travelled <= at.length(i, t) + ROUNDING
