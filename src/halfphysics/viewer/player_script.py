"""The script and the style that pages get beside viser's own: the files in `player/`."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

#: The parts of the script, each after those that it uses.
PARTS = (
    *("hook", "reel", "clock", "server", "bar", "keys", "cameras", "compare", "skin"),
    *("npz", "people", "drop", "dents", "panel", "main"),
)
#: Those of a page with physics, after the others.
PLAY_PARTS = ("physics", "pointer", "figures", "knobs", "play")
_FOLDER = Path(__file__).parent / "player"


@cache
def style() -> str:
    """The style sheet."""
    return (_FOLDER / "style.css").read_text(encoding="utf-8")


@cache
def script() -> str:
    """The script, which defines `startPage` and `startServed` and starts neither."""
    return "\n".join((_FOLDER / f"{part}.js").read_text(encoding="utf-8") for part in PARTS)


@cache
def play_script() -> str:
    """What a page with physics has beside `script`; it defines `startPlay`."""
    return "\n".join((_FOLDER / f"{part}.js").read_text(encoding="utf-8") for part in PLAY_PARTS)


def page_head(data: dict[str, Any]) -> str:
    """HTML for the head of a page that plays by itself."""
    return _head(data, script(), "startPage")


def play_head(data: dict[str, Any], core: str) -> str:
    """HTML for the head of a page with physics.

    Args:
        data: What the script reads (viewer/play_data.py).
        core: The script of the core's package, which defines `HalfPhysics`.
    """
    return _head(data, f"{script()}\n{core}\n{play_script()}", "startPlay")


def _head(data: dict[str, Any], code: str, start: str) -> str:
    # A name may hold any text, even the end tag of a script.
    text = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    return (
        f'<style>{style()}</style><script type="application/json" id="hp-data">{text}</script>'
        f"<script>(() => {{\n{code}\n"
        f'{start}(JSON.parse(document.getElementById("hp-data").textContent));\n}})();</script>'
    )


def served_head() -> str:
    """HTML for the head of the page of a server."""
    return f"<style>{style()}</style><script>(() => {{\n{script()}\nstartServed();\n}})();</script>"
