"""Samples of surfaces: areas and moments of area are those of the shape."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.surface_samples import MOST, WIDEST, joined, pitch_for, surface_samples

#: Sums over samples of round shapes are exact but for rounding; moments of capped ones to 0.1 %.
ROUNDING, ROUND = 1e-12, 1e-3


def moments(samples):
    return np.einsum("i,ij,ik->jk", samples.areas, samples.points, samples.points)


def sphere_moment(r):
    return 4.0 * np.pi * r**4 / 3.0


def tube_moments(r, length):
    side = 2.0 * np.pi * r * length
    return np.array([0.5 * r**2 * side, 0.5 * r**2 * side, side * length**2 / 12.0])


@pytest.mark.parametrize("pitch", [None, 0.02, 0.05])
def test_a_sphere_has_its_true_area_and_moments(pitch):
    samples = surface_samples(hp.Sphere(0.11), pitch)
    assert samples.areas.sum() == pytest.approx(4.0 * np.pi * 0.11**2, rel=ROUNDING)
    assert moments(samples) == pytest.approx(sphere_moment(0.11) * np.eye(3), abs=1e-12)


@pytest.mark.parametrize("pitch", [None, 0.05, 0.2])
def test_a_box_has_its_area_and_moments_with_any_number_of_samples(pitch):
    x, y, z = size = (0.3, 0.2, 0.1)
    samples = surface_samples(hp.Box(size), pitch)
    assert samples.areas.sum() == pytest.approx(2.0 * (x * y + y * z + z * x), rel=ROUNDING)
    top = samples[samples.normals[:, 2] > 0.5]
    assert np.diag(moments(top))[:2] == pytest.approx([y * x**3 / 12.0, x * y**3 / 12.0], rel=1e-9)


def test_cylinder_and_capsule_have_their_areas_and_moments():
    r, length = 0.1, 0.3
    cylinder, capsule = (
        surface_samples(hp.Cylinder(r, length)),
        surface_samples(hp.Capsule(r, length)),
    )
    assert cylinder.areas.sum() == pytest.approx(2.0 * np.pi * r * (r + length), rel=ROUNDING)
    ends = 2.0 * np.pi * r**2
    disc = np.array([0.25 * r**2, 0.25 * r**2, 0.25 * length**2]) * ends
    assert np.diag(moments(cylinder)) == pytest.approx(tube_moments(r, length) + disc, rel=ROUND)
    assert capsule.areas.sum() == pytest.approx(2.0 * np.pi * r * (2.0 * r + length), rel=ROUNDING)
    across = tube_moments(r, length)[0] + sphere_moment(r)
    assert moments(capsule)[0, 0] == pytest.approx(across, rel=ROUND)


@pytest.mark.parametrize(
    "mesh",
    [
        trimesh.creation.box((0.3, 0.2, 0.1)),
        trimesh.creation.icosphere(4, 0.1),
        trimesh.creation.cylinder(0.1, 0.3, sections=40),
        trimesh.creation.box((1.0, 0.01, 0.01)),
    ],
    ids=["box", "fine sphere", "cylinder", "rod"],
)
def test_a_mesh_has_its_area_and_moments_to_a_hundredth(mesh):
    shape = Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces, dtype=np.int32))
    samples = surface_samples(shape)
    assert samples.areas.sum() == pytest.approx(mesh.area, rel=1e-9)
    fine = surface_samples(shape, pitch_for(shape) / 8.0)
    assert np.diag(moments(samples)) == pytest.approx(np.diag(moments(fine)), rel=0.01)


@pytest.mark.parametrize(
    "shape", [hp.Sphere(0.2), hp.Box((0.5, 0.4, 0.3)), hp.Cylinder(0.2, 0.5), hp.Capsule(0.2, 0.5)]
)
def test_normals_are_outward_and_areas_close_the_surface(shape):
    samples = surface_samples(shape)
    assert np.linalg.norm(samples.normals, axis=1) == pytest.approx(1.0)
    assert np.einsum("ij,ij->i", samples.points, samples.normals).min() > 0.0
    assert samples.areas @ samples.normals == pytest.approx(0.0, abs=1e-12)
    assert shape.depth(samples.points - 1e-6 * samples.normals).min() > 0.0
    assert shape.depth(samples.points + 1e-6 * samples.normals).max() == 0.0


def test_a_ball_on_a_layer_of_these_samples_is_pressed_as_it_should():
    """F = pi k R d^2 (Winkler, projected areas), 2 cm into a layer of 1e5 Pa/m, to 1 %."""
    r, d, k = 0.11, 0.02, 1e5
    samples = surface_samples(hp.Sphere(r))
    depth = np.maximum(d - (samples.points[:, 2] + r), 0.0)
    force = k * (samples.areas * -samples.normals[:, 2]) @ depth
    # The cap's projected paraboloid: exact for a sphere up to d/(3 R).
    assert force == pytest.approx(np.pi * k * d**2 * (r - d / 3.0), rel=0.01)


def test_large_things_have_bounded_numbers_of_samples_and_small_ones_fine_samples():
    assert len(surface_samples(hp.Box((20.0, 20.0, 3.0)))) < 1.3 * MOST
    assert pitch_for(hp.Sphere(0.02)) < 0.1 * WIDEST * 2.0
    assert pitch_for(hp.Box((0.6, 0.5, 0.3))) == WIDEST


def test_samples_move_and_join():
    ball = surface_samples(hp.Sphere(0.1), 0.05)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    moved = ball.moved(turn, np.array([1.0, 0.0, 0.0]))
    assert moved.points[3] == pytest.approx(turn @ ball.points[3] + [1.0, 0.0, 0.0])
    both = joined([ball, moved])
    assert len(both) == 2 * len(ball)
    assert len(joined([])) == 0


def test_a_plane_has_no_samples():
    with pytest.raises(InputError, match="found a Plane"):
        surface_samples(hp.Plane())
