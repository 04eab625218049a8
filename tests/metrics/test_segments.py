"""Segments of a body: closed, their volumes, their neighbours."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.geometry.mesh_queries import boundary_edges
from halfphysics.metrics.segments import NAMES, neighbours, segment_of_joint, segments
from halfphysics.motion.skeleton import JOINT_NAMES
from support.boxes import box_person


def test_every_segment_is_closed_and_every_face_in_one() -> None:
    body = hp.Body.default()
    whole = segments(body)
    count = len(body.rest_vertices) + len(whole.rims)
    for faces in whole.faces:
        assert len(faces)
        assert not len(boundary_edges(faces.astype(np.int32), count))
    fans = sum(len(rim) for rim in whole.rims)
    assert sum(map(len, whole.faces)) == len(body.faces) + fans
    assert segments(body) is whole
    # Two rims at each of the 13 cuts.
    assert len(whole.rims) == 2 * (len(NAMES) - 1)


def test_volumes_sum_to_that_of_the_skin() -> None:
    """Both sides of a cut share its rim, so that nothing is counted twice or left out."""
    body = hp.Body.default()
    rest = body.rest_vertices
    a, b, c = (rest[body.faces[:, k]] for k in range(3))
    skin = np.linalg.det(np.stack([a, b, c], axis=1)).sum() / 6.0
    whole = segments(body)
    volumes = whole.volumes(whole.rows(np.stack([rest, rest + np.array([5.0, -3.0, 2.0])])))
    assert volumes.sum(axis=0) == pytest.approx([skin, skin], abs=1e-9)
    left, right = (NAMES.index(f"{side}_thigh") for side in ("left", "right"))
    assert volumes[left, 0] == pytest.approx(volumes[right, 0], rel=0.03)


def test_volumes_of_boxes() -> None:
    body = box_person({"pelvis": (0.4, 0.2, 0.6), "left_knee": (0.1, 0.1, 0.5)})
    turned = body.rest_vertices @ np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    whole = segments(body)
    volumes = whole.volumes(whole.rows(np.stack([body.rest_vertices, 2.0 * turned])))
    expected = np.zeros(len(NAMES))
    expected[NAMES.index("trunk")], expected[NAMES.index("left_shank")] = 0.048, 0.005
    np.testing.assert_allclose(volumes.T, [expected, 8.0 * expected], atol=1e-12)


def test_neighbours() -> None:
    of = dict(zip(JOINT_NAMES, segment_of_joint(), strict=True))
    assert NAMES[of["left_pinky3"]] == "left_hand"
    assert NAMES[of["jaw"]] == "head"
    assert NAMES[of["right_collar"]] == "trunk"
    near = neighbours()
    assert near[of["left_hip"], of["pelvis"]]
    assert near[of["left_wrist"], of["left_elbow"]]
    assert not near[of["left_hip"], of["right_hip"]]
    assert not near[of["left_wrist"], of["left_shoulder"]]
    assert (near == near.T).all()
