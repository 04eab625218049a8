"""Parts of a person: their joints, and how they are told."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.adaptation.feet import Foot
from halfphysics.adaptation.hands import SIDES, Hand
from halfphysics.adaptation.parts import Seat, joints_of, told
from halfphysics.motion.skeleton import JOINT_INDEX


def test_the_skin_of_a_part_is_of_its_joints():
    body = hp.Body.default()
    moved_by = np.argmax(body.weights, axis=1)
    parts = [of(body, side) for of in (Hand.of, Foot.of) for side in SIDES]
    for part in [*parts, Seat(body)]:
        assert len(part.inner) > 30
        assert set(moved_by[part.inner]) <= set(joints_of(part.name))
        assert JOINT_INDEX[part.name] in joints_of(part.name)


def test_a_limb_ends_in_the_joint_that_stands_for_it():
    body = hp.Body.default()
    for side in SIDES:
        for limb in (Hand.of(body, side), Foot.of(body, side)):
            assert limb.limb[2] == JOINT_INDEX[limb.name]
            assert set(limb.pressing[:-1]) < set(limb.pressing)
            assert not set(limb.beyond) & set(limb.pressing)


def test_parts_in_words():
    assert told(("left_wrist", "right_wrist")) == "in the left and right hand"
    assert told(("right_ankle",)) == "with the right foot"
    assert told(("pelvis",)) == "under the seat"
