"""A recorded thing: distances from its surface in its own frame."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.adaptation.thing import Thing
from halfphysics.base import rotations as rot
from halfphysics.results.result import ObjectTrack

ROUNDING = 1e-12


@pytest.fixture
def box():
    scene = hp.Scene()
    scene.add_object("box", hp.Box((0.2, 0.4, 0.6)), mass=1.0, position=(0.0, 0.0, 1.0))
    rng = np.random.default_rng(3)
    turn = rot.normalize(rng.normal(size=(5, 4)))
    return Thing.of(
        scene.objects["box"], ObjectTrack(position=rng.normal(size=(5, 3)), quaternion=turn)
    )


def test_points_are_seen_from_it(box):
    own = np.random.default_rng(0).normal(size=(7, 3))
    world = box.position[:, None] + own @ np.swapaxes(box.turn, 1, 2)
    assert np.abs(box.seen(world) - own).max() < ROUNDING


def test_distances_are_a_box_s_own(box):
    points = np.random.default_rng(1).uniform(-0.6, 0.6, (500, 3))
    off = np.abs(points) - [0.1, 0.2, 0.3]
    outside = np.linalg.norm(np.maximum(off, 0.0), axis=1)
    assert np.abs(box.gaps(points) - outside - np.minimum(off.max(axis=1), 0.0)).max() < ROUNDING


def test_normals_point_out(box):
    vertices, faces = box._triangles
    middles = vertices[faces].mean(axis=1)
    assert np.all(np.einsum("fi,fi->f", box.normals, middles) > 0.0)
    assert np.abs(np.linalg.norm(box.normals, axis=1) - 1.0).max() < ROUNDING


def test_the_centre_is_that_of_its_mass(box):
    assert np.abs(box.centre - box.position).max() < ROUNDING
