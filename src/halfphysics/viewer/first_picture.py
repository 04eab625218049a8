"""The picture of a page until the browser has drawn its own: the page need not wait for that.

viser's player needs a second to start, and a browser without a graphics card another one to prepare
its shaders. Until then the page shows this package's picture of the first frame, from the player's
first camera. That camera spans one angle upwards, so one wide picture suits all windows: a narrower
one shows its middle. The player starts when the picture is on the screen.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import replace
from io import BytesIO
from typing import Any

import numpy as np

from halfphysics.render.look import DARK, LIGHT, Theme
from halfphysics.render.rasterizer import Look, Surface, render
from halfphysics.render.result_meshes import Drawing
from halfphysics.viewer.arrange import Arrangement

#: Width and height of the picture [pixels].
SIZE = (1080, 540)
_QUALITY = 82  # of the JPEG
# A camera moved by less than this shows the same [m]: a few pixels, as the people are metres away.
_SAME = 0.05
# The scene is drawn once a frame has so many triangles: the ground has two, a person some 27,000.
_DRAWN = 1000
# Narrower windows, as width over height, are tried down to this.
_NARROWEST, _TRIES = 0.3, 24

_STYLE = """
#first { position: fixed; inset: 0 0 auto 0; height: calc(100% - var(--hp-bar, 67px)); z-index: 4;
  overflow: hidden; pointer-events: none; transition: opacity 0.25s; }
#first img { position: absolute; height: 100%; left: 50%; transform: translateX(-50%); }
"""

# The picture goes when three.js has drawn the scene, a frame later: then the browser shows it. It
# is not for a camera that the user put into the address.
_SCRIPT = """
(() => {
  const first = document.getElementById("first");
  const known = new URLSearchParams(location.search);
  const shape = first.clientWidth / Math.max(first.clientHeight, 1);
  const own = known.has("initialCameraPosition") && !known.has("fitted");
  if (own || shape < %(least)s || shape > %(most)s) return first.remove();
  const look = () => {
    const points = window.__viserTestpoints;
    if (!points || points.rendererInfo.render.triangles < %(triangles)d)
      return requestAnimationFrame(look);
    requestAnimationFrame(() => requestAnimationFrame(() => {
      first.style.opacity = 0;
      setTimeout(() => first.remove(), 300);
      window.dispatchEvent(new Event("first-picture"));
    }));
  };
  look();
})();
"""
# viser's player is one script, which unpacks itself. It and our script wait until the picture has
# been painted; in a tab in the background nothing is painted, and they start after a moment.
_PLAYER, _WAITING = "<script data-p=", '<script type="text/plain" id="player" data-p='
#: The tag of a script that waits for the picture; it runs before viser's player.
WAITING = '<script type="text/plain" class="waiting">'
_START = """
<script>(() => {
  let begun = false;
  const start = () => {
    if (begun) return;
    begun = true;
    for (const waiting of document.querySelectorAll("script.waiting")) run(waiting);
    const player = document.getElementById("player");
    if (player) run(player);
  };
  const run = (waiting) => {
    const script = document.createElement("script");
    Object.assign(script.dataset, waiting.dataset);
    script.textContent = waiting.textContent;
    waiting.replaceWith(script);
  };
  requestAnimationFrame(() => requestAnimationFrame(start));
  setTimeout(start, 300);
})();</script>
"""


def with_first_picture(page: str, drawings: Sequence[Drawing], row: Arrangement) -> str:
    """A page of viser's with the picture at the beginning of its body.

    Args:
        page: HTML of the page.
        drawings: The results that the page shows.
        row: Their arrangement; its `first` camera is the page's.
    """
    page = page.replace("<body>", f"<body>{first_picture(drawings, row)}", 1)
    if page.count(_PLAYER) == 1:  # in another version of viser its player starts by itself
        page = page.replace(_PLAYER, _WAITING, 1)
    return page.replace("</body>", f"{_START}</body>", 1)


def first_picture(drawings: Sequence[Drawing], row: Arrangement) -> str:
    """HTML for the beginning of a page's body.

    Args:
        drawings: The results that the page shows.
        row: Their arrangement; its `first` camera is the page's.
    """
    pictures = {theme: _picture(drawings, row, theme) for theme in (LIGHT, DARK)}
    dark = f'<source media="(prefers-color-scheme: dark)" srcset="{pictures[DARK]}">'
    script = _SCRIPT % {
        "least": round(_narrowest(row), 3),
        "most": round(SIZE[0] / SIZE[1], 3),
        "triangles": _DRAWN,
    }
    return (
        f'<style>{_STYLE}</style><div id="first" aria-hidden="true"><picture>{dark}'
        f'<img alt="" src="{pictures[LIGHT]}"></picture></div><script>{script}</script>'
    )


def first_camera(row: Arrangement) -> dict[str, Any]:
    """The first camera for the browser, and the windows (width over height) that have it."""
    camera = row.first(SIZE, panel=False)
    return {
        "position": np.round(camera.position, 4).tolist(),
        "target": np.round(camera.target, 4).tolist(),
        "least": round(_narrowest(row), 3),
    }


def _narrowest(row: Arrangement) -> float:
    """The narrowest window, as width over height, for which the first camera is the same."""
    wide = row.first(SIZE, panel=False)
    for shape in np.linspace(_NARROWEST, SIZE[0] / SIZE[1], _TRIES):
        narrow = row.first((round(1000 * shape), 1000), panel=False)
        if np.linalg.norm(narrow.position - wide.position) < _SAME:
            return float(shape)
    return SIZE[0] / SIZE[1]


def _picture(drawings: Sequence[Drawing], row: Arrangement, theme: Theme) -> str:
    """The picture of the first frame as an address that contains it."""
    from PIL import Image

    camera = row.first(SIZE, panel=False)
    shown: list[Surface] = []
    for drawing, offset, faint in zip(drawings, row.offsets, row.faint, strict=True):
        themed = drawing.in_theme(theme)
        moved = replace(camera, position=camera.position - offset, target=camera.target - offset)
        own = [*themed.still(faint).values(), *themed.moving(0), *themed.edges(moved, SIZE[1])]
        shown += [replace(s, vertices=s.vertices + offset) for s in own]
    look = Look.of(theme).aimed(camera, drawings[0].middle)
    data = BytesIO()
    Image.fromarray(render(shown, camera, SIZE, look=look)).save(
        data, format="JPEG", quality=_QUALITY, optimize=True
    )
    return f"data:image/jpeg;base64,{base64.b64encode(data.getvalue()).decode('ascii')}"
