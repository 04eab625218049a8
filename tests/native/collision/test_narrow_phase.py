"""What a step takes near something meets it: a ball among loose triangles, however many planes it
has, and what was farther off than pairs whose plane is sought at once.
"""

from __future__ import annotations

import coal
import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Mesh
from halfphysics.scene.scene import Scene
from halfphysics.settings import AS_IT_IS, Settings
from halfphysics.simulation.simulate import simulate
from support.judges.coal_shapes import coal_hull, coal_shape
from support.loose_triangles import around_a_ball
from support.people import along_x, t_pose

RADIUS, AHEAD = 0.1, 0.015
#: Where the ball starts: far from the person [m].
PLACE = np.array([0.0, 5.0, 1.0])
#: Accuracy of coal's own distances [m].
ROUNDING = 1e-6


@pytest.fixture(scope="module")
def body():
    return Body.default()


def icosphere():
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=2, radius=RADIUS)
    return np.asarray(ball.vertices), np.asarray(ball.faces)


def with_plate(vertices, faces):
    """Triangles and a plate across x, 15 mm ahead of the ball."""
    x, n = RADIUS + AHEAD, len(vertices)
    plate = np.array([[x, -0.3, -0.3], [x, 0.3, -0.3], [x, 0.3, 0.3], [x, -0.3, 0.3]])
    more = np.array([[n, n + 1, n + 2], [n, n + 2, n + 3]])
    return np.concatenate([vertices, plate]), np.concatenate([faces, more])


def thrown(body, vertices, faces, speed, substeps):
    """Committed positions (S, 3) of the ball's centre, which is thrown along x, and the result."""
    scene = Scene()
    scene.add_static("cloud", Mesh(vertices + PLACE, faces))
    ball = Mesh(*icosphere())
    scene.add_object("ball", ball, mass=1.0, position=PLACE, velocity=(speed, 0.0, 0.0))
    settings = Settings(substeps=substeps, record="substeps")
    result = simulate(t_pose(np.zeros((8, 3))), scene, body=body, settings=settings)
    return result.substeps.objects["ball"], result


def smallest_gap(track, vertices, faces):
    """Of the ball from the triangles over all committed poses, by coal [m]."""
    ball, soup = coal_hull(icosphere()[0]), coal_shape(Mesh(vertices + PLACE, faces), solid=False)
    gaps = []
    for position, quaternion in zip(track.position, track.quaternion, strict=True):
        place = coal.Transform3s(coal.Quaternion(*quaternion), position)
        gaps.append(
            coal.distance(
                ball,
                place,
                soup,
                coal.Transform3s.Identity(),
                coal.DistanceRequest(),
                coal.DistanceResult(),
            )
        )
    return min(gaps)


@pytest.mark.parametrize("substeps", [1, 8])
@pytest.mark.parametrize("speed", [0.7, 5.0])
@pytest.mark.parametrize("count", [0, 60, 120, 700, 2000])
def test_a_plate_behind_many_planes_is_met(body, count, speed, substeps):
    """Such a ball once went through: the search stopped at 64 planes."""
    rng = np.random.default_rng(1000 * count + substeps)
    cloud = around_a_ball(rng, count, cone=-0.05)
    vertices, faces = with_plate(*cloud)
    track, result = thrown(body, vertices, faces, speed, substeps)
    x = track.position[:, 0]
    assert x.max() > 0.5 * AHEAD  # it did get there
    assert x.max() < AHEAD  # and not through
    assert smallest_gap(track, vertices, faces) > ROUNDING
    assert not len(result.inside)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_a_plate_behind_planes_near_and_far_is_met(body, seed):
    """Triangles at any distance: the planes hold for less than the step, which is then shorter."""
    rng = np.random.default_rng(seed)
    count, far = int(rng.integers(60, 3000)), rng.uniform(0.004, 0.08)
    cloud = around_a_ball(rng, count, cone=-0.05, far=far)
    vertices, faces = with_plate(*cloud)
    track, _ = thrown(body, vertices, faces, rng.uniform(0.5, 8.0), int(rng.integers(1, 9)))
    assert track.position[:, 0].max() < AHEAD
    assert smallest_gap(track, vertices, faces) > ROUNDING


@pytest.mark.parametrize("start", [-0.1, -0.094, -0.087])
def test_what_waits_for_its_plane_is_met(body, start):
    """Steps of 17 mm cross gaps at which a bound stands in for the plane of a person's part."""
    scene = Scene()
    scene.add_static("wall", Box((0.01, 6.0, 6.0)), position=(0.5, 0.0, 0.0))
    motion = along_x(4.0, 8, start=start)
    settings = Settings(substeps=8, record="substeps", **AS_IT_IS)
    result = simulate(motion, scene, body=body, settings=settings)
    assert len(result.contacts.part) > 0  # it did get there
    assert result.clearance.min() > 0.5e-3  # of the clearance of 1 mm
    assert not len(result.inside)
    assert not len(result.breaches)
