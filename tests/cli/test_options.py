"""Options that several commands share: which body a person has."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.cli.options import BodyOptions


def test_the_mass_is_that_of_any_body():
    """Of the default body, or of the motion's own."""
    motion = hp.Motion(np.zeros((2, 3)), np.zeros((2, 55, 3)), 30.0)
    assert BodyOptions(mass=80.0).load(motion).mass == pytest.approx(80.0)
    own = hp.Body.default(stature=1.6)
    heavy = BodyOptions(mass=80.0).instead_of(own, motion)
    assert heavy.mass == pytest.approx(80.0)
    assert heavy.stature == pytest.approx(1.6)
    assert BodyOptions().instead_of(own, motion) is own


def test_another_body_takes_the_place_of_the_own_one():
    motion = hp.Motion(np.zeros((2, 3)), np.zeros((2, 55, 3)), 30.0)
    body = BodyOptions(stature=1.7, mass=60.0).instead_of(hp.Body.default(), motion)
    assert body.stature == pytest.approx(1.7)
    assert body.mass == pytest.approx(60.0)
    with pytest.raises(hp.errors.InputError, match="mass"):
        BodyOptions(mass=-1.0).load(motion)
