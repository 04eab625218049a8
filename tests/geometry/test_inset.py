"""Inset: planes move by the thickness, the result is inside, thin parts keep a hard core."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.geometry.inset import SHARE, inset, plane_offsets
from halfphysics.geometry.mesh import Mesh

#: Pushing away from near sides stops within this share of the thickness, and the middle of a wall
#: is found to this share of it.
NEAR, MIDDLE = 0.004, 0.05


def mesh_of(made):
    return Mesh(np.asarray(made.vertices), np.asarray(made.faces, dtype=np.int32))


def box(size, cuts=0):
    made = trimesh.creation.box(size)
    for _ in range(cuts):
        made = made.subdivide()
    return mesh_of(made)


@pytest.mark.parametrize("cuts", [0, 2])
@settings(max_examples=10, deadline=None)
@given(size=st.tuples(*[st.floats(0.5, 2.0)] * 3), t=st.floats(0.01, 0.2))
def test_the_planes_of_a_box_move_by_the_thickness(cuts, size, t):
    mesh = box(size, cuts)
    made = inset(mesh.vertices, mesh.faces, t)
    # Cut twice, a side has vertices a quarter of its height below the top, which stay at their
    # height: a top that comes down to them pushes them down to within NEAR.
    exact = cuts == 0 or 4.0 * t < min(size)
    share = 1e-9 if exact else NEAR
    found = np.abs(made.vertices).max(axis=0)
    assert found == pytest.approx(0.5 * np.array(size) - t, rel=1e-9, abs=share * t)
    assert made.thickness == pytest.approx(t, rel=share)


def test_the_planes_of_any_convex_solid_move_by_the_thickness():
    """Every vertex is where the planes of its faces have moved: three of them decide a corner."""
    rng = np.random.default_rng(3)
    mesh = mesh_of(trimesh.convex.convex_hull(rng.normal(size=(12, 3))))
    offsets = plane_offsets(mesh.vertices, mesh.faces)
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    count = np.bincount(mesh.faces.reshape(-1), minlength=len(mesh.vertices))
    for vertex in np.flatnonzero(count == 3):
        faces = (mesh.faces == vertex).any(axis=1)
        assert normal[faces] @ offsets[vertex] == pytest.approx(-1.0, abs=0.05)


@pytest.mark.parametrize(
    ("mesh", "t"),
    [
        (mesh_of(trimesh.creation.icosphere(2, 0.3)), 0.12),
        (mesh_of(trimesh.creation.cylinder(0.2, 0.3, sections=24)), 0.05),
        (mesh_of(trimesh.creation.torus(0.4, 0.1, major_sections=24, minor_sections=12)), 0.03),
        (mesh_of(trimesh.creation.capsule(0.5, 0.1, count=(12, 12))), 0.2),
    ],
    ids=["sphere", "cylinder", "torus", "thin capsule"],
)
def test_the_frame_is_inside_and_as_deep_as_it_says(mesh, t):
    made = inset(mesh.vertices, mesh.faces, t)
    assert mesh.query.inside(made.vertices).all()
    far = mesh.query.closest(made.vertices)[0]
    assert (made.thickness <= far + 1e-12).all()
    assert (made.thickness <= t * (1.0 + 1e-9)).all()
    assert (made.thickness > 0.3 * min(t, 0.1)).all()


def test_a_thin_plate_keeps_a_tenth_of_itself_hard():
    mesh = box((1.0, 1.0, 0.1), 3)
    made = inset(mesh.vertices, mesh.faces, 0.12)
    assert made.thickness == pytest.approx(SHARE * 0.1, rel=MIDDLE)
    assert np.abs(made.vertices[:, 2]).max() == pytest.approx(0.005, abs=MIDDLE * 0.1)


def test_edges_rounder_than_the_layer_do_not_stand_in_it():
    """A box with edges rounded at 3 cm under a layer of 12 cm: the frame is that of a sharp box."""
    ball = trimesh.creation.icosphere(1, 0.03).vertices
    corners = np.stack(np.meshgrid([-0.47, 0.47], [-0.47, 0.47], [-0.37, 0.37]), -1).reshape(-1, 3)
    mesh = mesh_of(trimesh.convex.convex_hull((corners[:, None] + ball).reshape(-1, 3)))
    made = inset(mesh.vertices, mesh.faces, 0.12)
    extent = np.abs(made.vertices).max(axis=0)
    assert extent == pytest.approx([0.38, 0.38, 0.28], abs=NEAR * 0.12)
    assert made.thickness == pytest.approx(0.12, rel=NEAR)


def test_an_open_sheet_moves_down_by_the_thickness():
    grid = np.stack(np.meshgrid(np.arange(4.0), np.arange(4.0)), axis=-1).reshape(-1, 2) / 4
    vertices = np.column_stack([grid, np.zeros(16)])
    corner = np.array([i + 4 * j for j in range(3) for i in range(3)])
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + 5], 1),
            np.stack([corner, corner + 5, corner + 4], 1),
        ]
    ).astype(np.int32)
    made = inset(vertices, faces, 0.1)
    assert made.vertices == pytest.approx(vertices - [0.0, 0.0, 0.1], abs=1e-12)
    assert made.thickness == pytest.approx(0.1, rel=1e-9)


def test_the_thickness_may_differ_from_vertex_to_vertex():
    mesh = mesh_of(trimesh.creation.icosphere(3, 0.3))
    wanted = np.where(mesh.vertices[:, 2] > 0.0, 0.05, 0.02)
    made = inset(mesh.vertices, mesh.faces, wanted)
    assert made.thickness == pytest.approx(wanted, rel=0.02)
