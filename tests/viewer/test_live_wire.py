"""The marks of a running simulation, and what its page is told."""

from __future__ import annotations

import json
import time

import numpy as np
import pytest

from halfphysics.viewer import session as do
from halfphysics.viewer.catalog import OWN, Catalog, Choice
from halfphysics.viewer.live_wire import LiveMarks
from halfphysics.viewer.playground import Playground


def test_marks_are_runs_of_frames_with_their_largest_force():
    marks = LiveMarks(10, 10.0)
    for frame in (3, 4, 5):
        marks.add(frame, np.array([0, 0, 1]), np.array([5.0 * frame, 1.0, 0.5]))  # 1: below 1 N
    marks.add(8, np.array([0]), np.array([2.0]))
    row, *others = marks.rows()
    assert row.label == "contact with the scene"
    # Nobody else is there to be touched; objects may yet be.
    assert [(other.label, other.marks) for other in others] == [
        ("contact with an object", ()),
        ("contact of objects", ()),
    ]
    assert len(LiveMarks(10, 10.0, people=2).rows()) == 4
    spans = [(m.start, m.end, m.text) for m in row.marks]
    assert spans == [(0.2, 0.5, "up to 25 N"), (0.7, 0.8, "up to 2 N")]
    # The next loop makes frame 4 anew, without a contact.
    marks.add(4, np.array([], dtype=int), np.array([]))
    spans = [(m.start, m.end) for m in marks.rows()[0].marks]
    assert spans == [(0.2, 0.3), (0.4, 0.5), (0.7, 0.8)]


@pytest.fixture(scope="module")
def playground():
    with Playground(Catalog(), Choice("kick_ball", OWN, {"speed": 9.0}), port=0) as running:
        running.post(do.Play(False))
        yield running
        assert running._failure is None


def told(playground):
    return json.loads(playground.wire.remote._tells.value)


def until(condition):
    end = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_the_page_is_told_who_plays_and_obeys(playground):
    wire, session = playground.wire, playground.session
    until(lambda: not session.playing)
    said = told(playground)
    assert said["data"]["title"] == "kick_ball | halfphysics play"
    assert said["data"]["people"] == [figure.name for figure in playground.stage.people]
    made = session.made
    wire.obey("step", 1, None)
    until(lambda: session.made > made)
    now = pytest.approx(session.index / session.fps, abs=1e-4)  # its digits
    until(lambda: told(playground)["clock"]["time"] == now)
    assert told(playground)["clock"]["live"]
    wire.obey("seek", 1.0, None)  # a simulation cannot go there
    until(lambda: "cannot go" in told(playground).get("say", ""))
    wire.obey("seek", 0, None)
    until(lambda: session.made == 0)
    wire.obey("speed", 100, None)
    until(lambda: session.speed == do.SPEEDS[1])
    for nonsense in ("speed", "preset", "nothing"):
        wire.obey(nonsense, {"a": 1}, None)
    following = playground.panel.following
    wire.obey("follow", None, None)
    until(lambda: playground.cameras.following is not following)
