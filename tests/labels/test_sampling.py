"""The points that represent primitives: on the surface, dense, closed, the same each time."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.geometry.mesh_queries import is_closed
from halfphysics.geometry.mesh_solids import solid_moments
from halfphysics.labels.item_solids import item_solids
from halfphysics.labels.sampling import MOST, covered, surface_of
from halfphysics.results.result import ObjectTrack
from support.references.mesh_queries import closest_reference

SHAPES = {
    "box": hp.Box((0.3, 0.07, 0.12)),
    "ball": hp.Sphere(0.11),
    "capsule": hp.Capsule(0.03, 0.2),
    "cylinder": hp.Cylinder(0.05, 0.2),
}


@pytest.mark.parametrize("name", SHAPES)
def test_points_cover_the_surface(name):
    shape = SHAPES[name]
    vertices, faces = covered(shape)
    assert is_closed(faces, len(vertices))
    # Outward, and of nearly the volume: chords of a centimetre cut little off.
    volume = solid_moments(vertices, faces)[0]
    assert 0.97 * shape.volume < volume <= shape.volume * (1.0 + 1e-12)
    # On the surface: a hair farther in is inside, a hair farther out is not.
    assert (shape.depth(vertices * (1.0 - 1e-6)) > 0.0).all()
    assert (shape.depth(vertices * (1.0 + 1e-6)) <= 1e-12).all()
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    assert length.max() < 0.0151  # a centimetre, across a square
    # So every point of the surface is near a sample.
    centre = vertices[faces].mean(axis=1)
    apart = np.linalg.norm(centre[:, None] - vertices[faces], axis=2).min(axis=1)
    assert apart.max() < 0.01


def test_large_ones_are_covered_more_thinly():
    for shape in (hp.Box((2.0, 1.0, 0.8)), hp.Sphere(0.7), hp.Cylinder(0.5, 1.5)):
        vertices, _ = covered(shape)
        assert 0.5 * MOST < len(vertices) <= 1.05 * MOST


def test_the_same_each_time():
    covered.cache_clear()
    first = covered(hp.Box((0.3, 0.2, 0.1)))
    covered.cache_clear()
    again = covered(hp.Box((0.3, 0.2, 0.1)))
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    with pytest.raises(ValueError, match="read-only"):
        first[0][0] = 0.0


def test_a_mesh_keeps_its_own_vertices_where_pieces_touch_for_it():
    vertices, faces = hp.Box((0.2, 0.2, 0.2)).triangles()
    beside = vertices + np.array([0.3, 0.0, 0.0])
    shelf = hp.Mesh(np.concatenate([vertices, beside]), np.concatenate([faces, faces + 8]))
    scene = hp.Scene()
    pieces = [hp.Mesh(vertices * 0.9, faces), hp.Mesh(beside, faces)]
    with pytest.warns(hp.HalfPhysicsWarning):
        scene.add_object("shelf", shelf, mass=1.0, pieces=pieces)
    track = ObjectTrack(position=np.zeros((1, 3)), quaternion=[[1, 0, 0, 0]])
    (item,) = item_solids(scene, {"shelf": track})
    surface = surface_of(scene, item)
    assert np.array_equal(surface.vertices, shelf.vertices)
    assert np.array_equal(surface.faces, shelf.faces)
    # The mesh protrudes from the pieces by at most this: its corner, of the smaller one.
    assert surface.off == pytest.approx(
        closest_reference(shelf.vertices, *pieces[0].triangles())[0][:8].min(), abs=1e-9
    )
