"""Shapes: refused values, mass properties against sampling, depth against triangles."""

from __future__ import annotations

import warnings
import weakref

import numpy as np
import pytest

from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.geometry.mesh_queries import MeshQuery, is_closed, merge_vertices
from halfphysics.geometry.mesh_solids import solid_moments
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Shape, Sphere

SOLIDS = [Box((0.4, 0.6, 1.0)), Sphere(0.7), Capsule(0.3, 0.8), Cylinder(0.5, 0.9)]
BY_NAME = pytest.mark.parametrize("shape", SOLIDS, ids=lambda s: type(s).__name__)


@BY_NAME
def test_mass_properties_against_quadrature(shape: Shape) -> None:
    """Volume and inertia from a lattice of 100^3 cells over the solid's own depth > 0."""
    high = np.abs(shape.triangles()[0]).max(axis=0) * 1.001
    steps = [(np.arange(100) + 0.5) / 100 * 2 * h - h for h in high]
    grid = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = grid[shape.depth(grid) > 0.0]
    volume = len(inside) * np.prod(2 * high / 100)
    second = inside.T @ inside / len(inside)
    assert volume == pytest.approx(shape.volume, rel=0.01)
    np.testing.assert_allclose(
        np.trace(second) * np.eye(3) - second, shape.unit_inertia(), atol=0.01 * high.max() ** 2
    )


