"""Normals of meshes in scene files."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.geometry.shapes import Box, Cylinder, Sphere
from halfphysics.writers.normals import creased, vertex_normals


def same_triangles(a, b):
    np.testing.assert_array_equal(a[0][a[1]], b[0][b[1]])


def test_a_box_has_six_sides():
    mesh = Box((1.0, 2.0, 3.0)).triangles()
    vertices, faces, normals = creased(*mesh, 50.0)
    assert len(vertices) == 24
    same_triangles(mesh, (vertices, faces))
    corners = vertices[faces]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    np.testing.assert_allclose(normals[faces], np.repeat(flat[:, None], 3, axis=1), atol=1e-12)


def test_a_sphere_is_smooth():
    mesh = Sphere(0.5).triangles()
    vertices, faces, normals = creased(*mesh, 50.0)
    assert len(vertices) == len(mesh[0])
    same_triangles(mesh, (vertices, faces))
    assert np.abs(normals - vertices / 0.5).max() < 0.01  # of 32 segments
    order = np.lexsort(vertices.T)
    smooth = vertex_normals(*mesh)[np.lexsort(mesh[0].T)]
    np.testing.assert_allclose(normals[order], smooth, atol=1e-12)


def test_a_cylinder_is_smooth_around_and_sharp_at_its_rims():
    mesh = Cylinder(0.5, 2.0).triangles()
    vertices, _, normals = creased(*mesh, 50.0)
    level = np.abs(normals[:, 2])
    assert ((level < 1e-12) | (level > 1.0 - 1e-12)).all()
    round_ = vertices[level < 0.5]
    np.testing.assert_allclose(normals[level < 0.5][:, :2], round_[:, :2] / 0.5, atol=1e-12)


@pytest.mark.parametrize("degrees", [0.0, 180.0])
def test_the_extremes(degrees):
    """No smooth edge: separate corners; all edges smooth: the mesh unchanged."""
    mesh = Box((1.0, 1.0, 1.0)).triangles()
    vertices, faces, _ = creased(*mesh, degrees)
    assert len(vertices) == (36 if degrees == 0.0 else 8)
    same_triangles(mesh, (vertices, faces))


def test_slivers_and_lonely_vertices_have_a_normal():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 5, 5]])
    faces = np.array([[0, 1, 2], [0, 0, 1]])
    for normals in (vertex_normals(vertices, faces), creased(vertices, faces, 50.0)[2]):
        np.testing.assert_array_equal(np.linalg.norm(normals, axis=1), 1.0)


def test_a_fan_of_many_faces():
    """One vertex of 20,000 faces: memory does not grow with the square."""
    angle = np.linspace(0.0, 2 * np.pi, 20_000, endpoint=False)
    rim = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    vertices = np.concatenate([[[0.0, 0.0, 1.0]], rim])
    k = np.arange(20_000)
    faces = np.stack([0 * k, 1 + k, 1 + (k + 1) % 20_000], axis=1)
    out, _, normals = creased(vertices, faces, 50.0)
    assert len(out) == len(vertices)
    apex = np.argmax(out[:, 2])
    np.testing.assert_allclose(normals[apex], [0.0, 0.0, 1.0], atol=1e-12)
