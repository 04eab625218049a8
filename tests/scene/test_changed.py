"""A scene with other masses and frictions."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.scene.changed import changed, mass_of, movable


@pytest.fixture
def scene():
    made = hp.Scene()
    made.add_static("floor", hp.Plane())
    made.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(0, 0, 1))
    return made


def test_a_heavier_object_has_the_inertia_of_its_shape(scene):
    other = changed(scene, {"ball": 3.0}, {})
    assert mass_of(movable(other)["ball"]) == 3.0
    np.testing.assert_allclose(other.objects["ball"].inertia, 3 * scene.objects["ball"].inertia)
    assert scene.objects["ball"].mass == 1.0


def test_frictions_of_statics_and_objects(scene):
    other = changed(scene, {}, {"floor": 0.1, "ball": 0.2})
    assert (other.statics["floor"].friction, other.objects["ball"].friction) == (0.1, 0.2)


def test_nothing_given_is_the_same_scene(scene):
    assert changed(scene, {}, {}) is scene


@pytest.mark.parametrize(
    ("masses", "frictions", "said"),
    [
        ({"ball": 0.0}, {}, "above 0"),
        ({"floor": 1.0}, {}, "expected one of ball"),
        ({}, {"wall": 1.0}, "expected one of floor, ball"),
        ({}, {"ball": -1.0}, "at least 0"),
    ],
)
def test_what_is_impossible_is_refused(scene, masses, frictions, said):
    with pytest.raises(hp.errors.InputError, match=said):
        changed(scene, masses, frictions)
