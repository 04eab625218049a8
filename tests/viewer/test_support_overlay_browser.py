"""The support in a real browser: one click shows it, with its plot and its legend."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.viewer.view import Viewer
from support.browser import CHROMIUM, artefacts, tab
from support.standing import ARMS_DOWN, still

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium, or no playwright"),
]


def test_support_is_shown_when_asked(tmp_path):
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    result = hp.simulate(still(hp.Body.default(), ARMS_DOWN), scene)
    with Viewer([result], port=0) as viewer, tab(tmp_path) as page:
        viewer.timeline.pause()
        page.open(viewer.url)
        page.page.wait_for_selector("button:has-text('Play')", timeout=60_000)

        def says(words):
            return words in page.page.inner_text("body")

        page.page.click("text='Show'")
        page.page.wait_for_timeout(600)
        before = page.picture()
        page.page.get_by_role("checkbox", name="Support").click()
        page.until(lambda: says("centre of pressure"))
        page.until(lambda: (np.abs(page.picture() - before).max(axis=-1) > 25).sum() > 2000)
        assert all(h.opacity < 1.0 for h in viewer.stages[0].people[0].handles.values())
        page.page.click("text='Show'")
        page.page.click("text='Plots'")
        page.until(lambda: says("Held up [% of the weight]"))
        page.screenshot(artefacts(tmp_path) / "view-support.png")
        assert page.errors == []
