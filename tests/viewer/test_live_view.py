"""`view ws://...` and `play ws://...`: what is sent to browsers, the panel, the hands."""

from __future__ import annotations

import re
import time

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.cli import main
from halfphysics.errors import FileError
from halfphysics.live.client import connect
from halfphysics.live.schema import Add, Drag, Mass
from halfphysics.live.serve import serve
from halfphysics.viewer.live_hands import newest
from halfphysics.viewer.live_view import LiveView, is_address
from support.live_sessions import scene as live_scene
from support.live_sessions import session


@pytest.fixture(scope="module")
def server():
    with session() as one:
        yield one


@pytest.fixture
def view(server):
    with LiveView(server.url, hands=True, port=0) as one:
        yield one


def until(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "too late"
        time.sleep(0.02)


def done(view, task):
    """Run a task in the viewer's thread and wait for it."""
    results = []
    view.do(lambda: results.append(task()))
    until(lambda: results)
    return results[0]


def test_addresses_are_told_from_files():
    assert is_address("ws://127.0.0.1:8765")
    assert is_address("wss://example.org/?token=abc")
    assert not is_address("walk.npz")
    assert not is_address("folder/ws:/walk.npz")


def test_people_and_objects_are_where_the_session_has_them(view):
    frame = view.reader.frame
    done(view, lambda: view._show(frame))
    wanted = view.people[0].frames(frame.poses["person"])[0]
    np.testing.assert_allclose(view.stage.joints()[0], wanted)
    np.testing.assert_allclose(view.stage.object("ball").position, frame.objects["ball"][0])
    assert set(view.stage.layers) == {"body", "ghost", "objects", "scene", "contacts"}


def test_soft_things_dent():
    """A ball sinks into a mattress, and so does what the browser draws of it."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_static("bed", hp.Box((0.6, 0.6, 0.4)), position=(2, 0, 0.2), soft="mattress")
    scene.add_object("ball", hp.Sphere(0.1), mass=5.0, position=(2, 0, 0.51))
    with serve(scene, port=0, fps=30) as server, LiveView(server.url, port=0) as view:
        until(lambda: view.reader.frame.pressures and view.reader.frame.frame > 20)
        frame = view.reader.frame
        done(view, lambda: view._show(frame))
        lowest = frame.objects["ball"][0][2] - 0.1
        now = np.array(view.stage.static("bed").vertices)
        # Of the top, whose edge stays; the ball may have pressed before the view was there.
        now = now[(np.abs(now[:, :2]) < 0.29).all(axis=1) & (now[:, 2] > 0.0)]
        moved = 0.2 - now[:, 2]
        under = moved > 0.5 * moved.max()
        assert np.linalg.norm(now[under, :2], axis=1).max() < 0.1
        # The nearest vertex is up to 3 cm beside the lowest point; edges of 5 cm may put it deeper.
        assert lowest - 0.01 < 0.2 + now[moved.argmax(), 2] < lowest + 0.005


def test_the_panel_tells_of_latency_and_drops(view):
    until(lambda: view.reader.numbers.heard > 5)
    text = "\n".join(view.panel.lines())
    assert view.reader.url in text
    assert "of 30 frames/s heard" in text
    assert "round trip" in text
    assert "ms old" in text
    assert re.search(r"lost \d", text)
    assert "person: waiting" in text


def test_an_object_that_is_added_is_drawn_and_one_that_is_gone_is_not(server, view):
    with connect(server.url) as other:
        other.edit(Add("crate", "box:0.2:0.2:0.2", 2.5, (0.0, 2.0, 1.0)))
        until(lambda: "object/crate" in view.stage.drawing.objects)
        until(lambda: "crate" in view.hands._objects)
        from halfphysics.live.schema import Remove

        other.edit(Remove("crate"))
        until(lambda: "object/crate" not in view.stage.drawing.objects)


def test_hands_change_the_session(server, view):
    view.hands._asked.put(Mass("ball", 2.0))
    until(lambda: any(i.name == "ball" and i.mass == 2.0 for i in view.reader.hello.objects))
    start = view.reader.frame.objects["ball"][0]
    grip = tuple(start.tolist())
    view.hands._asked.put(Drag("ball", grip, grip))
    view.hands._asked.put(Drag("ball", (1.0, 0.5, 0.8)))
    until(lambda: np.linalg.norm(view.reader.frame.objects["ball"][0] - [1.0, 0.5, 0.8]) < 0.03)
    view.hands._asked.put(Drag("ball", None))
    until(lambda: view.reader.frame.objects["ball"][0][2] < 0.2)
    view.hands._asked.put(Mass("moon", 1.0))
    until(lambda: "moon" in view.hands.trouble)


def test_of_moves_and_values_the_newest_counts():
    start = Drag("ball", (0, 0, 0), (0, 0, 0))
    moves = [Drag("ball", (0, 0, k)) for k in range(3)]
    end = Drag("ball", None)
    assert newest([start, *moves, end]) == [start, end]
    assert newest([start, *moves]) == [start, moves[-1]]
    assert newest([Mass("a", 1.0), Mass("a", 2.0), Mass("b", 3.0)]) == [
        Mass("a", 2.0),
        Mass("b", 3.0),
    ]


def test_commands_of_the_page(view):
    view.obey("toggle", None, None)
    assert view.paused
    view.obey("toggle", None, None)
    assert not view.paused
    following = view.cameras.following
    view.obey("follow", None, None)
    until(lambda: view.cameras.following is not following)
    view.obey("preset", "nowhere", None)
    view.obey("seek", 3, None)


@pytest.mark.parametrize("command", ["view", "play"])
def test_an_address_is_alone_and_answers(command, capsys):
    assert main([command, "ws://127.0.0.1:9"]) == 2
    assert "nothing answers there" in capsys.readouterr().err
    assert main([command, "ws://127.0.0.1:9", "ws://127.0.0.1:10"]) == 2
    assert "one live session alone" in capsys.readouterr().err


def test_hands_come_back_with_the_session():
    with session() as one:
        port = one.server.port
        view = LiveView(one.url, hands=True, port=0)
    with view:
        until(lambda: view.reader.trouble)
        view.hands._asked.put(Mass("ball", 3.0))
        until(lambda: view.hands.trouble)
        with serve(live_scene(), port=port, fps=30):
            until(lambda: not view.reader.trouble)
            view.hands._asked.put(Mass("ball", 2.0))
            until(lambda: any(i.mass == 2.0 for i in view.reader.hello.objects))
            until(lambda: not view.hands.trouble)


def test_whoever_looks_does_not_see_the_token():
    secret = "correct-horse-battery"
    with session(token=secret) as one:
        assert secret in one.url
        with LiveView(one.url, port=0) as view:
            said = [*view.panel.lines(), repr(view), str(view.remote._told)]
            address = view.reader.address
    assert all(secret not in text for text in said)
    assert address in said[0]
    with pytest.raises(FileError, match="nothing answers") as raised:
        LiveView(f"ws://127.0.0.1:9/?token={secret}")
    assert secret not in str(raised.value)
