"""A floor for data sets that bring none."""

from __future__ import annotations

import warnings
from types import SimpleNamespace

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.formats.datasets.ground import GROUND, add_ground, needs_ground
from halfphysics.results.result import ObjectTrack
from halfphysics.simulation.sequence import Sequence

FRAMES, HEIGHT, ROUNDING = 5, 0.25, 1e-12


def sequence(low):
    """A person whose lowest skin is at HEIGHT, and a box whose lowest corner is `low` above."""
    rotations = np.zeros((FRAMES, 55, 3))
    rotations[:, 0, 0] = np.pi / 2
    motion = hp.Motion(np.zeros((FRAMES, 3)), rotations, fps=30.0)
    motion = motion.grounded(hp.Body.default(), z=HEIGHT)
    scene = hp.Scene()
    at = np.tile([1.0, 0.0, HEIGHT + low + 0.1], (FRAMES, 1))
    scene.add_object("box", hp.Box((0.4, 0.3, 0.2)), mass=1.0, position=at[0])
    still = np.tile([1.0, 0.0, 0.0, 0.0], (FRAMES, 1))
    return Sequence(motion, scene, recorded={"box": ObjectTrack(position=at, quaternion=still)})


@pytest.mark.parametrize(("low", "expected"), [(0.0, 0.0), (-0.02, -0.02), (0.03, 0.0), (0.7, 0.0)])
def test_it_is_under_the_lowest_skin_and_the_lowest_thing(low, expected):
    """A thing that was never on the floor does not say where it is."""
    made = sequence(low)
    with pytest.warns(hp.HalfPhysicsWarning, match=r"'ground'.*ground=False"):
        add_ground(made, SimpleNamespace(name="clip.p"))
    plane = made.scene.statics[GROUND].shape
    assert abs(plane.offset - (HEIGHT + expected)) < 1e-9
    assert plane.normal == (0.0, 0.0, 1.0)


def test_a_thing_far_below_is_no_floor():
    made = sequence(-0.8)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        add_ground(made, "clip.p")
    assert abs(made.scene.statics[GROUND].shape.offset - HEIGHT) < 1e-9


@pytest.mark.parametrize(("bottom", "needed"), [(0.4, True), (0.05, False), (-3.0, False)])
def test_a_table_top_is_no_floor(bottom, needed):
    made = sequence(0.0)
    at = (2.0, 0.0, HEIGHT + bottom + 0.1)
    made.scene.add_static("table", hp.Box((1.0, 1.0, 0.2)), position=at)
    assert needs_ground(made) is needed


def test_what_a_person_is_over_is_a_floor():
    made = sequence(0.0)
    made.scene.add_static("hall", hp.Box((4.0, 4.0, 0.1)), position=(0.0, 0.0, HEIGHT + 1.0))
    assert not needs_ground(made)


def test_a_plane_is_one():
    made = sequence(0.0)
    made.scene.add_static("floor", hp.Plane(offset=HEIGHT + 0.3))
    assert not needs_ground(made)
    assert needs_ground(sequence(0.0))
