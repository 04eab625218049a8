"""The viewer in a real browser: it loads, draws, plays, scrubs, and fits a desktop and a phone."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from halfphysics.viewer.view import Viewer
from support.browser import CHROMIUM, SIZES, artefacts, tab
from support.results.small_result import small_result

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium, or no playwright"),
]

BUTTON = "button:has-text('Pause'), button:has-text('Play')"


@pytest.fixture(scope="module")
def viewer():
    result = small_result()
    with Viewer([result, result], labels=["soft", "stiff"], port=0) as made:
        made.timeline.pause()
        yield made


@pytest.fixture(scope="module", params=["desktop", "phone"])
def page(request, viewer, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    viewer.timeline.pause()
    viewer.timeline.seek(0.5)  # where body and ghost are apart
    viewer.changed()
    with tab(folder, SIZES[request.param]) as one:
        one.open(viewer.url)
        one.page.wait_for_selector(BUTTON, timeout=60_000)
        # A message that it draws in software, only in tests.
        notice = one.page.locator("[role=alert] button")
        if notice.count():
            notice.first.click()
        one.name, one.kept = request.param, artefacts(folder)
        unfolded(one)
        one.until(lambda: ghost(scene(one)) > 200)
        yield one
        # In all of this the console had no error.
        assert one.errors == []


def unfolded(page):
    """On a phone the panel is a sheet that is folded at first: unfold it."""
    if page.name != "phone":
        return
    button = page.page.locator(BUTTON).first
    page.until(
        lambda: not button.is_visible() or page.box(BUTTON)[1] > page.page.viewport_size["height"]
    )
    page.page.click("text='halfphysics'")
    page.until(lambda: button.is_visible() and page.box(BUTTON)[3] < 844)


def ghost(picture):
    """The number of pixels in a ghost's blue."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    # Neither the sky's nor a shirt's.
    return ((blue - red > 30) & (blue - green > 18) & (blue < 250) & (blue - red < 140)).sum()


def scene(page):
    """The part of the picture that neither the panel nor the bar covers."""
    page.page.wait_for_timeout(300)
    picture = page.picture()[: int(page.box("#hp-bar")[1])]
    left, top, _, _ = panel(page)
    return picture[:, : int(left)] if page.name == "desktop" else picture[: int(top)]


def panel(page):
    return page.page.evaluate(
        """() => {
          let node = [...document.querySelectorAll('button')].find(
            b => ['Play', 'Pause'].includes(b.innerText.trim()));
          let best = node.getBoundingClientRect();
          for (; node && node !== document.body; node = node.parentElement) {
            const box = node.getBoundingClientRect();
            if (box.width > 450 || box.height > 700) break;
            best = box;
          }
          return [best.left, best.top, best.right, best.bottom];
        }"""
    )


def moved(a, b):
    """The number of pixels that differ clearly."""
    return int((np.abs(a - b).max(axis=-1) > 25).sum())


def test_it_draws_bodies_and_ghosts_and_says_which_is_which(page):
    picture = scene(page)
    page.screenshot(page.kept / f"view-{page.name}.png")
    red, _, blue = np.moveaxis(picture, -1, 0)
    assert picture.std() > 5.0
    assert ghost(picture) > 200
    assert ((red - blue > 12) & (red - blue < 90)).sum() > 200, "no body"
    assert "0.50 s of 0.50 s, frame 15 of 15" in page.page.inner_text("body")


def test_nothing_overlaps_and_everything_is_inside(page):
    width, height = SIZES[page.name]
    boxes = {}
    for name in ("Time [s]", "Step", "Speed", "Loop"):
        left, top, right, bottom = page.box(f"text='{name}'")
        boxes[name] = top, bottom
        assert 0 <= left < right <= width
        assert 0 <= top < bottom <= height
    boxes["play"] = page.box(BUTTON)[1::2]
    rows = sorted(boxes.values())
    for (_, bottom), (top, _) in pairwise(rows):
        assert top >= bottom - 1.0, f"rows overlap: {boxes}"
    steps = [page.box(f"text='{t}'") for t in ("Start", "◀", "▶")]
    assert len({round(top) for _, top, _, _ in steps}) == 1, "the step buttons wrap"
    left, top, _, _ = panel(page)
    free = left / width if page.name == "desktop" else top / height
    assert free > (0.7 if page.name == "desktop" else 0.3), "the panel hides the scene"


