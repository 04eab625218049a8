"""Dents of a page in a real browser: its vertices are those of the result."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from halfphysics.viewer.page import save_page
from support.browser import CHROMIUM, tab
from support.results.soft_results import FPS, FRAMES, soft_result

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium, or no playwright"),
]


def test_the_bed_of_a_page_dents(tmp_path):
    path = save_page(soft_result(), tmp_path / "bed.html")
    dent = soft_result().dents["bed"]
    with tab(tmp_path, (480, 320)) as one:
        one.page.set_default_timeout(60_000)
        one.open(path)
        one.until(
            lambda: one.evaluate("Boolean(window.halfphysics && halfphysics.reel.shown >= 0)")
        )
        one.quiet()
        for frame in (1 + FRAMES // 4, FRAMES - 1, 0):
            time = (frame + 0.1) / FPS
            one.evaluate(f"halfphysics.clock.playing = false; halfphysics.clock.seek({time})")
            one.until(lambda wanted=frame: one.evaluate("halfphysics.dents.shown") == wanted)
            flat = one.evaluate(
                "(() => { const one = halfphysics.dents.things[0]; return Array.from("
                "halfphysics.dents.mesh(one).geometry.getAttribute('position').array); })()"
            )
            vertices = np.array(flat).reshape(-1, 3)
            far = cKDTree(dent.at(frame)).query(vertices)[0]
            assert far.max() < 1e-3
            assert abs(vertices[:, 2].max() - 0.2) < 1e-4
        assert one.errors == []
