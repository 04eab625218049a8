"""The lights of a scene: one key light with shadows, that goes with the people."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.viewer.lights import SUBJECT, Lights
from halfphysics.viewer.server import close_server, open_server


@pytest.fixture(scope="module")
def server():
    made = open_server("127.0.0.1", 0)
    yield made
    close_server(made)


def messages(server):
    return list(server._websock_server.get_message_buffer().message_from_id.values())


def props(server, name):
    return next(m.props for m in messages(server) if getattr(m, "name", "") == name
                and hasattr(m, "props"))  # fmt: skip


def test_only_the_key_light_casts_shadows_and_it_points_at_the_people(server):
    lights = Lights(server, (2.0, -1.0, 0.5), reach=1.5)
    casts = {
        m.name for m in messages(server) if getattr(getattr(m, "props", None), "cast_shadow", False)
    }
    assert casts == {f"{SUBJECT}/key"}
    key = props(server, f"{SUBJECT}/key")
    handle = server.scene._handle_from_node_name[f"{SUBJECT}/key"]
    away = np.asarray(handle.position)
    np.testing.assert_allclose(np.cross(away, key.direction), 0.0, atol=1e-9)
    assert away @ key.direction < 0.0
    # From the camera's side, and its pool reaches beyond the people.
    assert away[:2] @ [2.0, -1.0] > 0.0
    assert np.linalg.norm(away) * np.tan(key.angle) > 1.5 + 5.0
    subject = server.scene._handle_from_node_name[SUBJECT]
    lights.follow(np.array([3.0, -1.0, 0.9]))
    np.testing.assert_allclose(subject.position, [3.0, -1.0, 0.9], atol=1e-3)


def test_nobody_hears_of_a_light_that_stays(server):
    lights = Lights(server)
    lights.follow(np.array([1.0, 2.0, 0.9]))
    before = messages(server)
    lights.follow(np.array([1.0, 2.0, 0.9]))
    assert messages(server) == before


def test_viser_adds_no_lights_of_its_own(server):
    Lights(server)
    kinds = {type(m).__name__: m for m in messages(server)}
    assert kinds["EnableLightsMessage"].enabled is False
    assert kinds["EnvironmentMapMessage"].hdri_data is None
