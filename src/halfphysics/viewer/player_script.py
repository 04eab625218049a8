"""The script and the style that pages get beside viser's own: the files in `player/`."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

#: The parts of the script, each after those that it uses.
PARTS = (
    *("hook", "reel", "clock", "server", "bar", "keys", "cameras", "compare", "skin"),
    *("npz", "people", "drop", "panel", "main"),
)
_FOLDER = Path(__file__).parent / "player"


@cache
def style() -> str:
    """The style sheet."""
    return (_FOLDER / "style.css").read_text(encoding="utf-8")


@cache
def script() -> str:
    """The script, which defines `startPage` and `startServed` and starts neither."""
    return "\n".join((_FOLDER / f"{part}.js").read_text(encoding="utf-8") for part in PARTS)


def page_head(data: dict[str, Any]) -> str:
    """HTML for the head of a page that plays by itself."""
    # A name may hold any text, even the end tag of a script.
    text = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    return (
        f'<style>{style()}</style><script type="application/json" id="hp-data">{text}</script>'
        f"<script>(() => {{\n{script()}\n"
        'startPage(JSON.parse(document.getElementById("hp-data").textContent));\n})();</script>'
    )


def served_head() -> str:
    """HTML for the head of the page of a server."""
    return f"<style>{style()}</style><script>(() => {{\n{script()}\nstartServed();\n}})();</script>"
