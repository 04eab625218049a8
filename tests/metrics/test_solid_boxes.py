"""Bounds of distances by boxes, against distances of points in them."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere
from halfphysics.metrics.solid_boxes import distance_bound
from halfphysics.metrics.surface_gaps import signed_distance

SHAPES = (
    Plane((0.6, 0.0, 0.8), 0.1),
    Box((0.4, 0.6, 1.0)),
    Sphere(0.3),
    Capsule(0.2, 0.5),
    Cylinder(0.3, 0.8),
    Mesh(*Box((0.4, 0.6, 1.0)).triangles()),
)
#: What the shape's own box leaves of the distance of a small box that is this far away [m].
FAR, MOST_LOST = 5.0, 0.8


def _boxes(rng, count, reach):
    """Middles and half sizes (count, 1, 3) of boxes, and 40 points in each."""
    middle = rng.uniform(-reach, reach, (count, 1, 3))
    half = rng.uniform(0.0, 0.3, (count, 1, 3))
    points = middle + half * rng.uniform(-1.0, 1.0, (count, 40, 3))
    return middle, half, points


def _of_points(shape, points, places, turns):
    return np.array(
        [
            signed_distance(shape, (its - place) @ turn)[0].min()
            for its, place, turn in zip(points, places, turns, strict=True)
        ]
    )


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
def test_no_point_of_a_box_is_nearer(shape):
    rng = np.random.default_rng(3)
    places = rng.uniform(-0.5, 0.5, (300, 3))
    turns = rot.to_matrix(rot.exp(rng.normal(size=(300, 3))))
    middle, half, points = _boxes(rng, 300, 1.2)
    bound = distance_bound(shape, places, turns, middle, half)[:, 0]
    true = _of_points(shape, points, places, turns)
    assert (bound <= true + 1e-12).all()
    assert (bound[true <= 0.0] == -np.inf).all()
    assert 0.05 < np.isfinite(bound).mean() < 0.95, "of both kinds there are enough"


@pytest.mark.parametrize("shape", SHAPES[1:], ids=lambda s: type(s).__name__)
def test_what_is_far_is_known_to_be(shape):
    rng = np.random.default_rng(4)
    away = rng.normal(size=(50, 1, 3))
    middle = FAR * away / np.linalg.norm(away, axis=-1, keepdims=True)
    one = np.zeros((1, 3)), np.eye(3)[None]
    bound = distance_bound(shape, *one, middle, np.zeros_like(middle))[:, 0]
    true = signed_distance(shape, middle[:, 0])[0]
    assert (bound <= true + 1e-12).all()
    assert (bound > true - MOST_LOST).all()


def test_of_another_kind_nothing_is_known():
    one = np.zeros((1, 3)), np.eye(3)[None], np.zeros((1, 1, 3)), np.ones((1, 1, 3))
    with pytest.raises(TypeError, match="shape: found str"):
        distance_bound("a box", *one)
