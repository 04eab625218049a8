"""Contacts in the rest pose: where skinning would carry them back."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from halfphysics.results.contacts import Contacts
from halfphysics.viewer.skin_forces import (
    LEAST,
    at_rest,
    live_points,
    skin_document,
    soft_points,
)
from support.results.small_result import FPS, small_result
from support.results.soft_results import soft_result


@pytest.fixture(scope="module")
def posed():
    """A body in a pose with every joint turned, and a vertex for each part that moves with it."""
    body = Body.default()
    generator = np.random.default_rng(3)
    rotations = np.tile(0.4 * generator.normal(size=(55, 3)), (2, 1, 1))
    motion = Motion(np.tile([0.3, -2.0, 1.1], (2, 1)), rotations, 30.0)
    weights = np.asarray(body.weights)
    vertex = np.argmax(weights, axis=0)
    whole = np.flatnonzero(weights[vertex, np.arange(55)] > 0.999)
    assert len(whole) > 20
    return body, motion, whole, vertex[whole]


def test_a_vertex_that_moves_with_its_part_comes_back_to_its_place(posed):
    body, motion, part, vertex = posed
    vertices = body.vertices(motion, frames=[0])[0]
    joints, turns = body.joint_frames(motion)
    found = at_rest(body, part, vertices[vertex], joints[0, part], turns[0, part])
    # The rest of a weight of 0.999 may be off by a millimetre of a metre of lever.
    np.testing.assert_allclose(found, np.asarray(body.rest_vertices)[vertex], atol=2e-3)


def test_live_points_are_those_places_with_their_forces(posed):
    body, motion, part, vertex = posed
    vertices = body.vertices(motion, frames=[0])[0]
    joints, turns = body.joint_frames(motion)
    force = np.linspace(0.0, 10.0, len(part))
    points = live_points(body, part, vertices[vertex], force, joints[0], turns[0])
    strong = force >= LEAST
    assert len(points) == strong.sum() < len(part)
    np.testing.assert_allclose(np.array(points)[:, 3], force[strong], atol=1e-3)
    rest = np.asarray(body.rest_vertices)[vertex[strong]]
    np.testing.assert_allclose(np.array(points)[:, :3], rest, atol=3e-3)


def test_the_document_has_the_contacts_of_the_frames_that_are_shown():
    result = SimpleNamespace(**vars(small_result()))
    # Every contact at the tip of its part's bone, 5 cm along the bone's own x axis.
    (person,) = result.people
    joints, turns = person.body.joint_frames(person.motion)
    contacts = SimpleNamespace(**vars(result.contacts))
    at, part = contacts.frame, np.maximum(contacts.part, 0)
    contacts.position = joints[at, part] + rot.rotate(turns[at, part], np.array([0.05, 0.0, 0.0]))
    result.contacts = contacts
    frames = range(0, len(result.motion), 3)
    document = skin_document(result, frames)
    assert document["fps"] == pytest.approx(FPS / 3)
    force = np.linalg.norm(contacts.impulse, axis=1) * FPS
    rest = np.asarray(person.body.rest_joints)
    for k, frame in enumerate(frames):
        rows = slice(document["first"][k], document["first"][k + 1])
        mine = (at == frame) & (contacts.person == 0) & (force >= LEAST)
        np.testing.assert_allclose(0.1 * np.array(document["force"][rows]), force[mine], atol=0.05)
        place = 1e-3 * np.array(document["place"]).reshape(-1, 3)[rows]
        expected = rest[contacts.part[mine]] + [0.05, 0.0, 0.0]
        np.testing.assert_allclose(place, expected, atol=6e-4)  # millimetres
    shown = {
        JOINT_NAMES[p] for p in contacts.part[np.isin(at, frames) & (force >= LEAST)] if p >= 0
    }
    assert shown == {"right_foot", "right_shoulder"}
    assert JOINT_INDEX["right_foot"] in contacts.part


def test_pressures_of_soft_things_are_where_they_press():
    """Their sums over cubes carry the whole force; the contact of the pair does not count twice."""
    result = soft_result()
    rows = result.soft_contacts
    mine = rows.other == 2
    force = np.bincount(rows.frame[mine], (rows.pressure * rows.area)[mine], len(result))
    points = soft_points(result)
    np.testing.assert_allclose(np.bincount(points.frame, points.force, len(result)), force)
    assert len(points.frame) < 0.5 * mine.sum()
    n = len(result)
    pair = Contacts(
        frame=np.arange(n),
        person=np.zeros(n, dtype=int),
        part=np.zeros(n, dtype=int),
        other=np.zeros(n, dtype=int),
        position=np.zeros((n, 3)),
        normal=np.tile([0.0, 0.0, 1.0], (n, 1)),
        impulse=np.tile([0.0, 0.0, 100.0], (n, 1)),
        subject=np.full(n, -1),
        other_part=np.full(n, -1),
    )
    document = skin_document(dataclasses.replace(result, contacts=pair), range(n))
    last = slice(document["first"][-2], document["first"][-1])
    shown = 0.1 * sum(document["force"][last])
    strong = (points.frame == n - 1) & (points.force >= LEAST)
    assert shown == pytest.approx(points.force[strong].sum(), abs=0.05 * strong.sum())
    # In the first frame nothing presses the bed: the contact is what there is.
    assert document["first"][:2] == [0, 1]


def test_a_vertex_that_the_body_does_not_have():
    result = soft_result()
    rows = result.soft_contacts[result.soft_contacts.vertex >= 0][[0]]
    other = dataclasses.replace(rows, vertex=np.array([10**6]))
    with pytest.raises(InputError, match="found vertex 1000000, but the skin of"):
        skin_document(dataclasses.replace(result, soft_contacts=other), range(3))
