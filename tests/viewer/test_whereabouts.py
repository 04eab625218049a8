"""The boxes that a page's cameras use."""

from __future__ import annotations

import numpy as np

from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.render.result_meshes import Drawing
from halfphysics.viewer.whereabouts import goes_far, track
from support.results.small_result import FRAMES, small_result


def test_the_boxes_hold_all_joints_and_the_hands():
    result = small_result()
    offsets = np.array([[0.0, 0.0, 0.0], [3.0, 1.0, 0.0]])
    frames = [0, 7, FRAMES - 1, FRAMES + 5]  # the last: a longer result goes on
    boxes = track([Drawing(result), Drawing(result)], offsets, frames)
    assert boxes.shape == (4, 18)
    (person,) = result.people
    for row, frame in zip(boxes, (0, 7, FRAMES - 1, FRAMES - 1), strict=True):
        own = person.body.joints(person.motion)[frame]
        both = np.concatenate([own, own + offsets[1]])
        np.testing.assert_allclose(row[0:3], both.min(axis=0))
        np.testing.assert_allclose(row[3:6], both.max(axis=0))
        np.testing.assert_allclose(row[6:9], own[0] + 0.5 * offsets[1])
        # They walk along x: their left is along y.
        np.testing.assert_allclose(row[9:11], [0.0, 1.0], atol=0.1)
        hands = [k for k, name in enumerate(JOINT_NAMES) if name.endswith("_wrist")]
        for hand in hands:
            assert (row[12:15] <= own[hand] + 1e-9).all()
            assert (row[15:18] >= own[hand] - 1e-9).all()
        assert row[17] - row[14] < 0.5  # no foot, no head


def test_only_the_hands_in_contact_count_if_one_is():
    from types import SimpleNamespace

    result = SimpleNamespace(**vars(small_result()))
    contacts = SimpleNamespace(**vars(result.contacts))
    contacts.part = np.where(contacts.part >= 0, JOINT_INDEX["left_index1"], -1)
    result.contacts = contacts
    (row,) = track([Drawing(result)], np.zeros((1, 3)), [4])
    joints = result.people[0].body.joints(result.people[0].motion)[4]
    left = [k for k, n in enumerate(JOINT_NAMES) if n == "left_wrist" or _finger(n)]
    np.testing.assert_allclose(row[12:15], joints[left].min(axis=0))
    np.testing.assert_allclose(row[15:18], joints[left].max(axis=0))


def _finger(name):
    return name.startswith("left_") and name[-1] in "123"


def test_a_camera_goes_along_with_who_goes_far():
    boxes = np.zeros((10, 18))
    assert not goes_far(boxes)
    boxes[:, 8] = np.linspace(0.0, 1.5, 10)  # a jump
    assert not goes_far(boxes)
    for corner in (1, 3):  # one of two people stays
        moved = boxes.copy()
        moved[:, corner] = np.linspace(0.0, 1.5, 10)
        assert goes_far(moved)
