"""The tree over a mesh's triangles: complete for any arrangement, and shared by content."""

from __future__ import annotations

import gc

import numpy as np
import pytest

from halfphysics import _native
from halfphysics.body.body import Body
from halfphysics.body.rigid_parts import part_collider
from halfphysics.geometry.colliders import hull_collider
from halfphysics.geometry.shapes import Box
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator
from support.people import t_pose

#: Accuracy of distances to triangles by GJK [m].
EXACT = 1e-9
#: Triangles this much farther than the nearest may be first among the planes [m].
NEAREST = 1e-6
#: The disc of a point: none.
NO_DISC = np.zeros(3)


def soup(seed, n=300, size=0.1):
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-1.0, 1.0, size=(n, 1, 3)) + size * rng.normal(size=(n, 3, 3))
    return corners.reshape(-1, 3), np.arange(3 * n, dtype=np.int32).reshape(-1, 3)


def geometric(n=400):
    """Triangles whose positions halve towards the origin: bins split off one at a time."""
    scale = 0.5 ** np.arange(n, dtype=np.float64)[:, None, None]
    one = np.array([[1.0, 0.0, 0.0], [1.1, 0.1, 0.0], [1.0, 0.1, 0.1]])
    return (scale * one).reshape(-1, 3), np.arange(3 * n, dtype=np.int32).reshape(-1, 3)


def one_place(n=1000):
    """The same triangle many times, and one elsewhere."""
    vertices = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [3.0, 3.0, 3.0]])
    faces = np.tile(np.array([[0, 1, 2]], dtype=np.int32), (n, 1))
    faces[n // 2] = [3, 3, 3]
    return vertices, faces


def nearest(point, vertices, faces):
    """Distance of a point (3,) to the nearest triangle; trees of one triangle leave none out."""
    one = np.array([[0, 1, 2]], dtype=np.int32)
    alone = (
        _native.triangle_planes(vertices[f], one, point[None], 0.0, NO_DISC, 50.0) for f in faces
    )
    return min(distance for _, distance, _ in alone)


@pytest.mark.parametrize(
    "mesh",
    [soup(1), soup(2, size=1.0), geometric(), one_place()],
    ids=["soup", "large", "geometric", "one place"],
)
def test_no_triangle_is_lost(mesh):
    """Distances through the tree are the minimum over all single triangles."""
    vertices, faces = mesh
    points = np.random.default_rng(3).uniform(-2.0, 2.0, size=(6, 3))
    points[0] = [0.0, 0.0, -0.1]
    for point in points:
        expected = nearest(point, vertices, faces)
        planes, found, _ = _native.triangle_planes(vertices, faces, point[None], 0.0, NO_DISC, 50.0)
        assert found == pytest.approx(expected, abs=EXACT)
        # The nearest plane names its face by its given index.
        a, b, c = vertices[faces[int(planes[0, 5])]]
        assert planes[0, 4] == pytest.approx(expected, abs=NEAREST)
        offsets = [planes[0, :3] @ x - planes[0, 3] for x in (a, b, c)]
        assert max(offsets) == pytest.approx(0.0, abs=EXACT)


def test_equal_content_is_one_tree():
    vertices, faces = soup(4)
    one = _native.MeshTree(vertices, faces)
    assert len(one) == len(faces)
    assert one.shares == 1
    again = _native.MeshTree(vertices.copy(), faces.copy())
    assert one.shares == again.shares == 2
    moved = vertices.copy()
    moved[7, 1] = np.nextafter(moved[7, 1], 2.0)
    turned = faces.copy()
    turned[5] = np.roll(turned[5], 1)
    others = [_native.MeshTree(moved, faces), _native.MeshTree(vertices, turned)]
    others.append(_native.MeshTree(vertices, faces[:-1].copy()))
    assert [tree.shares for tree in others] == [1, 1, 1]
    assert one.shares == 2
    del again
    assert one.shares == 1


def test_statics_and_simulators_share_and_let_go():
    import trimesh

    def scene():
        out = Scene()
        out.add_static("it", trimesh.creation.box((1.0, 1.0, 1.0)), position=(5.0, 0.0, 0.0))
        return out

    vertices, faces = scene().statics["it"].mesh()
    at = np.ascontiguousarray(np.add(vertices, (5.0, 0.0, 0.0)))
    outside = _native.MeshTree(at, np.ascontiguousarray(faces, dtype=np.int32))
    assert outside.shares == 1
    first, second = scene(), scene()
    simulators = [Simulator(s, body=[]) for s in (first, first, second)]
    assert outside.shares == 1 + 2 + 3  # this one, the two scenes, the three simulators
    del simulators
    gc.collect()
    assert outside.shares == 1 + 2  # a scene keeps its own for the next simulator
    del first, second
    gc.collect()
    assert outside.shares == 1


def test_faces_that_name_nothing_are_refused():
    vertices, faces = soup(5)
    for bad in (-1, len(vertices)):
        wrong = faces.copy()
        wrong[3, 1] = bad
        with pytest.raises(ValueError, match="names a vertex that does not exist"):
            _native.MeshTree(vertices, wrong)
    with pytest.raises(ValueError, match="at least one triangle"):
        _native.MeshTree(vertices, faces[:0].copy())


def test_parts_are_worked_out_once_and_the_same():
    parts = Body.default().variant.parts
    for part in (parts[0], parts[25]):
        collider = part_collider(part)
        assert part_collider(part) is collider
        fresh = hull_collider(part.vertices)
        np.testing.assert_array_equal(collider.vertices, fresh.vertices)
        np.testing.assert_array_equal(collider.normals, fresh.normals)


def test_a_box_as_mesh_and_as_box_are_the_same_to_touch():
    """The tree has the pose of its static, rotation included."""
    import trimesh

    turn, at = (0.9, 0.3, 0.1, 0.2), (0.6, 0.1, 0.2)
    distances = []
    for shape in (Box((0.3, 0.4, 0.5)), trimesh.creation.box((0.3, 0.4, 0.5))):
        scene = Scene()
        scene.add_static("it", shape, position=at, quaternion=np.divide(turn, np.linalg.norm(turn)))
        settings = Settings(clearance_range=5.0)
        simulator = Simulator(scene, body=Body.default(), settings=settings)
        distances.append(simulator.reset(t_pose(np.zeros((2, 3)))[0]).clearance)
    assert distances[0] == pytest.approx(distances[1], abs=EXACT)
