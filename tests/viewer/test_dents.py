"""Dents in the browser: vertices that a server sends, and the numbers of a page."""

from __future__ import annotations

import base64
import dataclasses
import zlib

import numpy as np
import pytest

from halfphysics.viewer.dents import TOLERANCE, WAY_GRAIN, dent_document, own_vertices
from halfphysics.viewer.page import save_page
from halfphysics.viewer.server import close_server, open_server
from halfphysics.viewer.stage import Stage
from support.reels import data_of
from support.results.soft_results import FRAMES, TOP, soft_result

DIP = 1 + FRAMES // 4


@pytest.fixture(scope="module")
def server():
    made = open_server("127.0.0.1", 0)
    yield made
    close_server(made)


@pytest.fixture(scope="module")
def stage(server):
    return Stage(server, soft_result(), prefix="/soft")


def whole(text, kind):
    """What `packed` packed: the lowest bytes of all numbers come first."""
    data = np.frombuffer(zlib.decompress(base64.b64decode(text)), dtype=np.uint8)
    size = np.dtype(kind).itemsize
    return np.ascontiguousarray(data.reshape(size, -1).T).view(kind).ravel()


def shown(stage):
    """Height of the lowest vertex of the bed's top under the ball, in the world [m]."""
    vertices = np.asarray(stage.static("bed").vertices)
    near = np.linalg.norm(vertices[:, :2] - (0.7, 0.35), axis=1) < 0.02
    return vertices[near & (vertices[:, 2] > 0.0), 2].min() + TOP / 2


def test_a_frame_sends_the_vertices_that_it_has(stage):
    stage.show(0)
    assert shown(stage) == pytest.approx(TOP, abs=1e-6)
    stage.show(DIP)
    assert shown(stage) == pytest.approx(TOP - 0.05, abs=1e-3)
    before = stage.static("bed").vertices
    stage.show(DIP)
    assert stage.static("bed").vertices is before, "sent again"
    stage.show(0)
    assert shown(stage) == pytest.approx(TOP, abs=1e-6)


def test_a_hard_scene_sends_none(server):
    hard = dataclasses.replace(soft_result(), soft_contacts=None)
    stage = Stage(server, hard, prefix="/hard")
    assert stage.soft_items() == []
    assert stage.followers == []


def test_the_document_gives_every_vertex_of_every_frame(server):
    stage = Stage(server, soft_result(), prefix="/page", dents=False)
    (one,) = dent_document(stage, 1)
    (node,), dent = stage.soft_items(), soft_result().dents["bed"]
    assert one["node"] == "/page/static/bed"
    own = own_vertices(node.surface, node.handle)
    assert one["count"] == len(own)
    at = np.cumsum(whole(one["at"], "<i4"))
    way = WAY_GRAIN * whole(one["way"], "<i2").reshape(-1, 3)
    depth = whole(one["depth"], "<i2").reshape(one["rows"], -1)
    weight = whole(one["weight"], "<i2").reshape(-1, one["rows"])
    assert len(weight) == FRAMES
    for frame in range(FRAMES):
        given = np.maximum(weight[frame] @ (depth * one["unit"] / 32767.0), 0.0)
        vertices = dent.layer.surface[own].copy()
        vertices[at] += given[:, None] * way
        # The numbers of a page are rounded: to 1/32767 of the deepest, to a grain of the way.
        assert np.abs(vertices - dent.at(frame)[own]).max() < 1.5 * TOLERANCE


def test_a_page_that_skips_frames_has_theirs(server):
    stage = Stage(server, soft_result(), prefix="/skip", dents=False)
    (one,) = dent_document(stage, 3)
    assert len(whole(one["weight"], "<i2")) == one["rows"] * len(range(0, FRAMES, 3))


def test_a_page_grows_by_less_than_a_tenth(tmp_path):
    """The dents of a bed take 100 kB; those of a hard result nothing."""
    soft = save_page(soft_result(), tmp_path / "soft.html")
    hard = save_page(dataclasses.replace(soft_result(), soft_contacts=None), tmp_path / "hard.html")
    assert data_of(hard)["dents"] == []
    assert len(str(data_of(soft)["dents"])) < 100_000
    # The finer mesh of the bed itself is the rest.
    assert soft.stat().st_size < 1.15 * hard.stat().st_size
