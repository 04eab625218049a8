"""The sky behind a viser scene, in a browser's light and dark colours: a style sheet.

viser's canvas is transparent where nothing is drawn, so its background is the sky, and the ground,
which is translucent too, fades into it.
"""

from __future__ import annotations

from typing import Any

from halfphysics.render.look import DARK, LIGHT, Color, Theme
from halfphysics.viewer.figure import rgb

# viser's attribute of dark colours; three.js marks its canvas.
_DARK, _CANVAS = '[data-mantine-color-scheme="dark"]', "canvas[data-engine]"
# Where the sky has the colour of the horizon, from the upper edge [%].
_HORIZON = 55


def style() -> str:
    """The style sheet."""
    return f"{_CANVAS} {{ {_sky(LIGHT)} }} {_DARK} {_CANVAS} {{ {_sky(DARK)} }}"


def add_sky(server: Any) -> None:
    """Give the browsers of a server the sky."""
    server.gui.add_html(f"<style>{style()}</style>")


def _sky(theme: Theme) -> str:
    colors = f"{_css(theme.top)}, {_css(theme.horizon)} {_HORIZON}%"
    return f"background: linear-gradient({colors});"


def _css(color: Color) -> str:
    return "rgb({}, {}, {})".format(*rgb(color))
