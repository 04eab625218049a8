"""The picture of a page until the browser has drawn its own: what it shows, and where."""

from __future__ import annotations

import base64
import io
import re

import numpy as np
import pytest

from halfphysics.render.look import DARK, LIGHT
from halfphysics.render.result_meshes import Drawing
from halfphysics.render.viewpoint import FOV
from halfphysics.viewer.arrange import arrange
from halfphysics.viewer.first_picture import SIZE, first_picture, with_first_picture
from support.results.small_result import small_result


@pytest.fixture(scope="module")
def made():
    drawings = [Drawing(small_result())]
    row = arrange(drawings, (640, 360))
    return drawings, row, first_picture(drawings, row)


def pictures(html):
    """The dark and the light picture (height, width, 3)."""
    from PIL import Image

    found = re.findall(r'"data:image/jpeg;base64,([^"]*)"', html)
    assert len(found) == 2
    return [np.asarray(Image.open(io.BytesIO(base64.b64decode(f)))).astype(int) for f in found]


def test_both_themes_show_the_people_where_the_first_camera_has_them(made):
    drawings, row, html = made
    camera = row.first(SIZE, panel=False)
    skin = drawings[0].surfaces(0)["person/0"].vertices - camera.position
    local = skin @ camera.axes().T
    scale = 0.5 * SIZE[1] / np.tan(np.radians(FOV) / 2)
    pixels = scale * local[:, :2] / local[:, 2:] + 0.5 * np.array(SIZE)
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    assert (high - low)[1] / SIZE[1] == pytest.approx(0.5, abs=0.01)
    for picture, theme in zip(pictures(html), (DARK, LIGHT), strict=True):
        assert picture.shape == (SIZE[1], SIZE[0], 3)
        np.testing.assert_allclose(picture[0, :50].mean(axis=0) / 255, theme.top, atol=0.03)
        red, green, blue = np.moveaxis(picture, -1, 0)
        shirt = np.argwhere((green - red > 25) & (blue - red > 20) & (green > blue))[:, ::-1]
        assert len(shirt) > 1000
        # The shirt is on the upper half of the body.
        assert (shirt.min(axis=0) > low - 3).all()
        assert (shirt.max(axis=0) < [high[0] + 3, 0.5 * (low + high)[1] + 20]).all()


def test_it_is_for_windows_in_which_the_camera_is_the_same(made):
    _, row, html = made
    least, most = map(float, re.search(r"shape < ([\d.]+) \|\| shape > ([\d.]+)", html).groups())
    assert most == pytest.approx(SIZE[0] / SIZE[1], abs=1e-3)
    assert least < 1.0
    for shape in (least, 1.0, 1.6):
        there = row.first((round(1000 * shape), 1000), panel=False)
        assert np.linalg.norm(there.position - row.first(SIZE, panel=False).position) < 0.05


def test_the_player_waits_for_the_picture(made):
    drawings, row, html = made
    page = (
        '<html><head><script data-p="packed">run()</script></head><body><div></div></body></html>'
    )
    changed = with_first_picture(page, drawings, row)
    assert f"<body>{html}" in changed
    assert '<script type="text/plain" id="player" data-p="packed">run()</script>' in changed
    assert changed.index("waiting.replaceWith(script)") < changed.index("</body>")


def test_another_player_starts_by_itself(made):
    drawings, row, html = made
    page = "<html><head><script>run()</script></head><body></body></html>"
    changed = with_first_picture(page, drawings, row)
    assert changed.startswith(page.replace("<body>", f"<body>{html}").split("</body>")[0])
