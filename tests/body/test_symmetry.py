"""A skin's mirror image in itself: found where there is one, to the last bit or nearly."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.body.footing_points import footing_points
from halfphysics.body.symmetry import FLIP, TOLERANCE, symmetry_of
from halfphysics.motion.skeleton import JOINT_NAMES, MIRRORED

BETAS = [2.0, -1.0, 0.5, 1.0, 0.0, -2.0]


@pytest.fixture(scope="module", params=[None, BETAS], ids=["mean", "betas"])
def body(request):
    return Body.default(request.param)


def test_left_and_right_change_places():
    np.testing.assert_array_equal(MIRRORED[MIRRORED], np.arange(55))
    assert JOINT_NAMES[MIRRORED[JOINT_NAMES.index("left_thumb2")]] == "right_thumb2"
    assert sum(np.arange(55) == MIRRORED) == 7  # pelvis, spine, neck, head and jaw


def test_the_default_body_is_its_mirror_image_to_the_last_bit(body):
    found = body.symmetry
    assert found.is_exact(body.rest_vertices)
    assert found.even(body.rest_vertices).tobytes() == (body.rest_vertices + 0.0).tobytes()
    np.testing.assert_array_equal(body.weights[found.vertex][:, MIRRORED], body.weights)
    np.testing.assert_array_equal(
        np.sort(found.vertex[body.faces], axis=1), np.sort(body.faces[found.face], axis=1)
    )
    for image in (found.vertex, found.face):
        np.testing.assert_array_equal(image[image], np.arange(len(image)))


def test_parts_of_the_right_are_images_of_the_left_to_the_last_bit(body):
    parts = body.variant.parts
    for part in parts:
        other = parts[MIRRORED[part.index]]
        assert part.mass == other.mass
        np.testing.assert_array_equal(part.com, other.com * FLIP)
        np.testing.assert_array_equal(part.inertia, other.inertia * np.outer(FLIP, FLIP))
        mine, others = part.vertices, other.vertices * FLIP
        if part is other:  # in the middle: the same corners, in another order
            mine, others = mine[np.lexsort(mine.T)], others[np.lexsort(others.T)]
        np.testing.assert_array_equal(mine, others)


def test_points_of_the_feet_are_chosen_on_both_sides_alike(body):
    points = footing_points(body)
    left, right = (points.local[a:b] for a, b in ((0, points.soles[0]), (points.soles[0], None)))
    right = right[: points.soles[1]]
    assert points.soles[0] == points.soles[1] > 0
    np.testing.assert_array_equal(left, right * FLIP)


def test_points_of_skin_and_hands_are_images_of_each_other(body):
    points = footing_points(body)
    first = sum(points.soles)
    at = points.local[first:, 0] + body.rest_joints[points.joints[first:, 0]]
    # Coordinates of order 1 m, of which a joint's place was taken away and added again.
    distance = np.abs(at[:, None] - at[None] * FLIP).max(axis=2)
    assert distance.min(axis=1).max() <= 1e-15


@pytest.mark.parametrize(("off", "found"), [(0.3 * TOLERANCE, True), (3.0 * TOLERANCE, False)])
def test_a_nearly_even_skin(off, found):
    body = Body.default()
    moved = body.rest_vertices.copy()
    moved[np.argmax(moved[:, 1])] += [0.0, off, 0.0]
    moved[np.argmax(moved[:, 0])] += [off, 0.0, 0.0]
    symmetry = symmetry_of(body.faces, moved)
    assert (symmetry is not None) == found
    if symmetry is not None:
        np.testing.assert_array_equal(symmetry.vertex, body.symmetry.vertex)
        even = symmetry.even(moved)
        assert symmetry.is_exact(even)
        assert not symmetry.is_exact(moved)
        assert np.abs(even - moved).max() <= off


def test_faces_must_mirror_each_other_too():
    """A square on either side, with diagonals that are parallel, and that mirror each other."""
    corners = np.array([[1, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0]], dtype=np.float64)
    points = np.concatenate([corners, corners * FLIP])
    left = np.array([[0, 1, 2], [0, 2, 3]])
    assert symmetry_of(np.concatenate([left, left + 4]), points) is not None
    other = np.array([[5, 4, 7], [5, 7, 6]])
    assert symmetry_of(np.concatenate([left, other]), points) is None


def test_what_has_no_mirror_image():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0]], dtype=np.float64)
    assert symmetry_of(np.zeros((0, 3), dtype=np.int64), points) is None
    assert symmetry_of(np.array([[0, 1, 2]]), points) is None
    across = np.array([[-1, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=np.float64)
    assert symmetry_of(np.array([[0, 1, 2]]), across) is None  # a face that is its own image