def test_play_moves_the_body_and_pause_stops_it(page, viewer):
    viewer.timeline.loop = True
    before = scene(page)
    page.page.click(BUTTON)
    page.until(lambda: viewer.timeline.playing)
    page.until(lambda: moved(scene(page), before) > 40)
    page.until(lambda: "Pause" in page.page.inner_text(BUTTON))
    page.page.click(BUTTON)
    page.until(lambda: not viewer.timeline.playing)
    page.until(lambda: "Play" in page.page.inner_text(BUTTON))
    page.page.wait_for_timeout(1500)
    still = scene(page)
    page.page.wait_for_timeout(800)
    assert moved(scene(page), still) < 10


def test_scrub_goes_to_the_moment(page, viewer):
    viewer.timeline.pause()
    viewer.timeline.seek(0.0)
    viewer.changed()
    page.until(lambda: "0.00 s of" in page.page.inner_text("body"))
    before = scene(page)
    slider = page.page.locator("[role=slider]").first
    slider.focus()
    slider.press("End")
    page.until(lambda: viewer.timeline.frame() == 15)
    page.until(lambda: moved(scene(page), before) > 60)
    page.until(lambda: "0.50 s of 0.50 s, frame 15 of 15" in page.page.inner_text("body"))
    page.screenshot(page.kept / f"view-{page.name}-end.png")


def test_steps_go_frame_by_frame(page, viewer):
    page.page.click("text='Start'")
    page.until(lambda: viewer.timeline.frame() == 0)
    page.page.click("text='▶'")
    page.until(lambda: viewer.timeline.frame() == 1)
    page.until(lambda: "frame 1 of 15" in page.page.inner_text("body"))
    page.page.click("text='◀'")
    page.until(lambda: viewer.timeline.frame() == 0)


def test_layers_and_results_can_be_hidden(page, viewer):
    if page.name == "phone":
        pytest.skip("the unfolded sheet covers the people")
    viewer.timeline.seek(0.5)
    viewer.changed()
    page.page.click("text='Show'")
    page.page.wait_for_selector("text='Ghost'")
    page.page.wait_for_timeout(600)
    page.until(lambda: "0.50 s of 0.50 s, frame 15 of 15" in page.page.inner_text("body"))
    page.page.wait_for_timeout(1500)  # drawn in software, it is late
    page.until(lambda: ghost(scene(page)) > 200)
    page.screenshot(page.kept / f"view-{page.name}-layers.png")
    shown = ghost(scene(page))
    ghosts = page.page.get_by_role("checkbox", name="Ghost")
    ghosts.click()
    page.until(lambda: not viewer.stages[0].layers["ghost"].visible)
    page.until(lambda: ghost(scene(page)) < 0.3 * shown)
    ghosts.click()
    page.until(lambda: ghost(scene(page)) > 0.7 * shown)
    named = scene(page)
    page.page.get_by_role("checkbox", name="Names").click()
    page.until(lambda: not viewer.stages[0].layers["label"].visible)
    page.until(lambda: moved(scene(page), named) > 40)
    page.page.get_by_role("checkbox", name="Names").click()
    page.until(lambda: viewer.stages[0].layers["label"].visible)
    page.page.get_by_role("checkbox", name="stiff").click()
    page.until(lambda: not viewer.stages[1].visible)
    page.until(lambda: ghost(scene(page)) < 0.8 * shown)
    page.page.get_by_role("checkbox", name="stiff").click()
    page.until(lambda: viewer.stages[1].visible)
    page.page.click("text='Show'")
