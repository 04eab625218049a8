"""Inside and distance: against closed forms, the numpy reference, trimesh and coal."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from halfphysics.errors import InputError
from halfphysics.geometry.mesh_files import load_mesh
from halfphysics.geometry.mesh_queries import (
    MeshQuery,
    boundary_edges,
    is_closed,
    merge_vertices,
    piece_count,
)
from halfphysics.geometry.shapes import Box, Cylinder, Sphere
from support.references.mesh_queries import closest_reference, winding_reference

# Sums of up to 10,000 solid angles, each accurate to a few units in the last place.
ROUNDING = 1e-9


def _soup(seed: int, n: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(n, 1, 3)) + rng.normal(scale=0.4, size=(n, 3, 3))
    return corners.reshape(-1, 3), np.arange(3 * n).reshape(-1, 3)


def _opened_sphere() -> tuple[np.ndarray, np.ndarray]:
    vertices, faces = Sphere(1.0).triangles()
    return vertices, faces[vertices[faces].mean(axis=1)[:, 2] < 0.7]


@pytest.fixture(scope="module")
def probes() -> np.ndarray:
    return np.random.default_rng(3).uniform(-1.4, 1.4, (1000, 3))


def test_box_is_inside_exactly_where_it_says(probes: np.ndarray) -> None:
    box = Box((2.0, 1.0, 1.4))
    query = MeshQuery(*box.triangles())
    expected = (np.abs(probes) < 0.5 * np.asarray(box.size)).all(axis=1)
    assert expected.sum() > 100
    np.testing.assert_array_equal(query.inside(probes), expected)
    vertices, faces = box.triangles()
    for facing in (faces, faces[:, ::-1]):
        np.testing.assert_array_equal(MeshQuery(vertices, facing).enclosed(probes), expected)
    np.testing.assert_array_equal(query.winding(probes), expected.astype(float))
    np.testing.assert_allclose(query.depth(probes), box.depth(probes), atol=1e-12)


def test_sphere_depth_within_its_facets(probes: np.ndarray) -> None:
    depth = MeshQuery(*Sphere(1.0).triangles()).depth(probes)
    exact = 1.0 - np.linalg.norm(probes, axis=1)
    # 32 segments: the triangles cut up to 1 - cos^2(pi / 32) = 0.0096 into the ball.
    assert (depth <= np.maximum(exact, 0.0) + 1e-12).all()
    assert (depth >= exact - 0.0097).all()


def test_winding_on_a_grid_aligned_with_edges_and_vertices() -> None:
    """Rays through corners and along edges count once: nothing leaks and nothing doubles."""
    vertices, faces = Box((2.0, 2.0, 2.0)).triangles()
    steps = np.array([-1.5, -0.999, -0.5, 0.0, 0.5, 0.999, 1.5])
    grid = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
    query = MeshQuery(vertices, faces)
    np.testing.assert_array_equal(query.inside(grid), (np.abs(grid) < 1.0).all(axis=1))
    sphere_vertices, sphere_faces = Sphere(1.0).triangles()
    under = sphere_vertices * [1.0, 1.0, 0.0]  # exactly below and above corners and edges
    under = under[np.linalg.norm(under, axis=1) < 0.95]
    assert MeshQuery(sphere_vertices, sphere_faces).inside(under).all()
    assert not MeshQuery(sphere_vertices, sphere_faces).inside(under - [0, 0, 2.0]).any()


@pytest.mark.slow
@pytest.mark.parametrize("case", ["closed", "opened", "soup", "flipped", "two", "nested"])
def test_equals_the_reference(case: str, probes: np.ndarray) -> None:
    vertices, faces = Sphere(1.0).triangles()
    if case == "opened":
        vertices, faces = _opened_sphere()
    elif case == "soup":
        vertices, faces = _soup(1, 300)
    elif case == "flipped":  # mixed winding
        faces = faces.copy()
        faces[::3] = faces[::3, ::-1]
    elif case == "two":  # overlapping and not merged
        faces = np.concatenate([faces, faces + len(vertices)])
        vertices = np.concatenate([vertices, 0.6 * vertices + [0.5, 0.0, 0.2]])
    elif case == "nested":  # a hollow ball
        faces = np.concatenate([faces, faces[:, ::-1] + len(vertices)])
        vertices = np.concatenate([vertices, 0.6 * vertices])
    query = MeshQuery(vertices, faces)
    reference = winding_reference(probes, vertices, faces)
    np.testing.assert_allclose(query.winding(probes, tolerance=0.0), reference, atol=ROUNDING)
    np.testing.assert_allclose(query.winding(probes, tolerance=1e-3), reference, atol=1e-3)
    np.testing.assert_array_equal(query.inside(probes), reference > 0.5)
    distance, face, closest = query.closest(probes)
    expected = closest_reference(probes, vertices, faces)
    np.testing.assert_allclose(distance, expected[0], atol=1e-12)
    np.testing.assert_allclose(closest, expected[2], atol=1e-7)
    # The face is one that holds the closest point (several may).
    own = closest_reference(closest, vertices, faces)[0]
    np.testing.assert_allclose(own, 0.0, atol=1e-12)
    for i in range(0, len(probes), 100):
        single = closest_reference(probes[i : i + 1], vertices, faces[face[i] : face[i] + 1])
        assert single[0][0] == pytest.approx(distance[i], abs=1e-12)


def test_hollow_ball_is_empty_inside_and_inside_out_holds_nothing() -> None:
    vertices, faces = Sphere(1.0).triangles()
    hollow = MeshQuery(
        np.concatenate([vertices, 0.5 * vertices]),
        np.concatenate([faces, faces[:, ::-1] + len(vertices)]),
    )
    np.testing.assert_array_equal(hollow.inside([[0, 0, 0], [0.75, 0, 0]]), [False, True])
    reversed_ = MeshQuery(vertices, faces[:, ::-1])
    np.testing.assert_array_equal(reversed_.winding([[0, 0, 0], [3, 0, 0]]), [-1.0, 0.0])
    assert not reversed_.inside([[0.0, 0.0, 0.0]]).any()


def test_open_sphere_fades_through_its_hole() -> None:
    query = MeshQuery(*_opened_sphere())
    along = np.stack([np.zeros(60), np.zeros(60), np.linspace(-0.9, 2.5, 60)], axis=1)
    winding = query.winding(along)
    assert (np.diff(winding) < 0.0).all()
    assert winding[0] > 0.85
    assert 0.0 < winding[-1] < 0.05
    assert query.inside([[0.0, 0.0, 0.0]]).all()


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 60), st.sampled_from([1.0, 1e-3, 0.0]))
def test_slivers_and_flat_triangles(seed: int, n: int, thickness: float) -> None:
    """Triangles squeezed to slivers and to segments keep their distance."""
    rng = np.random.default_rng(seed)
    vertices, faces = _soup(seed, n)
    direction = rng.normal(size=3)
    base = vertices.reshape(n, 3, 3)
    spread = np.einsum("nki,i->nk", base - base[:, :1], direction)
    flat = base[:, :1] + spread[..., None] * direction + thickness * (base - base[:, :1])
    vertices = flat.reshape(-1, 3)
    points = rng.normal(size=(20, 3))
    query = MeshQuery(vertices, faces)
    distance, _, closest = query.closest(points)
    np.testing.assert_allclose(distance, closest_reference(points, vertices, faces)[0], atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(points - closest, axis=1), distance, atol=1e-12)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 200))
@example(640, 169)  # the error of a cluster that the ball nearly touches swallowed all others
def test_in_or_out_never_differs_on_soups(seed: int, n: int) -> None:
    vertices, faces = _soup(seed, n)
    points = np.random.default_rng(seed + 1).normal(size=(200, 3))
    reference = winding_reference(points, vertices, faces)
    np.testing.assert_array_equal(MeshQuery(vertices, faces).inside(points), reference > 0.5)


def test_far_field_is_of_second_order() -> None:
    """Seen from twice as far, the omitted part of one cluster is 2^4 times smaller."""
    vertices, faces = _soup(2, 40)
    direction = np.random.default_rng(0).normal(size=(300, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    query = MeshQuery(vertices, faces)
    errors = []
    for distance in (40.0, 80.0):
        points = distance * direction
        error = query.winding(points, tolerance=1.0) - winding_reference(points, vertices, faces)
        errors.append(np.sqrt((error**2).mean()))
    # The next order adds a part of about soup size over distance, 0.05.
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.1)


def test_threads_give_the_same_bits() -> None:
    vertices, faces = _soup(5, 500)
    faces = np.concatenate([faces, Sphere(1.0).triangles()[1] + len(vertices)])
    vertices = np.concatenate([vertices, Sphere(1.0).triangles()[0]])
    points = np.random.default_rng(0).normal(size=(5000, 3))
    query = MeshQuery(vertices, faces)
    for threads in (2, 3):
        np.testing.assert_array_equal(query.winding(points), query.winding(points, threads=threads))
        np.testing.assert_array_equal(query.inside(points), query.inside(points, threads=threads))
        for a, b in zip(query.closest(points), query.closest(points, threads=threads), strict=True):
            np.testing.assert_array_equal(a, b)
    # The other points of a query have no effect either.
    order = np.random.default_rng(1).permutation(len(points))
    for a, b in zip(query.closest(points), query.closest(points[order]), strict=True):
        np.testing.assert_array_equal(a[order], b)


def test_closest_agrees_with_trimesh_and_coal(probes: np.ndarray) -> None:
    coal = pytest.importorskip("coal")
    trimesh = pytest.importorskip("trimesh")
    vertices, faces = Cylinder(0.7, 1.2).triangles()
    points = probes[:300]
    distance, _, closest = MeshQuery(vertices, faces).closest(points)
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    theirs, their_distance, _ = trimesh.proximity.closest_point_naive(mesh, points)
    np.testing.assert_allclose(distance, their_distance, atol=1e-9)
    np.testing.assert_allclose(closest, theirs, atol=1e-9)
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(faces), len(vertices))
    model.addVertices(vertices)
    model.addTriangles(faces.astype(np.int64))
    model.endModel()
    for point, d in zip(points[:100], distance, strict=False):
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        tiny = coal.Sphere(1e-6)
        pose = coal.Transform3s(np.eye(3), point)
        coal.distance(model, coal.Transform3s(), tiny, pose, request, result)
        assert result.min_distance + 1e-6 == pytest.approx(d, abs=2e-6)


@pytest.mark.parametrize("name", ["couch", "cabinet_medium", "bed_single_A"])
def test_real_furniture_equals_the_full_sum(shared_data: Path, name: str) -> None:
    """Closed solids that overlap (couch) and solids with holes (cabinet, bed)."""
    mesh, _ = load_mesh(
        shared_data / "meshes" / "kaykit_furniture" / f"{name}.obj", scale=0.7, up="y"
    )
    rng = np.random.default_rng(0)
    low, high = mesh.query.bounds
    points = rng.uniform(low - 0.1, high + 0.1, (1500, 3))
    reference = winding_reference(points, mesh.vertices, mesh.faces)
    assert 0.1 < (reference > 0.5).mean() < 0.9
    np.testing.assert_array_equal(mesh.query.inside(points), reference > 0.5)
    np.testing.assert_allclose(mesh.query.winding(points), reference, atol=ROUNDING)
    expected = closest_reference(points, mesh.vertices, mesh.faces)[0]
    np.testing.assert_allclose(mesh.query.closest(points)[0], expected, atol=1e-12)


def test_merging_and_topology() -> None:
    vertices, faces = Box((1.0, 1.0, 1.0)).triangles()
    loose = vertices[faces].reshape(-1, 3)
    loose[loose == 0.0] = -0.0
    merged, back = merge_vertices(
        np.vstack([[[9.0, 9, 9]], loose]), 1 + np.arange(36).reshape(-1, 3)
    )
    assert merged.shape == (8, 3)
    assert is_closed(back, 8)
    assert piece_count(back, 8) == 1
    np.testing.assert_array_equal(merged[back], vertices[faces])
    rim = boundary_edges(back[1:], 8)
    assert len(rim) == 3
    # The rim runs as the missing triangle's neighbours do: against the missing triangle.
    missing = {(int(a), int(b)) for a, b in zip(back[0], np.roll(back[0], -1), strict=True)}
    assert {(int(b), int(a)) for a, b in rim} == missing
    _, none = merge_vertices(np.zeros((3, 3)), np.array([[0, 1, 2]]))
    assert len(none) == 0


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (np.zeros((3, 2)), [[0, 1, 2]], "shape"),
        (np.full((3, 3), np.nan), [[0, 1, 2]], "NaN"),
        (np.eye(3), np.zeros((0, 3), int), "F > 0"),
        (np.eye(3), [[0, 1, 3]], "0 to 2"),
        (np.eye(3), [[0, 1, -1]], "0 to 2"),
    ],
)
def test_bad_arrays(vertices: np.ndarray, faces: np.ndarray, message: str) -> None:
    with pytest.raises(InputError, match=message):
        MeshQuery(vertices, faces)


def test_bad_points() -> None:
    query = MeshQuery(*Sphere(1.0).triangles())
    with pytest.raises(InputError, match="NaN"):
        query.inside([[0.0, np.nan, 0.0]])
    with pytest.raises(InputError, match=r"\(n, 3\)"):
        query.closest([0.0, 0.0, 0.0])
    assert query.inside(np.zeros((0, 3))).shape == (0,)
