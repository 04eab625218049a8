"""A page's additions to the player: a colour key, and a camera that fits its window."""

from __future__ import annotations

import html
import json
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from halfphysics.render.rasterizer import Color
from halfphysics.render.result_meshes import GHOST, PEOPLE, Drawing
from halfphysics.results.hold_lines import hold_lines
from halfphysics.viewer.arrange import Arrangement
from halfphysics.viewer.contacts import KINDS
from halfphysics.viewer.figure import rgb
from halfphysics.viewer.support_overlay import KEY

Array = NDArray[np.float64]

# Window shapes with a camera, width over height. The widest that is not wider than the window is
# used, so that all motion is in view.
_SHAPES = (0.4, 0.46, 0.55, 0.7, 0.85, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5)
_HEIGHT = 720
# Height of the bar below the scene [pixels].
_BAR = 42

_STYLE = """
#key { position: fixed; left: 12px; bottom: %(bottom)dpx; z-index: 1; pointer-events: none;
  max-width: calc(100vw - 24px); box-sizing: border-box; padding: 6px 10px; border-radius: 4px;
  background: rgba(255, 255, 255, 0.85); color: #282c34; line-height: 1.5;
  font: 13px system-ui, sans-serif; }
#key b { margin-right: 12px; }
#key span { display: inline-block; margin-right: 12px; white-space: nowrap; }
#key i { display: inline-block; width: 10px; height: 10px; margin-right: 5px; border-radius: 2px; }
.mantine-Select-wrapper { width: 4.4em !important; }
.mantine-Select-input, .mantine-NumberInput-input { font-size: 12px !important; }
"""

# The player reads the camera from the address; a camera that the user put there stays.
_AIM = """
(() => {
  const known = new URLSearchParams(location.search);
  if (known.has("initialCameraPosition") && !known.has("fitted")) return;
  const shape = innerWidth / Math.max(innerHeight - %(bar)d, 1);
  const fitting = %(cameras)s.filter((camera) => camera[0] <= shape);
  const [, position, target] = fitting.length ? fitting[fitting.length - 1] : %(first)s;
  known.set("initialCameraPosition", position);
  known.set("initialCameraLookAt", target);
  known.set("fitted", "1");
  try { history.replaceState(null, "", "?" + known); } catch { /* inside another page */ }
})();
"""

_SHOW = """
addEventListener("DOMContentLoaded", () => {
  const key = document.createElement("div");
  key.id = "key";
  key.innerHTML = %s;
  document.body.append(key);
});
"""


def head(
    title: str,
    drawings: Sequence[Drawing],
    row: Arrangement,
    contacts: Sequence[int],
    support: bool = False,
    notes: Sequence[str] = (),
) -> str:
    """HTML for the head of a page.

    Args:
        title: Title of the page.
        drawings: The drawings that the page shows.
        row: The arrangement that gives the camera.
        contacts: Kinds of contacts on the page, indices into `KINDS`.
        support: Whether the page shows the support of people.
        notes: Lines below the title.
    """
    cameras = []
    for shape in _SHAPES:
        camera = row.camera((round(shape * _HEIGHT), _HEIGHT))
        cameras.append([shape, _text(camera.position), _text(camera.target)])
    aim = _AIM % {"bar": _BAR, "cameras": json.dumps(cameras), "first": json.dumps(cameras[0])}
    # A title may hold any text, even the end tag of a script.
    key = json.dumps(_key(title, drawings, contacts, support, notes)).replace("<", "\\u003c")
    style = _STYLE % {"bottom": _BAR + 10}
    return f"<style>{style}</style><script>{aim}{_SHOW % key}</script>"


def _key(
    title: str,
    drawings: Sequence[Drawing],
    contacts: Sequence[int],
    support: bool,
    notes: Sequence[str],
) -> str:
    """HTML of the title, the meaning of the colours, the notes, and what hands held."""
    people = max(len(drawing.result.people) for drawing in drawings)
    bodies = [PEOPLE[k % len(PEOPLE)] for k in range(people)]
    entries = [([GHOST], "reference"), (bodies, "simulated")]
    for k, kind in enumerate(contacts):
        label = KINDS[kind].label.removeprefix("on a person, ")
        entries.append(([KINDS[kind].color], label if k else f"force {label}"))
    if support:
        entries += [([color], label) for color, label in KEY]
    said = "".join(
        f"<span>{''.join(map(_patch, colors))}{html.escape(label)}</span>"
        for colors, label in entries
    )
    lines = list(notes)
    for result in (drawing.result for drawing in drawings):
        if result.holds:
            lines += [line for k in range(len(result.people)) for line in hold_lines(result, k)]
    told = "".join(f"<div>{html.escape(line)}</div>" for line in lines)
    return f"<b>{html.escape(title)}</b>{said}{told}"


def _patch(color: Color) -> str:
    return f'<i style="background: rgb{rgb(color)}"></i>'


def _text(point: Array) -> str:
    return ",".join(f"{value:.4f}" for value in point)
