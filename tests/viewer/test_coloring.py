"""Parts coloured by contact: the right patches, in the right colours, on the skin."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.viewer.coloring import BOUNDS, RAMP, Touched, level, part_forces, patch
from halfphysics.viewer.figure import rgb
from support.results.small_result import FPS, FRAMES, small_result

pytest.importorskip("viser")

FOOT, SHOULDER = JOINT_INDEX["right_foot"], JOINT_INDEX["right_shoulder"]


@pytest.fixture(scope="module")
def stage():
    from halfphysics.viewer.server import close_server, open_server
    from halfphysics.viewer.stage import Stage

    server = open_server("127.0.0.1", 0)
    yield Stage(server, small_result())
    close_server(server)


@pytest.fixture(scope="module")
def touched(stage):
    return Touched(stage._server, stage)


def square(n):
    """A grid of n x n vertices on [0, 1] x [0, 1], with its triangles."""
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate([np.stack([a, a + n, a + 1], 1), np.stack([a + n, a + n + 1, a + 1], 1)])
    return vertices, faces


def area(vertices, faces):
    """Areas with their sign, seen from above."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a)[:, 2]


@pytest.mark.parametrize("normal", [(1.0, 0.0), (0.0, -1.0), (0.6, 0.8), (-0.8, 0.6)])
def test_a_patch_is_cut_along_the_line(normal):
    vertices, faces = square(7)
    field = (vertices[:, :2] - 0.47) @ normal
    weights = np.stack([vertices[:, 0], 1.0 - vertices[:, 0]], axis=1)
    points, triangles, shares = patch(field, vertices, faces, weights)
    # All points on the right side of the line, none on the other, no triangle turned over.
    assert ((points[:, :2] - 0.47) @ normal).min() > -1e-12
    assert area(points, triangles).min() >= 0.0
    grid = np.linspace(0, 1, 1001)
    grid = 0.5 * (grid[1:] + grid[:-1])
    x, y = np.meshgrid(grid, grid)
    expected = ((x - 0.47) * normal[0] + (y - 0.47) * normal[1] >= 0).mean()
    assert area(points, triangles).sum() == pytest.approx(expected, abs=2e-3)
    # Vertex attributes are linear along the cut too.
    np.testing.assert_allclose(shares[:, 0], points[:, 0], atol=1e-12)
    assert np.unique(triangles).tolist() == list(range(len(points)))


def test_patches_of_all_parts_cover_the_skin_once():
    body = small_result().people[0].body
    weights = np.asarray(body.weights)

    def size(vertices, faces):
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()

    vertices = np.asarray(body.rest_vertices)
    total = 0.0
    for part in range(weights.shape[1]):
        field = weights[:, part] - np.delete(weights, part, axis=1).max(axis=1)
        total += size(*patch(field, vertices, body.faces, weights)[:2])
    # Where three parts meet within a face, the cut is not exact.
    assert total == pytest.approx(size(vertices, body.faces), rel=0.01)


def test_forces_of_parts_are_in_newtons():
    force = part_forces(small_result(), 0)
    assert force.shape == (FRAMES, 55)
    assert force[0, FOOT] == pytest.approx(20.0 * FPS)
    assert force[10, FOOT] == pytest.approx(21.0 * FPS)  # the floor's and the ball's
    assert force[6, SHOULDER] == pytest.approx(3.0 * FPS)
    assert np.count_nonzero(force.any(axis=0)) == 2


def test_levels_and_colours_belong_together():
    assert len(RAMP) == len(BOUNDS) + 1
    assert [int(level(f)) for f in (0.1, 9.9, 10.0, 49.0, 200.0, 250.0, 1e5)] == [
        0, 0, 1, 1, 2, 3, 3,
    ]  # fmt: skip


def test_a_part_is_coloured_while_it_touches(stage, touched):
    (patches,) = touched.patches
    assert set(patches) == {FOOT, SHOULDER}
    for frame in (0, 6, 7, 8, 2, FRAMES - 1, 6):
        stage.show(frame)
        for part, one in patches.items():
            force = touched.forces[0][frame, part]
            assert one.handle.visible == (force > 0), (frame, part)
            if force > 0:
                assert one.handle.color == rgb(RAMP[int(level(force))])
    touched.visible = False
    assert not any(one.handle.visible for one in patches.values())
    stage.show(7)
    assert not any(one.handle.visible for one in patches.values())
    touched.visible = True
    assert patches[SHOULDER].handle.visible


def test_a_patch_lies_on_the_skin_in_any_pose(stage, touched):
    stage.show(7)
    body, motion = stage.people[0].body, small_result().motion
    skin = body.vertices(motion, frames=[7])[0]
    positions, quaternions = stage.people[0].bone_pose
    from scipy.spatial import cKDTree

    from halfphysics.base import rotations as rot

    for one in touched.patches[0].values():
        props = one.handle._impl.props
        rest = np.asarray(props.bone_positions, dtype=np.float64)
        vertices = np.asarray(props.vertices, dtype=np.float64)
        p, q = positions[one.bones], quaternions[one.bones]
        posed = np.zeros_like(vertices)
        for k in range(4):
            bone = np.asarray(props.skin_indices)[:, k].astype(int)
            moved = rot.rotate(q[bone], vertices - rest[bone]) + p[bone]
            posed += np.asarray(props.skin_weights)[:, k : k + 1] * moved
        distance = cKDTree(skin).query(posed)[0]
        # The skin's own vertices are slightly below; those of the cut lie between them.
        assert np.mean(distance < 0.002) > 0.7
        assert distance.max() < 0.02
        assert len(one.bones) <= 8