@pytest.mark.parametrize("shape", SOLIDS[1:], ids=lambda s: type(s).__name__)
def test_inertia_is_the_limit_of_its_triangulation(
    shape: Shape, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Triangles inscribed in a round solid converge to it with the square of their size."""
    errors = []
    for segments in (32, 64):
        monkeypatch.setattr("halfphysics.geometry.shapes._SEGMENTS", segments)
        volume, centre, inertia = solid_moments(*shape.triangles())
        np.testing.assert_allclose(centre, 0.0, atol=1e-12)
        exact = shape.volume * shape.unit_inertia()
        errors.append([shape.volume - volume, *np.diag(exact - inertia)])
    np.testing.assert_allclose(np.divide(*errors), 4.0, rtol=0.02)


def test_density_and_mass() -> None:
    box = Box((1.0, 2.0, 3.0))
    by_density, by_mass = box.mass_properties(density=2.0), box.mass_properties(mass=12.0)
    assert by_density.mass == pytest.approx(12.0)
    np.testing.assert_allclose(by_density.inertia, np.diag([13.0, 10.0, 5.0]))
    np.testing.assert_allclose(by_mass.inertia, by_density.inertia)
    for bad in ({}, {"mass": 1.0, "density": 1.0}):
        with pytest.raises(InputError, match=r"mass= .* or density="):
            box.mass_properties(**bad)
    for bad in (0.0, -1.0, float("nan"), float("inf"), "1", True, None):
        with pytest.raises(InputError, match="mass"):
            box.mass_properties(mass=bad)  # type: ignore[arg-type]


@BY_NAME
def test_triangulation_is_closed_outward_and_on_the_surface(shape: Shape) -> None:
    vertices, faces = shape.triangles()
    assert len(merge_vertices(vertices, faces)[0]) == len(vertices)
    assert is_closed(faces, len(vertices))
    assert 0.0 < solid_moments(vertices, faces)[0] <= shape.volume * (1 + 1e-12)
    assert shape.depth(0.999 * vertices).max() < 0.002
    assert shape.depth(1.000001 * vertices).max() == 0.0


@BY_NAME
def test_depth_against_the_triangles(shape: Shape, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("halfphysics.geometry.shapes._SEGMENTS", 128)
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (2000, 3))
    mesh = MeshQuery(*shape.triangles())
    # 128 segments: chords lie up to r (1 - cos(pi / 128)) = 0.0003 r under the surface, twice.
    np.testing.assert_allclose(mesh.depth(points), shape.depth(points), atol=6e-4)


def test_plane() -> None:
    plane = Plane(normal=(0.0, 0.0, 2.0), offset=0.5)
    assert plane.normal == (0.0, 0.0, 1.0)
    np.testing.assert_allclose(plane.depth([[0, 0, 0.2], [9, 9, 0.7]]), [0.3, 0.0])
    for normal in ((0, 0, 1), (1, 2, -3), (0, -1, 0)):
        slanted = Plane(normal=normal, offset=0.3)
        vertices, faces = slanted.triangles()
        np.testing.assert_allclose(vertices @ slanted.normal, 0.3)
        a, b, c = np.moveaxis(vertices[faces], 1, 0)
        assert (np.cross(b - a, c - a) @ slanted.normal > 0.0).all()
    assert Plane() == Plane((0, 0, 1), 0)
    assert hash(Plane()) == hash(Plane())


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Box((1, 1)), "Box: size .* 3 finite numbers"),
        (lambda: Box((1, 1, 0)), "Box: size: .* above 0"),
        (lambda: Box((1, 1, np.nan)), "Box: size"),
        (lambda: Box("abc"), "Box: size"),
        (lambda: Box([[1], [2, 3]]), "Box: size"),
        (lambda: Sphere(-0.1), r"Sphere: radius: .* above 0 \[m\], found -0.1"),
        (lambda: Sphere("0.1"), "Sphere: radius: .* found '0.1'"),
        (lambda: Sphere(True), "Sphere: radius"),
        (lambda: Capsule(0.1, -1), "Capsule: length"),
        (lambda: Cylinder(float("inf"), 1), "Cylinder: radius"),
        (lambda: Plane((0, 0, 0)), "no length"),
        (lambda: Plane((0, 0, 1), np.nan), "Plane: offset"),
    ],
)
def test_impossible_values(make: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()  # type: ignore[operator]


def test_mesh_keeps_its_arrays_to_itself() -> None:
    vertices, faces = Box((1.0, 1.0, 1.0)).triangles()
    mesh = Mesh(vertices, faces)
    vertices[:] = 7.0
    assert mesh.volume == pytest.approx(1.0)
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0, 0] = 1.0


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (np.eye(3), np.zeros((0, 3), int), "no triangles"),
        (np.eye(3), [[0, 1, 2.5]], "whole numbers"),
        (np.eye(3), [[0, 1, 7]], "0 to 2, found 0 to 7"),
        (np.eye(2), [[0, 1, 1]], r"\(V, 3\)"),
        ([[0, 0, 0], [1, 0, 0], [np.nan, 1, 0]], [[0, 1, 2]], "1 of 3 are NaN.* number 2"),
        (np.eye(3), [[0, 1, 1]], "three different corners"),
        ("box", [[0, 1, 2]], r"vertices: expected numbers \(V, 3\)"),
        ([[0.0], [0.0, 1.0]], [[0, 1, 2]], r"vertices: expected numbers \(V, 3\)"),
        (np.eye(3), [[0], [0, 1]], r"faces: expected whole numbers \(F, 3\)"),
    ],
)
def test_impossible_meshes(vertices: object, faces: object, message: str) -> None:
    with pytest.raises(InputError, match=f"Mesh: .*{message}"):
        Mesh(vertices, faces)  # type: ignore[arg-type]


def test_mesh_solid_hull_and_convexity() -> None:
    box = Mesh(*Box((1.0, 2.0, 3.0)).triangles())
    assert box.closed
    assert box.is_convex
    assert len(box.convex_vertices()) == 8
    np.testing.assert_allclose(box.unit_inertia(), Box((1, 2, 3)).unit_inertia())
    inside_out = Mesh(box.vertices, box.faces[:, ::-1])
    assert inside_out.volume == pytest.approx(6.0)
    assert (np.linalg.eigvalsh(inside_out.unit_inertia()) > 0).all()


def test_l_shape_is_not_convex() -> None:
    """Two boxes that share a face's plane and overlap nowhere: volumes known by hand."""
    v, f = Box((2.0, 1.0, 1.0)).triangles()
    w, g = Box((1.0, 1.0, 1.0)).triangles()
    both = Mesh(np.vstack([v, w + np.array([-0.5, 0.0, 1.0])]), np.vstack([f, g + len(v)]))
    assert both.closed
    assert not both.is_convex
    assert both.volume == pytest.approx(3.0)
    assert both.solid_volume == pytest.approx(3.0, rel=0.01)
    assert both.hull.volume == pytest.approx(3.5)
    twice = Mesh(np.vstack([v, v + np.array([0.5, 0.0, 0.0])]), np.vstack([f, f + len(v)]))
    assert twice.volume == pytest.approx(4.0)
    assert twice.solid_volume == pytest.approx(2.5, rel=0.01)  # the overlap counts once


def test_open_mesh_takes_its_hull_and_says_so() -> None:
    vertices, faces = Box((1.0, 2.0, 3.0)).triangles()
    lidless = Mesh(vertices, faces[2:])
    assert not lidless.closed
    with pytest.warns(HalfPhysicsWarning, match="not closed.*convex hull"):
        properties = lidless.mass_properties(density=2.0)
    assert properties.mass == pytest.approx(12.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Mesh(vertices, faces).mass_properties(density=2.0)


def test_a_mesh_that_is_inside_out_is_the_same_solid():
    """As mirrored exports are: points are as deep in it, and its surface is open to none."""
    cube = Mesh(*Box((1.0, 0.8, 0.6)).triangles())
    inverted = Mesh(cube.vertices, cube.faces[:, ::-1])
    points = np.random.default_rng(0).uniform(-0.6, 0.6, size=(200, 3))
    assert cube.outward is cube
    np.testing.assert_array_equal(inverted.depth(points), cube.depth(points))
    assert inverted.depth(points).max() > 0.2
    np.testing.assert_array_equal(inverted.outward.faces, cube.faces)
    open_one = Mesh(cube.vertices, cube.faces[1:, ::-1])
    assert open_one.outward is open_one


def test_a_plane_keeps_a_unit_normal_to_the_last_bit():
    normals = np.random.default_rng(1).normal(size=(200, 3))
    for normal in normals:
        plane = Plane(normal, 0.3)
        assert Plane(plane.normal, plane.offset) == plane


def test_a_mesh_that_was_asked_goes_with_its_last_name():
    """No cycle: worlds of many meshes need no collector."""
    cube = Mesh(*Box((1.0, 0.8, 0.6)).triangles())
    assert cube.depth([[0.0, 0.0, 0.0]]) == pytest.approx(0.3)
    gone = weakref.ref(cube)
    del cube
    assert gone() is None
