"""A live session in a real browser: people and objects move, the ball is dragged by the pointer."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.viewer.live_view import LiveView
from support.browser import CHROMIUM, artefacts, tab
from support.live_sessions import session

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium, or no playwright"),
]


@pytest.fixture(scope="module")
def server():
    with session() as one:
        yield one


@pytest.fixture(scope="module")
def view(server):
    with LiveView(server.url, hands=True, port=0) as one:
        yield one


@pytest.fixture(scope="module")
def page(view, tmp_path_factory):
    folder = tmp_path_factory.mktemp("live")
    with tab(folder, (840, 560)) as one:
        one.page.set_default_timeout(60_000)
        one.open(view.url)
        one.until(lambda: one.evaluate("Boolean(window.halfphysics?.clock.live)"))
        one.until(lambda: view.shown > 3)
        one.quiet()
        one.kept = artefacts(folder)
        yield one
        # viser's own, as in `play`
        assert [e for e in one.errors if "passive event listener" not in e] == []


def place(page, name):
    """Where a node is drawn [m]."""
    return np.array(
        page.evaluate(
            f"(() => {{ const n = __viserMutable.nodeRefFromName[{name!r}];"
            "return n ? n.position.toArray() : [0, 0, 0]; })()"
        )
    )


def test_objects_are_drawn_where_they_are(view, page):
    path = view.stage.path("object/ball")
    page.until(
        lambda: np.allclose(place(page, path), view.reader.frame.objects["ball"][0], atol=0.01)
    )
    text = page.page.text_content("body")
    assert "frames/s heard" in text
    assert "person: waiting" in text
    page.page.screenshot(path=page.kept / "live-view.png")


def test_pause_holds_the_picture_and_not_the_session(view, page):
    page.page.keyboard.press(" ")
    page.until(lambda: view.paused)
    shown, frame = view.shown, view.reader.frame.frame
    page.until(lambda: view.reader.frame.frame > frame + 20)
    assert view.shown <= shown + 1
    page.page.keyboard.press(" ")
    page.until(lambda: view.shown > shown + 1)


def test_the_ball_is_dragged(view, page):
    start = view.reader.frame.objects["ball"][0]
    look = [float(x) for x in start]

    def aim():
        view.cameras.following = False
        for client in view.server.get_clients().values():
            client.camera.position = (look[0] + 2.0, look[1] + 2.0, 1.2)
            client.camera.look_at = tuple(look)

    view.do(aim)
    page.page.wait_for_timeout(2000)
    box = page.evaluate(
        "(() => { const b = __viserMutable.canvas.getBoundingClientRect();"
        "return [b.left + b.width / 2, b.top + b.height / 2]; })()"
    )
    mouse = page.page.mouse
    mouse.move(*box)
    mouse.down()
    page.page.wait_for_timeout(300)
    mouse.move(box[0], box[1] - 90, steps=6)
    page.until(lambda: view.reader.frame.objects["ball"][0][2] > start[2] + 0.2, 60)
    mouse.up()
    page.until(lambda: view.reader.frame.objects["ball"][0][2] < start[2] + 0.05, 60)
