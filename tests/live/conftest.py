"""Sessions and servers of a small scene."""

from __future__ import annotations

import pytest

import halfphysics as hp
from halfphysics.live.safety import Gate
from halfphysics.live.server import Server
from halfphysics.live.session import Session


@pytest.fixture
def scene():
    made = hp.Scene()
    made.add_static("floor", hp.Plane())
    made.add_static("wall", hp.Box((0.2, 4, 2)), position=(2.0, 0, 1))
    made.add_object("ball", hp.Sphere(0.1), mass=1.0, position=(1.0, 1.0, 0.1))
    return made


@pytest.fixture
def session(scene):
    """A session of two people that is not running."""
    made = Session(scene, body=[hp.Body.default()] * 2)
    yield made
    made.stop()


@pytest.fixture
def server(session):
    """A server of a running session."""
    made = Server(session, Gate("127.0.0.1"), 0, {"/": ("text/html", b"<html>hello")})
    made.start()
    session.start()
    yield made
    made.stop()
