"""Dents of a running simulation: as those of its result, where nobody knew what would press."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.render.result_meshes import Drawing
from halfphysics.viewer.live_dents import MOST_VERTICES, LiveDents, unpressed
from halfphysics.viewer.server import close_server, open_server
from halfphysics.viewer.stage import Stage
from support.results.soft_results import FPS, FRAMES, TOP, soft_result

DIP = 1 + FRAMES // 4


@pytest.fixture(scope="module")
def server():
    made = open_server("127.0.0.1", 0)
    yield made
    close_server(made)


def live(server, prefix):
    """A stage of the bed as a playground has it, and its dents."""
    result = dataclasses.replace(soft_result(), soft_contacts=None)
    vars(result)["dents"] = unpressed(result.scene)
    stage = Stage(server, Drawing(result), prefix=prefix, live=True, dents=False)
    return stage, LiveDents(stage, result.scene, result.names, 1.0 / FPS)


def poses(frame):
    track = soft_result().objects["ball"]
    return {"ball": (track.position[frame], track.quaternion[frame])}


def test_the_bed_dents_as_in_the_result(server):
    stage, dents = live(server, "/live")
    assert len(dents) == 1
    vertices = np.asarray(stage.static("bed").vertices)
    assert len(vertices) < 1.2 * MOST_VERTICES
    for frame in range(DIP + 1):
        dents.show(soft_result().soft_contacts.at(frame), poses(frame))
    now = np.asarray(stage.static("bed").vertices)
    near = np.linalg.norm(vertices[:, :2] - (0.7, 0.35), axis=1) < 0.04
    low = now[near & (vertices[:, 2] > 0.0), 2].min() + TOP / 2
    # Edges of some 5 cm: to be nowhere above the ball, they are up to a centimetre below it.
    assert TOP - 0.065 < low < TOP - 0.045
    assert np.abs(now[vertices[:, 2] < 0.0] - vertices[vertices[:, 2] < 0.0]).max() < 1e-6


def test_nothing_is_sent_while_nothing_presses(server):
    stage, dents = live(server, "/idle")
    before = stage.static("bed").vertices
    dents.show(soft_result().soft_contacts.at(0), poses(0))
    dents.show(None, poses(0))
    assert stage.static("bed").vertices is before


def test_a_hard_scene_has_none():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    assert unpressed(scene) == {}
