"""Volume, centre and inertia of labelled parts, against closed forms and exact mesh integrals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from halfphysics.base import rotations
from halfphysics.body.mass import PITCH, close_holes, solid_parts
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.geometry.mesh_queries import is_closed
from halfphysics.geometry.mesh_solids import solid_moments

Array = NDArray[np.float64]
Mesh = tuple[Array, NDArray[np.int64]]


def sphere(radius: float, n: int = 32) -> Mesh:
    """A ball about the origin, outward, with 2 n^2 triangles."""
    theta = np.linspace(0.0, np.pi, n + 1)[1:-1, None]
    phi = np.linspace(0.0, 2.0 * np.pi, 2 * n, endpoint=False)[None]
    ring = np.stack(np.broadcast_arrays(np.cos(theta), np.sin(theta) * np.cos(phi)), axis=-1)
    third = np.sin(theta) * np.sin(phi)
    middle = np.concatenate([ring, third[..., None]], axis=-1).reshape(-1, 3)
    vertices = radius * np.concatenate([middle, [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]])
    at = np.arange(2 * n * (n - 1)).reshape(n - 1, 2 * n)
    a, b = at[:-1], at[1:]
    a1, b1 = np.roll(a, -1, axis=1), np.roll(b, -1, axis=1)
    top, bottom = np.full(2 * n, len(middle)), np.full(2 * n, len(middle) + 1)
    faces = np.concatenate(
        [
            np.stack([a, b, b1], axis=-1).reshape(-1, 3),
            np.stack([a, b1, a1], axis=-1).reshape(-1, 3),
            np.stack([top, at[0], np.roll(at[0], -1)], axis=-1),
            np.stack([bottom, np.roll(at[-1], -1), at[-1]], axis=-1),
        ]
    )
    return vertices, faces


def together(*meshes: Mesh) -> Mesh:
    shift = np.cumsum([0] + [len(v) for v, _ in meshes])
    faces = [f + s for (_, f), s in zip(meshes, shift, strict=False)]
    return np.concatenate([v for v, _ in meshes]), np.concatenate(faces)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31))
def test_one_part_has_the_exact_moments_of_the_mesh(seed: int) -> None:
    rng = np.random.default_rng(seed)
    vertices, faces = sphere(1.0, 20)
    vertices = vertices * rng.uniform(0.08, 0.25, 3) + 0.02 * np.sin(9.0 * vertices[:, [1, 2, 0]])
    vertices = vertices @ rotations.rotvec_to_matrix(rng.normal(size=3)).T + rng.normal(size=3)
    volume, centre, inertia = solid_moments(vertices, faces)
    solid = solid_parts(vertices, faces, np.zeros(len(vertices), dtype=int), 1)
    assert solid.total == pytest.approx(volume, rel=1e-12)
    assert solid.volume[0] == pytest.approx(volume, rel=1e-12)
    # Thirty rays across: the rule is of second order and the surface smooth.
    np.testing.assert_allclose(solid.centroid[0], centre, atol=0.02 * PITCH)
    np.testing.assert_allclose(solid.moment[0], inertia, atol=3e-3 * np.trace(inertia))


def test_two_halves_of_a_ball() -> None:
    radius = 0.12
    vertices, faces = sphere(radius)
    labels = np.where(vertices[:, 1] > 0.0, 2, 0)
    solid = solid_parts(vertices, faces, labels, 3)
    half = solid.total / 2.0
    # A ring of vertices lies on the cut and belongs to one side: half a triangle, 1/40 radian.
    np.testing.assert_allclose(solid.volume, [half, 0.0, half], rtol=0.06)
    assert solid.centroid[2, 1] == pytest.approx(3.0 / 8.0 * radius, rel=0.06)
    np.testing.assert_array_equal(solid.centroid[1], 0.0)
    np.testing.assert_array_equal(solid.moment[1], 0.0)
    assert solid.volume.sum() == pytest.approx(solid_moments(vertices, faces)[0], rel=1e-12)


def test_dense_rays_agree_with_sparse_ones() -> None:
    vertices, faces = sphere(0.07)
    labels = np.where(vertices[:, 0] > 0.01, 1, 0)
    sparse, dense = (solid_parts(vertices, faces, labels, 2, fine) for fine in ((), (0, 1)))
    np.testing.assert_allclose(sparse.volume, dense.volume, rtol=0.01)
    np.testing.assert_allclose(sparse.centroid, dense.centroid, atol=0.1 * PITCH)


def test_a_finger_tip_is_solid() -> None:
    # Two rays across at the coarse pitch, six at the dense one: the centre is exact to 0.1 mm.
    vertices, faces = sphere(1.0)
    vertices = vertices * [0.02, 0.006, 0.006] + [0.7, 0.1, 0.0]
    solid = solid_parts(vertices, faces, np.zeros(len(vertices), dtype=int), 1, [0])
    volume, centre, inertia = solid_moments(vertices, faces)
    assert solid.total == pytest.approx(volume, rel=1e-12)
    np.testing.assert_allclose(solid.centroid[0], centre, atol=1e-4)
    # Six rays across are accurate to 4 %; samples of boxes twice too big would add 14 %.
    assert solid.moment[0, 0, 0] == pytest.approx(inertia[0, 0], rel=0.05)
    np.testing.assert_allclose(solid.moment[0], inertia, atol=0.01 * np.trace(inertia))


def test_symmetric_skins_give_symmetric_parts() -> None:
    vertices, faces = sphere(0.1)
    vertices[:, 1] += 0.3 * vertices[:, 2] ** 2 / 0.1
    labels = np.where(vertices[:, 0] > 1e-9, 1, np.where(vertices[:, 0] < -1e-9, 2, 0))
    solid = solid_parts(vertices, faces, labels, 3)
    assert solid.volume[1] == pytest.approx(solid.volume[2], rel=1e-9)
    # The triangles' diagonals are chiral: half a turn about y maps the skin onto itself.
    turned = solid.centroid[2] * [-1, 1, -1]
    np.testing.assert_allclose(solid.centroid[1], turned, rtol=0, atol=1e-12)


def test_inside_out_is_mended() -> None:
    vertices, faces = sphere(0.1)
    labels = np.zeros(len(vertices), dtype=int)
    right, wrong = (solid_parts(vertices, f, labels, 1) for f in (faces, faces[:, ::-1]))
    assert wrong.total == pytest.approx(right.total, rel=1e-12)
    np.testing.assert_allclose(wrong.moment, right.moment, rtol=1e-9, atol=1e-12)


def test_holes_are_capped_flat() -> None:
    vertices, faces = sphere(0.1)
    centres = vertices[faces].mean(axis=1)
    open_faces = faces[(centres[:, 0] < 0.08) & (centres[:, 2] > -0.09)]
    assert not is_closed(open_faces, len(vertices))
    corners, closed = close_holes(vertices, open_faces)
    assert is_closed(closed, len(corners))
    assert len(corners) == len(vertices) + 2, "one cap a hole"
    exact = solid_moments(corners, closed)
    solid = solid_parts(vertices, open_faces, np.zeros(len(vertices), dtype=int), 1)
    assert solid.total == pytest.approx(exact[0], rel=1e-12)
    np.testing.assert_allclose(solid.centroid[0], exact[1], atol=0.05 * PITCH)
    whole = solid_moments(vertices, faces)[0]
    assert 0.9 * whole < solid.total < whole


def test_a_closed_surface_is_returned_as_it_is() -> None:
    vertices, faces = sphere(0.1, 6)
    corners, closed = close_holes(vertices, faces)
    np.testing.assert_array_equal(corners, vertices)
    np.testing.assert_array_equal(closed, faces)


def test_pieces_keep_to_themselves() -> None:
    """An eye in its socket removes nothing from the head around it; an inner shell has no mass."""
    head, eye = sphere(0.1), sphere(0.012, 12)
    shell = (sphere(0.03, 12)[0], sphere(0.03, 12)[1][:, ::-1])
    vertices, faces = together(head, (eye[0] + [0.05, 0, 0], eye[1]), shell)
    labels = np.repeat([0, 1, 0], [len(head[0]), len(eye[0]), len(shell[0])])
    solid = solid_parts(vertices, faces, labels, 2, [1])
    assert solid.volume[0] == pytest.approx(solid_moments(*head)[0], rel=1e-12)
    assert solid.volume[1] == pytest.approx(solid_moments(*eye)[0], rel=1e-12)
    np.testing.assert_allclose(solid.centroid[1], [0.05, 0, 0], atol=1e-4)


def test_a_tangled_skin_warns_and_counts_what_is_inside_once() -> None:
    vertices, faces = sphere(0.1)
    once = solid_moments(vertices, faces)[0]
    twice = np.concatenate([faces, faces])
    with pytest.warns(HalfPhysicsWarning, match="tangled"):
        solid = solid_parts(vertices, twice, np.zeros(len(vertices), dtype=int), 1)
    assert solid.total == pytest.approx(once, rel=2e-3)  # by rays alone: 33 across


@pytest.mark.parametrize("faces", [np.zeros((0, 3), dtype=int), [[0, 1, 2], [0, 2, 1]]])
def test_no_volume_is_an_error(faces: Array) -> None:
    with pytest.raises(InputError, match="encloses no volume"):
        solid_parts(np.eye(3), faces, np.zeros(3, dtype=int), 1)


def test_same_input_same_bytes() -> None:
    vertices, faces = sphere(0.1)
    labels = (np.arange(len(vertices)) % 5).astype(int)
    a, b = (solid_parts(vertices, faces, labels, 5, [1]) for _ in range(2))
    for x, y in zip(vars(a).values(), vars(b).values(), strict=True):
        assert np.asarray(x).tobytes() == np.asarray(y).tobytes()
