"""Sharp edges of shapes whose edges are known."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.geometry.shapes import Box, Cylinder, Sphere
from halfphysics.render.creases import folds, split


def normals(vertices, faces):
    """Area-weighted normals of the vertices, as a browser computes them."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    out = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(out, faces[:, k], np.cross(b - a, c - a))
    return out / np.linalg.norm(out, axis=1, keepdims=True)


def test_a_box_has_twelve_right_angles_and_six_diagonals():
    found = folds(*Box((1.0, 2.0, 3.0)).triangles())
    assert len(found.points) == 8
    assert (np.abs(found.bend) < 1e-12).sum() == 12
    assert (found.bend > 1.0 - 1e-12).sum() == 6
    assert len(found.lone) == 0


def test_the_faces_of_a_split_box_are_shaded_flat():
    vertices, faces = split(*Box((1.0, 2.0, 3.0)).triangles(), 50.0)
    assert len(vertices) == 24
    own = normals(vertices, faces)
    np.testing.assert_allclose(np.abs(own).max(axis=1), 1.0, atol=1e-12)
    assert len(split(*Box((1.0, 2.0, 3.0)).triangles(), 120.0)[0]) == 8


def test_a_cylinder_is_round_with_sharp_rims():
    vertices, faces = split(*Cylinder(0.5, 2.0).triangles(), 50.0)
    own = normals(vertices, faces)
    level = np.abs(own[:, 2]) < 1e-9
    assert (level | (np.abs(own[:, 2]) > 1.0 - 1e-9)).all()
    outwards = vertices[level] * [1.0, 1.0, 0.0] / 0.5
    assert np.einsum("ij,ij->i", outwards, own[level]).min() > 0.99


def test_a_sphere_stays_whole():
    ball = Sphere(0.3).triangles()
    vertices, faces = split(*ball, 50.0)
    assert len(vertices) == len(ball[0])
    assert len(faces) == len(ball[1])


def test_open_borders_are_found_and_copies_of_vertices_are_one():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    found = folds(square, np.array([[0, 1, 2], [3, 4, 5]]))
    assert len(found.points) == 4
    assert len(found.lone) == 4
    assert found.bend == pytest.approx([1.0])
