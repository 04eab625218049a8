"""Units by planted feet and by the height of who stands; degrees by the size of angles."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.formats.glance import glance
from halfphysics.formats.units_check import feet_say, in_radians, unit_of
from support.files.layouts import UPRIGHT
from support.files.wrong_axes import walker

#: Feet of a made walk slide and roll by a few percent of its way.
ROLLS = 0.15
STILL = np.eye(3)


def unit(translation, rotations, fps=30.0):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        return unit_of("file", translation, rotations, fps, STILL), [str(w.message) for w in caught]


@pytest.mark.parametrize("size", [1.0, 39.37, 100.0, 1000.0])
def test_feet_say_how_many_units_a_metre_has(size):
    motion = walker()
    seen = glance(size * motion.translation, motion.rotations, motion.fps, STILL)
    assert abs(feet_say(seen) / size - 1.0) < ROLLS


def test_who_has_no_floor_is_measured_by_the_feet():
    motion = walker()
    far = motion.translation + np.array([40.0, 0.0, 12.3])  # where a camera's origin may be
    assert unit(far, motion.rotations) == (1.0, [])
    found, (line,) = unit(100.0 * far, motion.rotations)
    assert found == 0.01
    assert "planted feet" in line


def test_who_stands_still_is_measured_by_height():
    turns = np.zeros((60, 55, 3))
    turns[:, 0] = UPRIGHT["z"]
    turns[:, [16, 17], 2] = 0.3 * np.sin(np.arange(60) / 10.0)[:, None]
    low = hp.Body.default().vertices(hp.Motion(np.zeros((60, 3)), turns, 30.0))[..., 2].min()
    places = np.tile([0.0, 0.0, -low], (60, 1))
    assert unit(places, turns) == (1.0, [])
    for size, name in ((100.0, "centimetres"), (1000.0, "millimetres")):
        found, (line,) = unit(size * places, turns)
        assert (found, name in line) == (1.0 / size, True)
    # On a mountain, in metres: nothing says that it is not.
    assert unit(places + np.array([0.0, 0.0, 1990.0]), turns) == (1.0, [])


def test_a_walk_far_away_is_in_metres():
    motion = walker()
    assert unit(motion.translation + np.array([900.0, 0.0, 0.0]), motion.rotations) == (1.0, [])


def test_degrees_are_found_by_several_joints():
    turns = walker().rotations
    with pytest.warns(HalfPhysicsWarning, match="are in degrees, and read as such"):
        found, doubtful = in_radians("file", np.degrees(turns))
    assert np.abs(found - turns).max() < 1e-14
    assert not doubtful
    assert in_radians("file", turns) == (turns, False)
