"""Up axes of files: each rotation takes the file's up axis to z."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.base.axes import AXES, axes_of, name_along, turned
from halfphysics.errors import InputError


@pytest.mark.parametrize("up", AXES)
def test_up_in_the_file_is_z_in_the_world(up):
    turn = axes_of(up)
    axis = (-1.0 if up[0] == "-" else 1.0) * np.eye(3)["xyz".index(up[-1])]
    np.testing.assert_array_equal(turn @ axis, [0.0, 0.0, 1.0])
    assert name_along(turn, np.array([0.0, 0.0, 1.0])) == up
    np.testing.assert_array_equal(turn @ turn.T, np.eye(3))
    assert np.linalg.det(turn) == 1.0


def test_other_axes_are_refused():
    assert set(AXES) == {"x", "y", "z", "-x", "-y", "-z"}
    with pytest.raises(InputError, match="up: found 'w', expected one of z, y, -y"):
        axes_of("w")


def test_a_motion_is_turned_by_its_root_alone():
    rng = np.random.default_rng(0)
    translation, rotations = rng.normal(size=(4, 3)), rng.normal(size=(4, 55, 3))
    given = rotations.copy()
    moved, turns = turned(translation, rotations, axes_of("y"))
    np.testing.assert_array_equal(rotations, given)
    np.testing.assert_array_equal(turns[:, 1:], rotations[:, 1:])
    np.testing.assert_allclose(moved, translation @ axes_of("y").T)
    root = axes_of("y") @ rot.rotvec_to_matrix(rotations[:, 0])
    np.testing.assert_allclose(rot.rotvec_to_matrix(turns[:, 0]), root, atol=1e-14)
