"""Prefixes and numbers that all names of a skeleton have."""

from __future__ import annotations

import pytest

from halfphysics.formats.skeletons.shared_affixes import without_affixes

PLAIN = ["Hips", "LeftUpLeg", "LeftLeg", "Spine", "Spine1"]


@pytest.mark.parametrize(
    "names",
    [
        PLAIN,
        [f"Robot_{name}" for name in PLAIN],
        [f"Ann:rig:{name}" for name in PLAIN],
        [f"{name}_{k:03d}" for k, name in enumerate(PLAIN)],
        [f"{name}.001" for name in PLAIN],
        [f"My Rig|{name}.12" for name in PLAIN],
    ],
)
def test_what_all_have_is_left_out(names):
    assert without_affixes(names) == PLAIN


def test_a_root_may_lack_it():
    assert without_affixes(["Armature", *(f"R2 {name}" for name in PLAIN)]) == ["Armature", *PLAIN]


def test_what_some_have_is_theirs():
    """Sides and numbers of a spine are words of the joints."""
    names = ["Left_Arm", "Left_Leg", "Right_Arm", "Right_Leg", "spine.001", "spine.002"]
    assert without_affixes(names) == names


def test_no_name_becomes_empty():
    assert all(without_affixes(["_1", "_2", "_3", "a_", "a_"]))
    assert without_affixes([]) == []


def test_a_name_of_any_length_costs_no_memory():
    long = "a_" * 500_000 + "b"  # of each of its prefixes together it would be a terabyte
    assert without_affixes(["Hips", long, "Robot_Spine"]) == ["Hips", long, "Robot_Spine"]
