"""How deep people are in what is around them: objects and each other count."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.repair.insides import DEEP, insides, told
from support.made_clips import standing

#: Depths of the same skins measured twice [mm].
EXACT = 1e-9

pytestmark = pytest.mark.filterwarnings("ignore:the start is not clear")


def met(shift, *, crate=False):
    """Two people `shift` [m] apart, unmoved, and a crate about the first one's feet."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    one = standing(6)
    place = hp.Body.default().joints(one)[0, 0]
    if crate:
        scene.add_object(
            "crate", hp.Box((0.6, 0.6, 0.4)), mass=200.0, position=(place[0], place[1], 0.2)
        )
    other = one.with_frames(one.translation + np.array([shift, 0.0, 0.0]), one.rotations)
    return [one, other], hp.simulate([one, other], scene)


def test_people_are_deep_in_each_other():
    motions, result = met(0.1)
    reports = insides(motions, result)
    a, b = ((m, hp.Body.default()) for m in motions)
    alone = hp.metrics.penetration(*a, result.scene, people={"other": b})
    assert reports[0].depth_max_mm > DEEP
    assert abs(reports[0].depth_max_mm - alone.depth_max_mm) < EXACT
    assert told(reports, result) == ["people were inside each other: moved apart"]


def test_people_apart_are_in_nothing():
    motions, result = met(3.0)
    assert told(insides(motions, result), result) == []


def test_objects_are_where_the_simulation_has_them():
    motions, result = met(3.0, crate=True)
    reports = insides(motions, result)
    there = hp.metrics.penetration(
        motions[0], hp.Body.default(), result.scene, objects=result.objects
    )
    assert there.depth_max_mm > DEEP
    assert abs(reports[0].depth_max_mm - there.depth_max_mm) < EXACT
    assert told(reports, result) == ["inside crate: moved out"]
