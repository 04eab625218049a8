"""Soft skin: values by part, the core beneath, and what cannot be asked for."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.body.soft_skin import (
    MODULUS,
    THICKNESS,
    SoftSkin,
    checked_soft_skin,
    soft_core,
)
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX


def at(array, *joints):
    return [array[JOINT_INDEX[joint]] for joint in joints]


def test_buttock_and_thigh_have_the_most_and_fingers_the_least():
    thickness, modulus = SoftSkin().by_part()
    assert thickness.max() == thickness[JOINT_INDEX["pelvis"]] == THICKNESS["pelvis"]
    assert at(thickness, "left_hip", "left_wrist", "left_index3") == [0.018, 0.003, 0.002]
    assert thickness.min() == THICKNESS["fingers"]
    assert modulus[JOINT_INDEX["pelvis"]] == MODULUS["pelvis"]


def test_own_values_replace_those_of_the_parts_they_name():
    skin = SoftSkin(thickness={"hands": 0.0, "pelvis": 0.03}, modulus={"all": 5e4})
    thickness, modulus = skin.by_part()
    assert at(thickness, "left_wrist", "left_index3", "pelvis", "left_hip") == [0, 0, 0.03, 0.018]
    assert (modulus[1:] == 5e4).all()


def test_a_number_of_numpy_is_a_number():
    assert SoftSkin(damping_time=np.float32(0.25)).document == {"damping_time": 0.25}


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"thickness": {"hip": 0.01}}, "no joint 'hip'"),
        ({"thickness": {"feet": 1.0}}, "expected 0 to 0.05 [m], found 1"),
        ({"thickness": {"feet": float("nan")}}, "found nan"),
        ({"thickness": 0.01}, "expected a mapping"),
        ({"modulus": {"feet": 0.0}}, "expected 1000 to 1e+09 [Pa], found 0"),
        ({"damping_time": -1.0}, "damping_time is -1.0"),
    ],
)
def test_impossible_values_are_refused(fields, words):
    with pytest.raises(InputError) as caught:
        SoftSkin(**fields)
    assert words in str(caught.value)


def test_settings_take_it_or_not():
    assert hp.Settings().soft_skin is False
    assert hp.Settings(soft_skin=True).soft_skin is True
    own = SoftSkin(thickness={"feet": 0.01})
    assert hp.Settings(soft_skin=own).soft_skin is own
    assert checked_soft_skin(own.document) == own
    for value, words in ((1, "is 1; expected True"), ({"thick": {}}, "found ['thick']")):
        with pytest.raises(InputError) as caught:
            hp.Settings(soft_skin=value)
        assert words in str(caught.value)
    with pytest.raises(InputError, match="rigid parts have no skin"):
        hp.Settings(soft_skin=True, contact="parts")


def test_the_core_lies_under_the_skin_by_the_thickness_of_its_part():
    body = hp.Body.default()
    skin = SoftSkin(thickness={"all": 0.0, "pelvis": 0.01})  # few vertices: fast
    core = soft_core(body, skin)
    moved = np.linalg.norm(core.vertices - body.rest_vertices, axis=1)
    share = body.weights[:, 0]
    seat = share > 0.5
    assert np.median(core.thickness[seat] / share[seat]) == pytest.approx(0.01, rel=0.02)
    assert (core.thickness <= 0.01 * np.maximum(share, 0.01) + 1e-12).all()
    assert not moved[share == 0.0].any()
    assert not core.thickness[share == 0.0].any()
    assert soft_core(body, skin) is core
