"""Our script in the pages of `view` and `play`: keys, time line, comparison, drops, sheet."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest

from halfphysics.viewer import session as do
from halfphysics.viewer.catalog import OWN, Catalog, Choice
from halfphysics.viewer.playground import Playground
from halfphysics.viewer.view import Viewer
from support.browser import CHROMIUM, SIZES, Tab, artefacts, tab
from support.people import along_x
from support.results.small_result import FPS, FRAMES, touched_result

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium, or no playwright"),
]

# Small: a browser that draws in software is slow.
WINDOW = (900, 560)
READY = "Boolean(window.halfphysics && halfphysics.clock.duration > 0)"


def opened(page, served):
    page.page.set_default_timeout(60_000)
    page.open(served.url)
    page.until(lambda: page.evaluate(READY))
    page.until(lambda: page.evaluate("Boolean(__viserMutable.cameraControl)"))
    page.quiet()
    page.until(lambda: served.server.get_clients())
    page.page.wait_for_timeout(500)


@contextlib.contextmanager
def beside(page, size):
    """Another page of the same browser, of its own size."""
    other = Tab(page.page.context.new_page())
    other.size(*size)
    try:
        yield other
    finally:
        other.page.close()


@pytest.fixture(scope="module")
def viewer():
    with Viewer([touched_result()], port=0) as made:
        made.timeline.pause()
        yield made
        assert made._failure is None


@pytest.fixture(scope="module")
def page(viewer, tmp_path_factory):
    folder = tmp_path_factory.mktemp("view")
    with tab(folder, WINDOW) as one:
        opened(one, viewer)
        one.kept = artefacts(folder)
        yield one
        assert one.errors == []


def test_keys_of_view(page, viewer):
    press, timeline = page.page.keyboard.press, viewer.timeline
    press(" ")
    page.until(lambda: timeline.playing)
    press(" ")
    page.until(lambda: not timeline.playing)
    for key, frame in (("Home", 0), ("ArrowRight", 1), ("ArrowLeft", 0), ("End", FRAMES - 1)):
        press(key)
        page.until(lambda frame=frame: timeline.frame() == frame)
        page.until(lambda: abs(page.evaluate("halfphysics.clock.shown") - timeline.time) < 1e-3)
    following = viewer.cameras.following
    press("f")
    page.until(lambda: viewer.cameras.following is not following)
    press("f")
    page.until(lambda: viewer.cameras.following is following)
    (client,) = viewer.server.get_clients().values()
    for key, axis in (("1", 0), ("2", 1), ("3", 2)):
        press(key)

        def seen(axis=axis):
            way = client.camera.position - client.camera.look_at
            return way[axis] / np.linalg.norm(way) > 0.95

        page.until(seen)
    before = client.camera.position
    press("4")
    page.until(lambda: np.linalg.norm(client.camera.position - before) > 0.1)
    press("0")
    press("?")
    assert "Front, Side, Top, Hands" in page.page.inner_text("#hp-help")
    press("?")
    assert not page.page.locator("#hp-help").is_visible()


def test_the_time_line_of_view_has_marks_and_seeks(page, viewer):
    rows = page.page.locator(".hp-row")
    page.until(lambda: rows.count() == 3)
    left, top, right, bottom = page.box("#hp-track")
    page.page.mouse.click(left + 0.5 * (right - left), 0.5 * (top + bottom))
    page.until(lambda: abs(viewer.timeline.time - 0.5 * viewer.timeline.duration) < 0.02)
    page.page.mouse.move(left + 0.2 * (right - left), page.box(".hp-row")[1] + 2)
    assert "right foot – floor 600 N" in page.page.inner_text("#hp-tip")
    page.page.mouse.move(300, 200)
    assert page.page.title() == "the result"


def test_the_skin_of_view_is_coloured(page, viewer):
    viewer.timeline.seek(6 / FPS)
    viewer.changed()
    lit = """(() => {
      let count = 0;
      __viserMutable.nodeRefFromName["/person/0"].traverse((part) => {
        const color = part.isSkinnedMesh && part.geometry.getAttribute("color");
        for (let k = 2; color && k < color.array.length; k += 3) {
          count += Math.abs(color.array[k] - 1) > 0.05;
        }
      });
      return count;
    })()"""
    page.until(lambda: page.evaluate(lit) > 20)
    viewer.do(lambda: setattr(viewer.controls.paint, "visible", False))
    page.until(lambda: page.evaluate(lit) == 0)
    viewer.do(lambda: setattr(viewer.controls.paint, "visible", True))


def test_the_slider_of_view_parts_reference_and_simulated(page, viewer):
    viewer.timeline.seek(viewer.timeline.duration)
    viewer.changed()
    page.page.keyboard.press("2")
    page.page.keyboard.press("c")
    page.until(lambda: viewer.references[0].on)
    pictures = []
    for share in (0.03, 0.9):
        left, top, right, bottom = page.box("#hp-line")
        y = top + 0.8 * (bottom - top)
        page.page.mouse.move(0.5 * (left + right), y)
        page.page.mouse.down()
        page.page.mouse.move(share * WINDOW[0], y, steps=3)
        page.page.mouse.up()
        page.page.wait_for_timeout(1200)
        pictures.append(page.picture()[:, : int(0.6 * WINDOW[0])])
    page.page.screenshot(path=page.kept / "view-compare.png")
    # From the side they are 12 cm apart in depth: the reference is smaller.
    assert (np.abs(pictures[0] - pictures[1]).max(axis=-1) > 25).sum() > 400
    page.page.keyboard.press("c")
    page.until(lambda: not viewer.references[0].on)


def test_files_that_are_dropped_onto_view_are_shown_or_refused(page, viewer, tmp_path):
    said = page.page.locator("#hp-said")
    (tmp_path / "notes.md").write_text("# Notes")
    page.drop(tmp_path / "notes.md")
    page.until(lambda: "notes.md: no known motion format" in said.inner_text())
    assert len(viewer.stages) == 1
    along_x(1.0, 31, 0.0, z=1.0).save(tmp_path / "walk.npz")
    page.drop(tmp_path / "walk.npz")
    page.until(lambda: len(viewer.stages) == 2 and viewer.timeline.duration == pytest.approx(1.0))
    assert viewer.labels == ("first", "walk")
    # The page loads anew, with both.
    page.until(lambda: page.evaluate(f"{READY} && document.title === 'first | walk'"))
    page.until(lambda: page.evaluate("Boolean(__viserMutable.nodeRefFromName['/1/person/0'])"))
    page.page.screenshot(path=page.kept / "view-dropped.png")
    page.page.keyboard.press("c")
    assert page.page.locator("#hp-line span").all_inner_texts() == ["first", "walk"]


def test_keys_and_time_line_of_play(page):
    choice = Choice("kick_ball", OWN, {"speed": 9.0})
    with Playground(Catalog(), choice, port=0) as playground, beside(page, WINDOW) as page:
        session, press = playground.session, page.page.keyboard.press
        for command in (do.Play(False), do.Change("loop", False), do.Restart()):
            playground.post(command)
        opened(page, playground)
        page.until(lambda: session.made == 0)
        press("ArrowRight")
        page.until(lambda: session.made == 1)
        press(" ")
        page.until(lambda: session.made > 30)
        press(" ")
        page.until(lambda: not session.playing)
        now = session.index / session.fps
        page.until(lambda: abs(page.evaluate("halfphysics.clock.shown") - now) < 1e-3)
        # The ball is on the floor from the start.
        page.until(lambda: page.page.locator(".hp-mark").count() > 0)
        press("ArrowLeft")
        assert "cannot go back" in page.page.inner_text("#hp-said")
        following = playground.cameras.following
        press("f")
        page.until(lambda: playground.cameras.following is not following)
        (client,) = playground.server.get_clients().values()
        before = client.camera.position
        press("3")
        page.until(lambda: np.linalg.norm(client.camera.position - before) > 0.1)
        press("?")
        assert "Play or pause" in page.page.inner_text("#hp-help")
        press("Escape")
        press("Home")
        page.until(lambda: session.made == 0)
        assert page.page.title() == "kick_ball | halfphysics play"
        assert page.errors == []


def test_the_sheet_of_a_phone_is_folded_at_first(page, viewer, tmp_path):
    with beside(page, SIZES["phone"]) as page:
        opened(page, viewer)
        button = "button:has-text('Pause'), button:has-text('Play')"
        height = SIZES["phone"][1]
        page.until(lambda: page.box("text='halfphysics'")[1] > 0.7 * height)
        page.page.screenshot(path=artefacts(tmp_path) / "view-phone.png")
        assert page.box("#hp-bar")[3] == height
        page.page.click("text='halfphysics'")
        page.until(lambda: page.box("text='halfphysics'")[1] < 0.5 * height)
        assert page.box(button)[3] < page.box("#hp-bar")[1]
        page.page.click("text='halfphysics'")
        page.until(lambda: page.box("text='halfphysics'")[1] > 0.7 * height)
        assert page.errors == []


def test_a_page_that_stays_open_shows_what_another_server_has(page):
    """Somebody stops `view a.npz` and starts `view b.npz`: both tell of data-1.json."""
    with beside(page, WINDOW) as page:
        with Viewer([touched_result()], labels=["one"], port=0) as first:
            opened(page, first)
            page.until(lambda: page.page.title() == "one")
            port = first.port
        with Viewer([touched_result()], labels=["two"], port=port) as second:
            assert second.port == port
            page.until(lambda: page.page.title() == "two")
            page.until(lambda: page.evaluate(READY))
            page.until(lambda: page.page.locator(".hp-row").count() == 3)


def test_files_of_one_drop_are_all_shown(page, tmp_path):
    names = ("left", "right", "middle")
    for name in names:
        along_x(1.0, 31, 0.0, z=1.0).save(tmp_path / f"{name}.npz")
    with Viewer([touched_result()], port=0) as viewer, beside(page, WINDOW) as page:
        opened(page, viewer)
        page.drop(*(tmp_path / f"{name}.npz" for name in names))
        page.until(lambda: len(viewer.stages) == 4)
        assert viewer.labels == ("first", *names)
        page.until(lambda: page.page.title() == "first | left | right | middle")
