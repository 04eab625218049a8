"""Penetration against closed forms, and against brute force on small random meshes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics import metrics
from halfphysics.geometry.shapes import Box, Capsule, Mesh, Plane, Shape, Sphere
from halfphysics.scene.scene import Scene
from support.point_bodies import Cloud, Drift
from support.references.mesh_queries import closest_reference, winding_reference

STILL = Drift(np.zeros((1, 3)))


def _report(points: np.ndarray, shape: Shape) -> metrics.PenetrationReport:
    scene = Scene()
    scene.add_static("thing", shape)
    return metrics.penetration(STILL, Cloud(points), scene)


@pytest.mark.parametrize("mesh", [False, True])
def test_a_sphere_in_a_box(mesh: bool) -> None:
    """The points nearest the middle are as deep as the box is thick there."""
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(5000, 3))
    directions[:6] = np.concatenate([np.eye(3), -np.eye(3)])
    points = 0.3 * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    box = Box((1.0, 1.2, 1.4))
    report = _report(points, Mesh(*box.triangles()) if mesh else box)
    depth = (0.5 * np.array(box.size) - np.abs(points)).min(axis=1)
    assert report.rate_percent == 100.0
    assert report.depth_max_mm == pytest.approx(1000.0 * depth.max(), abs=1e-9)
    assert report.depth_penetrating_mm == pytest.approx(1000.0 * depth.mean(), abs=1e-9)


@given(st.floats(-0.34, 0.34))
@settings(max_examples=30, deadline=None)
def test_a_capsule_through_a_plane(height: float) -> None:
    """A capsule along z, radius 0.1 m, 0.5 m long without caps: depth, and share of its points."""
    points = Capsule(0.1, 0.5).triangles()[0] + [0.0, 0.0, height]
    report = _report(points, Plane())
    assert report.depth_max_mm == pytest.approx(1000.0 * (0.35 - height), abs=1e-9)
    assert report.share[0] == pytest.approx(100.0 * (points[:, 2] < 0.0).mean())


@given(st.integers(0, 10_000), st.sampled_from(["closed", "open", "soup", "several"]))
@settings(max_examples=40, deadline=None)
def test_small_meshes_as_by_brute_force(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    vertices, faces = Sphere(0.5).triangles()
    vertices = vertices * rng.uniform(0.5, 1.5, 3)
    if kind == "open":
        faces = faces[rng.random(len(faces)) < 0.8]
    elif kind == "soup":
        vertices = rng.normal(scale=0.4, size=(90, 3))
        faces = np.arange(90).reshape(-1, 3)
    elif kind == "several":
        faces = np.concatenate([faces, faces + len(vertices)])
        vertices = np.concatenate([vertices, 0.6 * vertices + rng.uniform(-0.5, 0.5, 3)])
    points = rng.uniform(-0.7, 0.7, (300, 3))
    used = vertices[np.unique(faces)]
    inside = winding_reference(points, vertices, faces) > 0.5
    inside &= ((points >= used.min(axis=0)) & (points <= used.max(axis=0))).all(axis=1)
    depth = np.where(inside, closest_reference(points, vertices, faces)[0], 0.0)
    report = _report(points, Mesh(vertices, faces))
    assert report.vertices_inside == inside.sum()
    assert report.depth_max_mm == pytest.approx(1000.0 * depth.max(), abs=1e-6)  # 1e-9 m
    if inside.any():
        assert report.depth_penetrating_mm == pytest.approx(1000.0 * depth[inside].mean(), abs=1e-6)
