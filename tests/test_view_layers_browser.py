"""The viewer's layers in a real browser: they are seen, and the line of the plots is on time."""

from __future__ import annotations

import numpy as np
import pytest
from browser import CHROMIUM, SIZES, artefacts, tab
from small_result import small_result

from halfphysics.viewer.view import Viewer

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium, or no playwright")


@pytest.fixture(scope="module")
def viewer():
    with Viewer([small_result()], port=0) as made:
        made.timeline.pause()
        made.timeline.seek(6 / made.timeline.fps)  # the shoulder touches the wall
        yield made


@pytest.fixture(scope="module", params=["desktop", "phone"])
def page(request, viewer, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    with tab(folder, SIZES[request.param]) as one:
        one.open(viewer.url)
        one.page.wait_for_selector("text='Numbers'", timeout=60_000)
        notice = one.page.locator("[role=alert] button")
        if notice.count():
            notice.first.click()
        one.kept, one.name = artefacts(folder), request.param
        one.until(lambda: one.picture().std() > 5.0)
        yield one
        assert one.errors == []


def patches(picture):
    """Pixels of the two ends of the ramp of forces: much redder than any skin."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    return int(((red > 90) & (red - blue > 90) & (red - green > 40)).sum())


def test_touched_parts_are_coloured_and_the_layer_switches_them(page, viewer):
    page.until(lambda: patches(page.picture()) > 15)
    viewer.do(lambda: setattr(viewer.stages[0].layers["touched"], "visible", False))
    coloured = patches(page.picture())
    page.until(lambda: patches(page.picture()) < coloured)
    viewer.do(lambda: setattr(viewer.stages[0].layers["touched"], "visible", True))
    page.until(lambda: patches(page.picture()) >= coloured)


def test_the_line_stands_at_the_time_in_every_plot(page, viewer):
    page.page.click("text='Plots'")
    page.page.wait_for_selector(".u-over")
    for frame in (6, 12):
        viewer.timeline.seek(frame / viewer.timeline.fps)
        viewer.changed()
        page.page.wait_for_timeout(1200)
        # Where the charts themselves have that time, and where the lines are [pixels].
        wanted, there = page.evaluate(
            """time => {
              const charts = Object.values(window.__viserTestpoints.uplots).map(u => u.chart);
              const want = charts.map(c =>
                c.over.getBoundingClientRect().left + c.valToPos(time, 'x'));
              const lines = [...document.querySelectorAll('div')].filter(
                d => d.style.backgroundColor === 'rgb(224, 49, 49)');
              const boxes = lines.map(d => d.getBoundingClientRect());
              const overs = charts.map(c => c.over.getBoundingClientRect());
              const inside = boxes.every(b => overs.some(
                o => Math.abs(b.top - o.top) < 3 && Math.abs(b.bottom - o.bottom) < 3));
              return [want, [...boxes.map(b => b.left + 1), inside]];
            }""",
            frame / viewer.timeline.fps,
        )
        assert len(wanted) == 3
        assert there.pop() is True, "a line is not as high as its plot"
        np.testing.assert_allclose(sorted(there), sorted(wanted), atol=1.6)
    page.screenshot(page.kept / f"view-plots-{page.name}.png")
    page.page.click("text='Plots'")


def test_numbers_are_those_of_the_frame(page, viewer):
    page.page.click("text='Numbers'")
    viewer.timeline.seek(6 / viewer.timeline.fps)
    viewer.changed()
    page.until(lambda: "frame 6 of 15, 0.20 s" in page.page.inner_text("body"))
    text = page.page.inner_text("body")
    assert "right shoulder on wall" in text
    assert "90.0 N" in text
    page.screenshot(page.kept / f"view-numbers-{page.name}.png")
    page.page.click("text='Numbers'")


def test_a_preset_moves_this_browsers_camera(page, viewer):
    before = page.picture()
    page.page.click("text='Camera'")
    page.page.wait_for_selector("text='Side'")
    page.page.click("text='Side'")
    page.until(lambda: (np.abs(page.picture() - before).max(axis=-1) > 25).mean() > 0.05)
    page.page.click("text='Camera'")
