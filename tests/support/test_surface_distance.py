"""Signed distances and normals of every shape, against its triangles and its own depth."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.support.surface_distance import surface_distance

SHAPES = [
    hp.Plane((0.0, 0.6, 0.8), 0.1),
    hp.Box((0.4, 0.6, 0.8)),
    hp.Sphere(0.3),
    hp.Capsule(0.2, 0.5),
    hp.Cylinder(0.3, 0.6),
    "mesh",  # made in the test: trees of the core do not outlive it
]


def made(shape):
    return hp.Mesh(*hp.Box((0.4, 0.6, 0.8)).triangles()) if shape == "mesh" else shape


@pytest.mark.parametrize(
    "shape", SHAPES, ids=lambda shape: shape if shape == "mesh" else type(shape).__name__
)
def test_distances_lead_to_the_surface(shape):
    shape = made(shape)
    points = np.random.default_rng(0).uniform(-0.6, 0.6, (2000, 3))
    distance, normal = surface_distance(shape, points, points)
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1.0)
    assert np.maximum(-distance, 0.0) == pytest.approx(shape.depth(points), abs=1e-12)
    near = points - distance[:, None] * normal
    # Normals of meshes are rounded over a millimetre at edges.
    room = 2e-3 if isinstance(shape, hp.Mesh) else 1e-9
    again, _ = surface_distance(shape, near, near)
    assert np.abs(again).max() < room
    # No point of the surface is nearer.
    beyond, _ = surface_distance(shape, points + 1e-3 * normal, points)
    assert beyond == pytest.approx(distance + 1e-3, abs=room)


def test_a_floor_of_one_layer_has_the_side_of_the_body():
    floor = hp.Mesh(
        np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]),
        np.array([[0, 2, 1], [0, 3, 2]]),
    )
    points = np.array([[0.1, 0.2, 0.02], [0.1, 0.2, -0.02]])
    distance, normal = surface_distance(floor, points, np.array([[0.1, 0.2, 0.1]] * 2))
    assert distance == pytest.approx([0.02, -0.02])
    assert normal == pytest.approx(np.array([[0.0, 0, 1]] * 2), abs=1e-12)
    distance, normal = surface_distance(floor, points, np.array([[0.1, 0.2, -0.1]] * 2))
    assert distance == pytest.approx([-0.02, 0.02])
    assert normal == pytest.approx(np.array([[0.0, 0, -1]] * 2), abs=1e-12)


def test_middles_have_a_normal():
    for shape in map(made, SHAPES):
        distance, normal = surface_distance(shape, np.zeros((1, 3)), np.zeros((1, 3)))
        assert np.isfinite(distance).all()
        assert np.linalg.norm(normal) == pytest.approx(1.0)
