"""Nodes of many copies and arrows: what they hold, and that nothing is sent twice."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.viewer.batches import Arrows, Copies, ball, disc

pytest.importorskip("viser")

COLOR = (0.2, 0.4, 0.6)


@pytest.fixture(scope="module")
def server():
    from halfphysics.viewer.server import close_server, open_server

    server = open_server("127.0.0.1", 0)
    yield server
    close_server(server)


def test_copies_are_as_many_as_positions_and_hidden_without(server):
    copies = Copies(server, "/copies", ball(0.1), COLOR)
    assert not copies.handle.visible
    points = np.arange(12.0).reshape(4, 3)
    copies.show(points)
    assert copies.handle.visible
    np.testing.assert_array_equal(copies.handle.batched_positions, points)
    np.testing.assert_array_equal(copies.handle.batched_wxyzs, np.tile([1.0, 0, 0, 0], (4, 1)))
    turns = np.tile([0.0, 1.0, 0.0, 0.0], (2, 1))
    copies.show(points[:2], turns)
    assert len(copies.handle.batched_positions) == 2
    np.testing.assert_array_equal(copies.handle.batched_wxyzs, turns)
    copies.show(np.zeros((0, 3)))
    assert not copies.handle.visible


def test_arrows_start_and_end_where_they_are_told(server):
    arrows = Arrows(server, "/arrows", COLOR)
    assert not arrows.handle.visible
    segments = np.arange(18.0).reshape(3, 2, 3)
    arrows.show(segments)
    assert arrows.handle.visible
    np.testing.assert_array_equal(arrows.handle.points, segments)
    arrows.hide()
    assert not arrows.handle.visible
    arrows.show(segments[:1])
    arrows.show(segments[:0])
    assert not arrows.handle.visible


def test_a_state_that_is_kept_is_not_sent(server, monkeypatch):
    arrows = Arrows(server, "/quiet", COLOR)
    sent = []
    monkeypatch.setattr(
        type(arrows.handle),
        "__setattr__",
        lambda handle, name, value: sent.append(name) or object.__setattr__(handle, name, value),
    )
    arrows.hide()
    arrows.show(np.zeros((0, 2, 3)))
    assert sent == []


@pytest.mark.parametrize(("mesh", "half"), [(ball(0.2), (0.2,) * 3), (disc(0.3, 0.02), None)])
def test_meshes_are_about_the_origin(mesh, half):
    vertices, faces = mesh
    half = (0.3, 0.3, 0.01) if half is None else half
    assert np.abs(vertices).max(axis=0) == pytest.approx(half, rel=0.02)
    assert faces.max() == len(vertices) - 1
