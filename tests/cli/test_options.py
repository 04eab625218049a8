"""Options that several commands share: which body a person has."""

from __future__ import annotations

import os

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.cli.options import BodyOptions, check_output
from halfphysics.errors import FileError


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


@pytest.mark.skipif(os.name != "posix", reason="Windows lets few make links")
def test_an_output_is_checked_where_a_link_leads(tmp_path):
    link = tmp_path / "out.npz"
    link.symlink_to("gone/out.npz")
    with pytest.raises(FileError, match=r"the folder .*gone does not exist"):
        check_output(link)
    (tmp_path / "gone").mkdir()
    check_output(link)
    (tmp_path / "gone" / "out.npz").write_bytes(b"")
    with pytest.raises(FileError, match="this is the input"):
        check_output(link, tmp_path / "gone" / "out.npz")
