"""evidence.rooms.verify: an independent library's measure of a skin in a scene."""

from __future__ import annotations

import coal
import numpy as np
import pytest

import halfphysics as hp
from evidence.rooms import verify
from evidence.rooms.verify import _Cells
from halfphysics.base import rotations
from halfphysics.bench.clips import straight
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Capsule, Mesh, Plane, Sphere


@pytest.fixture(scope="module")
def body():
    return hp.Body.default()


@pytest.fixture(scope="module")
def motion():
    """A T-pose that glides 1 m along x."""
    return straight(1.0, 1.0, 0.0)


def scene_of(*shapes, at=(0.0, 0.0, 0.0)):
    scene = hp.Scene()
    for k, shape in enumerate(shapes):
        scene.add_static(f"thing{k}", shape, position=at)
    return scene


def whole(body, motion, frame, mesh):
    """The whole skin against all of a mesh: no cells, nothing left out."""

    def tree(vertices, faces):
        model = coal.BVHModelOBBRSS()
        model.beginModel(len(faces), len(vertices))
        model.addVertices(np.ascontiguousarray(vertices, dtype=float))
        model.addTriangles(np.ascontiguousarray(faces, dtype=np.int64))
        model.endModel()
        assert model.num_tris == len(faces)
        return model

    skin, here = tree(body.vertices(motion[frame]), body.faces), coal.Transform3s()
    other = tree(mesh.vertices, mesh.faces)
    met = coal.collide(skin, here, other, here, coal.CollisionRequest(), coal.CollisionResult())
    asked, found = coal.DistanceRequest(), coal.DistanceResult()
    return bool(met), coal.distance(skin, here, other, here, asked, found)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["box", "mesh", "turned mesh"])
def test_a_wall_is_met_when_it_is_reached(body, motion, kind):
    """A person who glides into a wall meets it from the first frame with a vertex over it."""
    ways = body.vertices(motion)[:, :, 0]
    lead, trail = ways.max(axis=1), ways.min(axis=1)
    front = lead[0] + 0.48
    back = front + 0.2
    wall = Box((0.2, 4.0, 4.0))
    scene = hp.Scene()
    shape = wall if kind == "box" else Mesh(*wall.triangles())
    turn = rotations.exp([np.pi, 0.0, 0.0]) if kind == "turned mesh" else (1.0, 0.0, 0.0, 0.0)
    scene.add_static("wall", shape, position=(front + 0.1, 0.0, 1.0), quaternion=turn)
    found = verify.verify(motion, body, scene)
    # No body is as thin as the wall is thick, so no frame within it is missed.
    meets = (lead > front) & (trail < back)
    assert meets.argmax() == 15
    assert found.frames == found.checked == 31
    assert found.intersecting == meets.sum()
    clear = np.maximum(front - lead, trail - back)[~meets].min()
    assert found.distance == pytest.approx(clear, abs=1e-9)


def test_distance_is_that_of_the_surfaces(body, motion):
    """Over a plane and before a ball: by hand; before a mesh: against all triangles."""
    skin = body.vertices(motion[0])
    low = float(skin[:, 2].min())
    one = motion[:2]
    assert verify.verify(one, body, scene_of(Plane((0, 0, 1), low - 0.0123))).distance == (
        pytest.approx(0.0123, abs=1e-9)
    )
    assert verify.verify(one, body, scene_of(Plane((0, 0, 1), low + 1e-6))).intersecting == 2
    mesh = Mesh(*Sphere(0.2).triangles())
    above = skin[skin[:, 2].argmax()] + np.array([0.0, 0.0, 0.22])
    placed = Mesh(mesh.vertices + above, mesh.faces)
    found = verify.verify(one, body, scene_of(placed))
    expected = min(whole(body, one, k, placed)[1] for k in range(2))
    assert found.distance == pytest.approx(expected, abs=1e-9)
    assert found.intersecting == 0


def test_a_needle_between_the_vertices_is_found(body, motion):
    """No vertex is inside, but the skin is pierced."""
    one = motion[:2]
    corners = body.vertices(one[0])[body.faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]),
                          axis=1)  # fmt: skip
    face = int(area.argmax())
    middle = corners[face].mean(axis=0)
    normal = np.cross(*(corners[face][1:] - corners[face][0]))
    normal /= np.linalg.norm(normal)
    side = np.cross(normal, [0.0, 0.0, 1.0]) * 1e-4
    needle = np.array([middle - 0.01 * normal, middle + 0.02 * normal + side,
                       middle + 0.02 * normal - side])  # fmt: skip
    scene = scene_of(Mesh(needle, np.array([[0, 1, 2]])))
    assert hp.metrics.penetration(one, body, scene).rate_percent == 0.0
    assert verify.verify(one, body, scene).intersecting >= 1


@pytest.mark.slow
def test_cells_leave_out_nothing_that_meets(body, motion):
    """Many small and large triangles at random: the same as a test of the whole skin."""
    rng = np.random.default_rng(3)
    for size in (0.02, 0.3, 3.0):
        for _ in range(4):
            centre = rng.uniform([-0.3, -0.9, -1.2], [0.5, 0.9, 0.6], (6, 1, 3))
            corners = centre + size * rng.normal(0.0, 1.0, (6, 3, 3))
            mesh = Mesh(corners.reshape(-1, 3), np.arange(18).reshape(-1, 3))
            met, distance = whole(body, motion, 0, mesh)
            found = verify.verify(motion[:2], body, scene_of(mesh))
            assert (found.intersecting > 0) or not met
            if found.intersecting == 0 and distance < 0.028:
                near = min(distance, whole(body, motion, 1, mesh)[1])
                assert found.distance == pytest.approx(near, abs=1e-9)


def test_long_edges_are_always_looked_at():
    """A skin triangle larger than the cells, with no corner near the mesh."""
    corners = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
    low = np.array([[0.45, 0.45, -0.1]])
    cells = _Cells(low, low + 0.02, corners.min(axis=0), corners.max(axis=0))
    assert len(cells.near(corners, np.array([[0, 1, 2]]))) == 1


def test_what_ignores_the_person_is_left_out(body, motion):
    scene = scene_of(Capsule(0.3, 0.5))
    assert verify.verify(motion[:2], body, scene).intersecting == 2
    scene.ignore("thing0", "person")
    assert verify.verify(motion[:2], body, scene).intersecting == 0


def test_every_so_manieth_frame_and_the_last(body, motion):
    found = verify.verify(motion, body, scene_of(Plane((0, 0, 1), -9.0)), every=8)
    assert (found.frames, found.checked) == (31, 5)
    assert "0 of 5 frames looked at of 31 intersect" in str(found)
    with pytest.raises(InputError, match="every: found 0"):
        verify.verify(motion, body, hp.Scene(), every=0)


def test_without_the_library_nothing_is_verified(body, motion, monkeypatch):
    monkeypatch.setattr(verify, "find_spec", lambda name: None)
    assert verify.library() is None
    assert verify.verify(motion, body, hp.Scene()) is None
