"""Contacts in the scene: nodes hold the result's values, frame by frame."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.viewer.contacts import (
    KINDS,
    LARGEST,
    NO_PERSON,
    OBJECT,
    PERSON,
    SCENE,
    SHORTEST,
    TENFOLD,
    ContactFrames,
    ContactNodes,
    arrow_lengths,
    kinds,
)
from support.results.small_result import FPS, FRAMES, small_result

pytest.importorskip("viser")


@pytest.fixture
def stage():
    from halfphysics.viewer.server import close_server, open_server
    from halfphysics.viewer.stage import Stage

    server = open_server("127.0.0.1", 0)
    yield Stage(server, spread())
    close_server(server)


def spread():
    """The small result, with different contact positions."""
    from types import SimpleNamespace

    result = small_result()
    contacts = SimpleNamespace(**vars(result.contacts))
    n = len(contacts.frame)
    contacts.position = np.random.default_rng(3).uniform(-1.0, 1.0, (n, 3))
    contacts.impulse = contacts.impulse + 0.01 * np.arange(n)[:, None] * (
        np.linalg.norm(contacts.impulse, axis=1, keepdims=True) > 0
    )
    return SimpleNamespace(**{**vars(result), "contacts": contacts})


def held(nodes):
    """The content of the visible nodes: kind -> positions, starts and ends."""
    handles = {k: node.handle for k, node in nodes.points.items()}
    points = {k: np.array(h.batched_positions) for k, h in handles.items() if h.visible}
    handles = {k: node.handle for k, node in nodes.arrows.items()}
    arrows = {k: np.array(h.points) for k, h in handles.items() if h.visible}
    return points, arrows


def test_kinds_tell_statics_objects_people_and_things_apart():
    result = spread()
    names = result.names
    kind = kinds(result)
    expected = []
    for person, other in zip(result.contacts.person, result.contacts.other, strict=True):
        if person < 0:
            expected.append(NO_PERSON)
        else:
            expected.append(OBJECT if names[other] == "ball" else SCENE)
    assert kind.tolist() == expected
    assert {SCENE, OBJECT, NO_PERSON} == set(expected)
    result.contacts.other = np.full(len(expected), names.index("person"))
    result.contacts.person = np.zeros(len(expected), dtype=int)
    assert set(kinds(result)) == {PERSON}
    assert len({kind.color for kind in KINDS}) == 4


def test_nodes_hold_the_contacts_of_the_frame(stage):
    result = stage.drawing.result
    nodes = ContactNodes(stage._server, stage)
    of_kind = kinds(result)
    for frame in (0, 6, 2, 10, 12, FRAMES - 1):
        stage.show(frame)
        points, arrows = held(nodes)
        here = result.contacts.frame == frame
        assert set(points) == set(of_kind[here])
        for kind, at in points.items():
            rows = np.flatnonzero(here & (of_kind == kind))
            np.testing.assert_array_equal(at, result.contacts.position[rows].astype(np.float32))
            force = result.contacts.impulse[rows] * FPS
            size = np.linalg.norm(force, axis=1)
            rows, force, size = rows[size > 0], force[size > 0], size[size > 0]
            if not len(rows):
                assert kind not in arrows
                continue
            start, end = arrows[kind][:, 0], arrows[kind][:, 1]
            np.testing.assert_array_equal(start, result.contacts.position[rows].astype(np.float32))
            along = (end - start).astype(np.float64)
            length = np.linalg.norm(along, axis=1)
            np.testing.assert_allclose(length, SHORTEST + TENFOLD * np.log10(size), atol=1e-6)
            np.testing.assert_allclose(along / length[:, None], force / size[:, None], atol=1e-5)
    # A contact without a force is a point, and no arrow.
    near = ContactFrames(result).at(2)
    assert len(near.rows) == 2
    assert len(near.arrows()) == 1


def test_forces_are_impulses_over_the_frame():
    result = spread()
    result.contacts.impulse = np.tile([0.0, 0.5, -2.0], (len(result.contacts.frame), 1))
    frames = ContactFrames(result)
    at = frames.at(0)
    np.testing.assert_allclose(at.force, [[0.0, 0.5 * FPS, -2.0 * FPS]])
    rows = np.concatenate([frames.at(f).rows for f in range(FRAMES)])
    assert rows.tolist() == list(range(len(result.contacts.frame)))


def test_arrows_grow_with_the_logarithm_of_the_force():
    lengths = arrow_lengths(np.array([0.1, 1.0, 10.0, 1000.0, LARGEST, 1e9]))
    expected = SHORTEST + TENFOLD * np.array([0, 0, 1, 3, 4, 4])
    np.testing.assert_allclose(lengths, expected)


def test_hidden_contacts_stay_hidden_and_come_back_at_the_right_frame(stage):
    nodes = ContactNodes(stage._server, stage)
    stage.show(0)
    nodes.visible = False
    stage.show(10)
    assert held(nodes) == ({}, {})
    nodes.visible = True
    points, _ = held(nodes)
    assert set(points) == {SCENE, OBJECT}
    kick = stage.drawing.result.contacts
    row = np.flatnonzero((kick.frame == 10) & (kick.part == JOINT_INDEX["right_foot"]))
    np.testing.assert_array_equal(
        np.concatenate([points[SCENE], points[OBJECT]]), kick.position[row].astype(np.float32)
    )
