"""Pages for browsers that a live server has besides its WebSocket."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

_HERE = Path(__file__).parent


def pages() -> Mapping[str, tuple[str, bytes]]:
    """Path -> (content type, content): "/" shows the session, "/NAME" is that of a protocol."""
    files = {"/": _HERE / "page.html"}
    files |= {f"/{path.stem}": path for path in sorted((_HERE / "protocols").glob("*.html"))}
    return {
        path: ("text/html; charset=utf-8", file.read_bytes())
        for path, file in files.items()
        if file.is_file()
    }
