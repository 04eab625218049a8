"""A recorded thing: distances from its surface in its own frame."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.adaptation.thing import Thing
from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
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


def test_quaternions_of_any_length_are_rotations(box):
    """Data sets and trackers round them, or do not normalize at all."""
    length = np.array([0.5, 2.0, 1.0, 1e-3, 7.0])[:, None]
    track = ObjectTrack(position=box.position, quaternion=length * box.quaternion)
    again = Thing.of(box.item, track)
    assert np.abs(again.quaternion - box.quaternion).max() < ROUNDING
    assert np.abs(again.turn @ np.swapaxes(again.turn, 1, 2) - np.eye(3)).max() < ROUNDING


def test_a_quaternion_of_zeros_is_no_rotation(box):
    quaternion = np.array(box.quaternion)
    quaternion[3] = 0.0
    with pytest.raises(InputError, match=r"'box': found quaternion .* in frame 3, expected a rot"):
        Thing.of(box.item, ObjectTrack(position=box.position, quaternion=quaternion))
