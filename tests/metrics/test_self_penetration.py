"""Self-penetration of boxes by hand, and of hands that are put into thighs."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import metrics
from halfphysics.errors import InputError
from halfphysics.metrics.segments import NAMES, neighbours, segments
from halfphysics.metrics.self_penetration import depths
from support.boxes import box_person

EXACT = 1e-9
#: World from segment: turned about z by 30 degrees; the answer must not depend on it.
TURNED = np.array([[np.cos(0.5), -np.sin(0.5), 0], [np.sin(0.5), np.cos(0.5), 0], [0, 0, 1.0]])


@pytest.mark.parametrize("turn", [np.eye(3), TURNED], ids=["straight", "turned"])
def test_corners_of_a_box_in_another(turn: np.ndarray) -> None:
    """A hand of 10 cm whose lower 2 cm are in a shank of 1 m: four corners, 2 cm deep."""
    body = box_person({"left_wrist": (0.1, 0.1, 0.1), "left_knee": (1.0, 1.0, 1.0)})
    vertices = body.placed({"left_wrist": (0.0, 0.0, 0.53), "left_knee": (0.0, 0.0, 0.0)})
    turns = np.tile(turn, (len(NAMES), 1, 1))
    depth = depths(vertices, segments(body), turns, ~neighbours())
    expected = np.where(vertices[:8, 2] < 0.5, 0.02, 0.0)
    np.testing.assert_allclose(depth, [*expected, *np.zeros(8)], atol=EXACT)


def test_neighbours_may_overlap() -> None:
    body = box_person({"left_wrist": (0.1, 0.1, 0.1), "left_elbow": (1.0, 1.0, 1.0)})
    vertices = body.placed({"left_wrist": (0.0, 0.0, 0.53), "left_elbow": (0.0, 0.0, 0.0)})
    turns = np.tile(np.eye(3), (len(NAMES), 1, 1))
    assert not depths(vertices, segments(body), turns, ~neighbours()).any()


def posed(*lowered: float) -> hp.Motion:
    """Standing frames whose arms are lowered by these angles from the T-pose [rad]."""
    rotations = np.zeros((len(lowered), 55, 3))
    rotations[:, 0, 0] = np.pi / 2
    rotations[:, 16, 2], rotations[:, 17, 2] = -np.array(lowered), np.array(lowered)
    return hp.Motion(np.zeros((len(lowered), 3)), rotations, 30.0)


def test_arms_at_rest_are_clear_and_in_the_body_are_not() -> None:
    body = hp.Body.default()
    report = metrics.self_penetration(posed(0.0, 1.8), body)
    assert report.frames.tolist() == [0, 1]
    clear = metrics.self_penetration(posed(0.0, 0.0), body)
    assert (clear.percent, clear.depth_mm, clear.max_mm) == (0.0, 0.0, 0.0)
    assert report.max_mm > 20.0
    assert report.depth_mm == pytest.approx(0.5 * report.max_mm, abs=EXACT)
    assert 0.0 < report.percent < 15.0


def solid_angles(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Winding numbers (n,) by the solid angles of all triangles (F, 3, 3)."""
    total = np.zeros(len(points))
    for triangle in corners:
        a, b, c = (corner - points for corner in triangle)
        la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
        volume = np.einsum("ni,ni->n", a, np.cross(b, c))
        dots = [np.einsum("ni,ni->n", x, y) for x, y in ((a, b), (b, c), (c, a))]
        total += np.arctan2(volume, la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb)
    return total / (2.0 * np.pi)


def test_inside_is_by_winding_number() -> None:
    """Without bounding boxes: the vertices of a hand against a thigh, by solid angles."""
    body = hp.Body.default()
    vertices, whole = body.vertices(posed(1.75, 1.75), 0), segments(body)
    thigh, hand = NAMES.index("left_thigh"), NAMES.index("left_hand")
    compared = np.zeros((len(NAMES), len(NAMES)), dtype=bool)
    compared[hand, thigh] = True
    depth = depths(vertices, whole, np.tile(TURNED, (len(NAMES), 1, 1)), compared)
    own = np.flatnonzero(whole.of_vertex == hand)[::5]
    winding = solid_angles(vertices[own], whole.closed(vertices)[whole.faces[thigh]])
    assert ((winding > 0.5) == (depth[own] > 0.0)).all()
    assert (depth[own] > 0.0).any()


def test_at_most_so_many_frames() -> None:
    body, motion = hp.Body.default(), posed(*np.linspace(0.0, 1.0, 30))
    assert len(metrics.self_penetration(motion, body, most=4).frames) == 4
    assert metrics.self_penetration(motion, body, most=4).frames.tolist() == [0, 10, 19, 29]


def test_what_is_no_motion_no_body_and_no_number_of_frames() -> None:
    body, motion = hp.Body.default(), posed(0.0, 1.0)
    with pytest.raises(InputError, match=r"motion: expected a halfphysics\.Motion or Pose"):
        metrics.self_penetration("a", body)
    with pytest.raises(InputError, match=r"body: expected a halfphysics\.Body"):
        metrics.self_penetration(motion, "a")
    for most in (0, -1, 1.5, "all"):
        with pytest.raises(InputError, match="most: expected a whole number of at least 1"):
            metrics.self_penetration(motion, body, most=most)
