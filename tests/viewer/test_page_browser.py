"""The one-file page in a real browser, from its file: it draws, plays, scrubs, fits a phone."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from halfphysics.viewer.page import save_page
from support.browser import CHROMIUM, SIZES, artefacts, tab
from support.results.small_result import FPS, FRAMES, small_result

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium, or no playwright"),
]

TIME = "input[inputmode=decimal]"
BAR = ".mantine-Slider-root"
SPEED = ".mantine-Select-wrapper"


@pytest.fixture(scope="module")
def story(tmp_path_factory):
    return save_page(small_result(), tmp_path_factory.mktemp("page") / "story.html", title="A walk")


@pytest.fixture(scope="module", params=["desktop", "phone"])
def page(request, story, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    with tab(folder, SIZES[request.param]) as one:
        one.page.set_default_timeout(120_000)  # a browser that draws in software is slow
        one.open(story)
        one.page.wait_for_selector(TIME)
        # A message that it draws in software, only in tests.
        notice = one.page.locator("[role=alert] button")
        if notice.count():
            notice.first.click()
        one.name, one.width, one.height = request.param, *SIZES[request.param]
        one.kept = artefacts(folder)
        yield one
        assert one.errors == []
        # Only the page itself was requested.
        outside = [r for r in one.requests if not r.startswith(("file:", "data:", "blob:"))]
        assert outside == []
        assert {r.split("?")[0] for r in one.requests if r.startswith("file:")} == {story.as_uri()}


def at(page, time, shows=lambda picture: True):
    """Go to a time [s] and wait until the scene shows that time; the page pauses."""

    def there():
        # Repeat a lost command: a page that is still loading starts to play when it is done.
        page.page.fill(TIME, f"{time:.1f}")
        return shows(scene(page))

    page.until(there, seconds=120.0)


def scene(page):
    """The part of the picture above the key."""
    return page.picture()[: int(page.box("#key")[1])]


def blue(picture):
    """The number of ghost pixels."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    return int(((blue - red > 30) & (green > red)).sum())


def skin(picture):
    """The number of body pixels."""
    red, _, blue = np.moveaxis(picture, -1, 0)
    return int(((red - blue > 12) & (red - blue < 90)).sum())


def together(picture):
    """Body and ghost coincide: the body hides the ghost."""
    return skin(picture) > 100 and blue(picture) < 300


def apart(picture):
    """Body and ghost side by side."""
    return skin(picture) > 100 and blue(picture) > 600


def test_scrubbing_moves_body_and_ghost_apart_and_back(page):
    at(page, 0.0, together)
    at(page, (FRAMES - 1) / FPS, apart)
    page.page.screenshot(path=page.kept / f"page-{page.name}.png")
    at(page, 0.0, together)


def test_playing_moves_the_bar(page):
    place = "node => node.querySelector('[role=slider]').getAttribute('aria-valuenow')"
    at(page, 0.0)
    bar = page.page.locator(BAR)
    assert float(bar.evaluate(place)) == 0.0
    page.page.locator("button:has(.tabler-icon-player-play-filled)").click()
    page.until(lambda: 0.0 < float(bar.evaluate(place)) <= FRAMES / FPS)
    page.page.locator("button:has(.tabler-icon-player-pause-filled)").click()


def test_nothing_overlaps_and_all_is_in_the_window(page):
    boxes = [page.box(s) for s in ("#key", TIME, BAR, SPEED)]
    for left, top, right, bottom in boxes:
        assert 0 <= left < right <= page.width
        assert 0 <= top < bottom <= page.height
    key, *controls = boxes
    assert all(key[3] < top for _, top, _, _ in controls)
    for one, other in itertools.pairwise(controls):
        assert one[2] <= other[0]
    # Text as large as a page's, none of it cut off.
    cut = "node => [node.scrollWidth - node.clientWidth, getComputedStyle(node).fontSize]"
    for selector in ("#key", f"{SPEED} input"):
        over, size = page.page.locator(selector).first.evaluate(cut)
        assert over <= 0, selector
        assert float(size.removesuffix("px")) >= 11, selector
