"""The test page of the client in a real browser: served by the server, and opened from disk."""

from __future__ import annotations

import pytest

from halfphysics import scenarios
from halfphysics.live.serve import serve
from support.browser import CHROMIUM, artefacts, tab
from support.paths import ROOT

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium, or no playwright"),
]
PAGE = ROOT / "src" / "halfphysics" / "live" / "page.html"


@pytest.fixture(scope="module")
def server():
    story = scenarios.load("kick_ball")
    options = {"body": story.body, "start": [story.motion[0]], "settings": story.settings}
    with serve(story.scene, port=0, fps=30, origins=["null"], **options) as one:
        yield one


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with tab(tmp_path_factory.mktemp("live"), (840, 560)) as one:
        one.kept = artefacts(tmp_path_factory.mktemp("pictures"))
        yield one
        assert one.errors == []


def frames(browser, least):
    browser.until(
        lambda: browser.evaluate(f"(window.live?.client?.stats.frames ?? 0) >= {least}"), 30
    )


def test_the_server_sends_the_page_which_shows_the_session(server, browser):
    browser.open(f"http://127.0.0.1:{server.server.port}/")
    frames(browser, 30)
    browser.until(lambda: "of 30 frames/s" in browser.page.text_content("#rate"), 30)
    browser.until(lambda: browser.page.text_content("#late").endswith("ms"), 30)
    assert browser.page.text_content("#said") == ""
    assert "person: waiting" in browser.page.text_content("#people")
    browser.page.screenshot(path=browser.kept / "live-page.png")
    # The figure is drawn: strokes in the first person's colour.
    colored = browser.evaluate(
        "(() => { const c = document.getElementById('scene'); const d = c.getContext('2d')"
        ".getImageData(0, 0, c.width, c.height).data; let n = 0; for (let k = 0; k < d.length; "
        "k += 4) n += d[k] === 31 && d[k + 1] === 117 && d[k + 2] === 110; return n; })()"
    )
    assert colored > 2000


def test_the_ball_is_dragged(server, browser):
    ball = "live.frame.objects.ball.position"
    browser.evaluate(
        f"(live.camera.following = false, live.camera.distance = 12, "
        f"live.camera.target = {ball}.slice())"
    )
    x, y = browser.evaluate(
        f"(() => {{ const p = live.camera.project({ball}); return [p.x, p.y]; }})()"
    )
    before = browser.evaluate(ball)
    mouse = browser.page.mouse
    mouse.move(x, y)
    mouse.down()
    mouse.move(x, y - 60, steps=5)
    browser.until(lambda: browser.evaluate(ball)[2] > before[2] + 0.3, 30)
    mouse.up()
    browser.until(lambda: browser.evaluate(ball)[2] < before[2] + 0.05, 30)
    assert browser.page.text_content("#said") == ""


def test_the_page_from_disk(server, browser):
    browser.open(f"{PAGE.as_uri()}?server=ws://127.0.0.1:{server.server.port}")
    frames(browser, 30)
    assert browser.page.text_content("#said") == ""
