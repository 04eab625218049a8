"""Labels in the layouts of other data sets, each against that data set's own rule."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.geometry.mesh_queries import MeshQuery
from halfphysics.labels import ContactLabels, arctic, behave, chois, contact_labels, omomo
from halfphysics.labels.item_solids import item_solids
from halfphysics.results.result import Result
from support.references.labels import solid_distance


@cache
def held() -> tuple[Result, ContactLabels]:
    """A glass that is grasped, from the reach to the lift."""
    told = hp.scenarios.load("grasp_glass")
    motion = told.motions[0][:90]
    result = hp.simulate(motion, told.scene, body=told.bodies[0], settings=told.settings)
    return result, contact_labels(result, reach=0.02)


def _frame(result, frame):
    """The skin, and the glass's vertices, at a frame in the world."""
    skin = result.people[0].body.vertices(result.motion, frame)
    track = result.objects["glass"]
    turn = rot.to_matrix(track.quaternion[frame])
    return skin, held()[1].objects[0].vertices @ turn.T + track.position[frame]


def test_behave_has_the_objects_points_near_the_skin_and_where_on_it():
    result, labels = held()
    found = behave(labels)
    busy = np.flatnonzero(found["contact_label"].any(axis=1))
    assert len(busy) > 5
    for frame in (0, int(busy[0]), int(busy[-1])):
        skin, points = _frame(result, frame)
        np.testing.assert_allclose(found["object_points"][frame], points, atol=1e-6)
        distance, _, nearest = MeshQuery(skin, result.people[0].body.faces).closest(points)
        label = found["contact_label"][frame]
        assert np.array_equal(label, distance <= 0.02)
        np.testing.assert_allclose(
            found["contact_vertices"][frame][label], nearest[label], atol=1e-6
        )
        assert np.isnan(found["contact_vertices"][frame][~label]).all()


def test_omomo_asks_how_far_the_hands_joints_are_from_the_objects_vertices():
    result, labels = held()
    found = omomo(labels)
    joints = result.people[0].body.joints(result.motion)
    hands = [hp.JOINT_NAMES.index("left_middle1"), hp.JOINT_NAMES.index("right_middle1")]
    for frame in range(0, len(result.motion), 10):
        points = _frame(result, frame)[1]
        apart = np.linalg.norm(joints[frame, hands][:, None] - points, axis=2).min(axis=1)
        assert np.array_equal(found[frame], apart <= 0.05)
    assert found[:, 1].any()
    assert not found.all()


def test_chois_has_hands_and_feet_near_the_object():
    result, labels = held()
    found = chois(labels, threshold=0.02)
    assert found.shape == (len(result.motion), 4)
    assert found.dtype == np.float32
    (glass,) = [t for t in item_solids(result.scene, result.objects) if t.name == "glass"]
    part = labels.people[0].vertex_part
    for frame in range(0, len(result.motion), 10):
        skin = _frame(result, frame)[0]
        local = (skin - glass.position[frame]) @ glass.turn[frame]
        near = solid_distance(glass.solids[0], local) <= 0.02
        left = near & np.isin(part, [20, *range(25, 40)])
        right = near & np.isin(part, [21, *range(40, 55)])
        feet = [near & np.isin(part, side) for side in ([7, 10], [8, 11])]
        expected = [left.any(), right.any(), feet[0].any(), feet[1].any()]
        assert np.array_equal(found[frame], expected)
    assert found[:, 1].any()
    with pytest.raises(InputError, match=r"reach=0\.05"):
        chois(labels)


def test_arctic_has_distances_and_contact_both_ways():
    result, labels = held()
    found = arctic(labels)
    skin = labels.skin_near(0.02)
    frames, count = len(result.motion), len(labels.objects[0].vertices)
    assert found["dist.ro"].shape == (frames, len(found["vertices.r"]))
    assert found["dist.or"].shape == (frames, count)
    assert found["contact.ro"].sum() > 0
    for key in ("ro", "or", "lo", "ol"):
        assert np.array_equal(
            found[f"contact.{key}"] == 1, found[f"dist.{key}"] < np.float32(0.003)
        )
        assert found[f"dist.{key}"].max() == np.float32(0.02)
    place = {int(v): i for i, v in enumerate(found["vertices.r"])}
    for frame, vertex, distance in zip(skin.frame, skin.vertex, skin.distance, strict=True):
        if int(vertex) in place:
            assert found["dist.ro"][frame, place[int(vertex)]] == np.float32(distance)
    # The order of the hand model, where it is given.
    mano = {"left": found["vertices.l"][::-1], "right": found["vertices.r"][:7]}
    ordered = arctic(labels, hands=mano)
    assert np.array_equal(ordered["dist.ro"], found["dist.ro"][:, :7])
    assert np.array_equal(ordered["dist.lo"], found["dist.lo"][:, ::-1])
    with pytest.raises(InputError, match="'left' and 'right'"):
        arctic(labels, hands={"right": mano["right"]})
    for wrong in ({"left": [-1], "right": [0]}, {"left": [[0], [0, 1]], "right": [[0], [0, 1]]}):
        with pytest.raises(InputError, match="expected vertices"):
            arctic(labels, hands=wrong)
    with pytest.raises(InputError, match="hands: found 3, expected 'left' and 'right'"):
        arctic(labels, hands=3)
    with pytest.raises(InputError, match=r"most: expected a number of at least 0"):
        arctic(labels, most="far")
    for export in (arctic, behave, chois, omomo):
        with pytest.raises(InputError, match=r"labels: found None, expected .*contact_labels"):
            export(None)
