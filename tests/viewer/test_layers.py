"""The layers of contacts and support: what is there, what starts hidden, when bodies are glass."""

from __future__ import annotations

import pytest

from halfphysics.viewer import support_overlay
from halfphysics.viewer.layers import GLASS, SUPPORT, add_layers, legend, support_legend
from support.results.small_result import small_result

pytest.importorskip("viser")


class Supported:
    """In place of the overlay, whose support the small result does not have."""

    def __init__(self, server, stage):
        self.visible = False


@pytest.fixture
def stage(monkeypatch):
    from halfphysics.viewer.server import close_server, open_server
    from halfphysics.viewer.stage import Stage

    monkeypatch.setattr(support_overlay, "SupportOverlay", Supported)
    server = open_server("127.0.0.1", 0)
    made = Stage(server, small_result())
    add_layers(server, made)
    yield made
    close_server(server)


def test_support_and_glass_start_hidden(stage):
    shown = {name: layer.visible for name, layer in stage.layers.items()}
    assert shown == {
        "body": True, "ghost": True, "objects": True, "scene": True,
        "contacts": True, "touched": False, SUPPORT: False, "glass": False,
    }  # fmt: skip


def test_bodies_are_glass_while_any_layer_asks_for_it(stage):
    pieces = stage.people[0].handles.values()
    for support, glass in [(True, False), (True, True), (False, True), (False, False)]:
        stage.layers[SUPPORT].visible = support
        stage.layers["glass"].visible = glass
        assert {piece.opacity for piece in pieces} == {GLASS if support or glass else None}


def test_legends_name_every_colour():
    assert all(label in support_legend() for _, label in support_overlay.KEY)
    assert "on a person, by the scene" in legend([small_result()])
    assert "on a person, by a person" not in legend([small_result()])
