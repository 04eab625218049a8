"""The wire to the script in a browser, without a browser."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import pytest

from halfphysics.viewer import remote as module
from halfphysics.viewer.remote import Remote


class Gui:
    """A panel that keeps its text fields."""

    def __init__(self):
        self.fields = {}

    def add_text(self, label, value, *, visible):
        assert not visible
        field = self.fields[label.rpartition("-")[2]] = SimpleNamespace(value=value)
        field.on_update = lambda call: setattr(field, "call", call)
        return field


def said(fields):
    """What browsers have been told, beside the name of the scene."""
    told = json.loads(fields["in"].value)
    assert told.pop("scene")
    return told


@pytest.fixture
def wire():
    gui, heard = Gui(), []
    remote = Remote(gui, lambda *command: heard.append(command))
    return remote, gui.fields, heard


def test_commands_come_with_their_browser_and_all_else_is_ignored(wire):
    remote, _, heard = wire
    for text in (
        '{"do": "seek", "to": 1.5}',
        "",
        "{",
        "[]",
        '{"do": 3}',
        '{"to": 1}',
        '"do"',
        "[" * 100_000,
    ):
        remote.obey(text, "client")
    assert heard == [("seek", 1.5, "client")]
    remote.obey(f'{{"do": "step", "to": 1{"0" * 400}}}', "client")  # as a float: an overflow
    assert heard[1:] == [("step", math.inf, "client")]


def test_commands_are_heard_from_browsers_only(wire):
    import asyncio

    _, fields, heard = wire
    for client in (None, 3):
        target = SimpleNamespace(value='{"do": "toggle"}')
        event = SimpleNamespace(client_id=client, client=client, target=target)
        asyncio.run(fields["out"].call(event))
    assert heard == [("toggle", None, 3)]


def test_what_is_told_stays_and_is_sent_once(wire):
    remote, fields, _ = wire
    remote.tell(clock={"time": 1.0})
    remote.tell(paint=True)
    assert said(fields) == {"clock": {"time": 1.0}, "paint": True}
    fields["in"].value = "seen"
    remote.tell(paint=True)
    assert fields["in"].value == "seen"
    remote.tell_now(points=[[1]])
    assert json.loads(fields["now"].value) == {"points": [[1]]}


def test_a_sentence_is_taken_back(wire, monkeypatch):
    remote, fields, _ = wire
    now = [10.0]
    monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: now[0]))
    remote.say("Reading ...")
    now[0] += 0.5
    remote.tell(paint=True)
    assert said(fields)["say"] == "Reading ..."
    now[0] += 1.0
    remote.tell(paint=True)
    assert said(fields) == {"paint": True}


def test_every_scene_has_a_name_of_its_own(wire):
    """A page that stays open must notice that another server answers, or a scene built anew."""
    names = set()
    for _ in range(3):
        gui = Gui()
        remote = Remote(gui, print)
        for paint in (True, False):
            remote.tell(paint=paint)
            names.add(json.loads(gui.fields["in"].value)["scene"])
    assert len(names) == 3
