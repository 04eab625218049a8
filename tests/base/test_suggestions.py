"""The clause "did you mean X?"."""

from __future__ import annotations

from halfphysics.base.suggestions import closest, did_you_mean

KNOWN = ("left_hand", "right_hand", "pelvis")


def test_the_most_similar_name_is_proposed():
    assert closest("left_hnd", KNOWN) == ["left_hand"]
    assert did_you_mean("pelvi", KNOWN) == "; did you mean pelvis?"
    assert did_you_mean("pelvi", KNOWN, form=repr, brackets=True) == " (did you mean 'pelvis'?)"
    assert did_you_mean("_hand", KNOWN, count=2) == "; did you mean left_hand or right_hand?"
    assert did_you_mean("heat", ["head", "head"], count=2) == "; did you mean head?"


def test_nothing_similar():
    assert did_you_mean("xyz", KNOWN) == ""
    assert did_you_mean("xyz", KNOWN, otherwise="; one of three") == "; one of three"
    assert did_you_mean(17, KNOWN) == ""


def test_words_of_other_programs_are_understood():
    """By its spelling a rotation would be a restitution."""
    keys = ("position", "quaternion", "friction", "restitution")
    assert closest("rotation", keys) == ["quaternion"]
    assert closest("Location", keys) == ["position"]
    assert closest("rotation", ("rotations", "translation")) == ["rotations"]
