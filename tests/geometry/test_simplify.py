"""Fewer triangles: the same solid, closed, within the tolerance."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.simplify import is_manifold, simplified

trimesh = pytest.importorskip("trimesh")


def mesh(made):
    return Mesh(np.asarray(made.vertices), np.asarray(made.faces))


def fine_box():
    box = trimesh.creation.box((1.0, 0.6, 0.4))
    for _ in range(4):
        box = box.subdivide()
    return mesh(box)


def test_flat_faces_need_few_triangles_and_keep_every_corner():
    """3,072 triangles of a box to 300, and it is still the box."""
    box = fine_box()
    assert len(box.faces) == 3072
    fewer = simplified(box, 300, 1e-6)
    assert len(fewer.faces) <= 300
    assert is_manifold(fewer.faces)
    assert fewer.closed
    assert fewer.volume == pytest.approx(0.24, rel=1e-9)
    np.testing.assert_allclose(np.ptp(fewer.vertices, axis=0), (1.0, 0.6, 0.4), atol=1e-9)


def test_a_ring_keeps_its_hole_and_its_shape():
    ring = mesh(trimesh.creation.torus(0.2, 0.05, major_sections=96, minor_sections=48))
    fewer = simplified(ring, 1500, 0.002)
    assert len(fewer.faces) <= 1500
    assert is_manifold(fewer.faces)
    assert trimesh.Trimesh(fewer.vertices, fewer.faces).euler_number == 0
    around = np.hypot(np.linalg.norm(fewer.vertices[:, :2], axis=1) - 0.2, fewer.vertices[:, 2])
    assert np.abs(around - 0.05).max() < 0.002
    assert fewer.volume == pytest.approx(2 * np.pi**2 * 0.2 * 0.05**2, rel=0.03)


def test_the_tolerance_ends_it_first():
    ball = mesh(trimesh.creation.icosphere(4, 0.5))
    fewer = simplified(ball, 4, 0.001)
    assert 100 < len(fewer.faces) < 2000
    assert np.abs(np.linalg.norm(fewer.vertices, axis=1) - 0.5).max() < 0.004


def test_always_the_same_bytes():
    ring = mesh(trimesh.creation.torus(0.2, 0.05, major_sections=48, minor_sections=24))
    a, b = (simplified(ring, 500, 0.01) for _ in range(2))
    assert a.vertices.tobytes() == b.vertices.tobytes()
    assert a.faces.tobytes() == b.faces.tobytes()


def test_manifolds():
    box = trimesh.creation.box((1, 1, 1))
    faces = np.asarray(box.faces)
    assert is_manifold(faces)
    assert not is_manifold(faces[1:])
    turned = faces.copy()
    turned[0] = turned[0, ::-1]
    assert not is_manifold(turned)
    assert not is_manifold(np.concatenate([faces, faces]))
