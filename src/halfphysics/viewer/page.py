"""One HTML file that plays a result offline: it needs no network and no server."""

from __future__ import annotations

import contextlib
import html
import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from halfphysics.errors import InputError
from halfphysics.render.result_meshes import Drawing
from halfphysics.viewer.arrange import Arrangement, arrange
from halfphysics.viewer.contacts import ContactNodes
from halfphysics.viewer.layers import show_support
from halfphysics.viewer.page_head import head
from halfphysics.viewer.server import close_server, open_server
from halfphysics.viewer.stage import Stage, aim, light

if TYPE_CHECKING:
    from halfphysics.results.result import Result

#: A page plays at most this many frames per second; frames of faster results are skipped.
MAX_FPS = 30.0
_VIEW = (1280, 720)


def save_page(
    result: Result,
    path: str | os.PathLike[str],
    *,
    title: str = "halfphysics",
    max_fps: float = MAX_FPS,
    support: bool = False,
    progress: bool = False,
) -> Path:
    """Writes a self-contained HTML page that plays: body, ghost, objects, contacts and scene.

    People are skinned in the browser from the poses of the joints (linear blend of the four
    strongest joints, without pose blend shapes). The page contains the skin of each person's
    body: share the page of a licensed body model only as its licence allows.

    Args:
        result: The result to show.
        path: The file to write; written completely or not at all.
        title: Title of the page.
        max_fps: Most frames played per second; a faster result keeps every n-th frame.
        support: Also shows what holds the people up (`PersonResult.support`): pressure on the
            skin, forces, centres of pressure and of mass. Bodies are drawn as glass.
        progress: Shows a progress bar on stderr.

    Returns:
        The path written.

    Raises:
        InputError: `max_fps` is not above 0.
        FileError: The file cannot be written, or no local port can be opened.
        MissingDependencyError: viser is not installed.
    """
    from halfphysics.base.atomic import atomic_write

    if not max_fps > 0:
        raise InputError(f"max_fps: found {max_fps!r}, expected frames per second above 0")
    drawing = Drawing(result)
    step = max(1, math.ceil(result.fps / max_fps - 1e-9))
    frames = range(0, len(drawing), step)
    with atomic_write(path) as file, _quiet_server() as server:
        recorder = server.get_scene_serializer()
        row = arrange([drawing], _VIEW)
        stage, contacts = _build(server, drawing, row)
        if support:
            show_support(server, stage)
        bar = _bar(len(frames), progress)
        # Without this the server's thread wakes for every bone and frame, with no browser to serve.
        with server.atomic():
            for frame in frames:
                stage.show(frame)
                recorder.insert_sleep(step / result.fps)
                bar.update()
        bar.close()
        page = recorder.as_html()
        page = page.replace("<title>Viser</title>", f"<title>{html.escape(title)}</title>", 1)
        page = page.replace("</head>", f"{head(title, drawing, row, contacts, support)}</head>", 1)
        file.write(page.encode("utf-8"))
    return Path(path)


def _bar(total: int, progress: bool) -> Any:
    from tqdm import tqdm

    return tqdm(total=total, desc="page", unit="frame", disable=not progress)


@contextlib.contextmanager
def _quiet_server() -> Iterator[Any]:
    """A viser server whose scene becomes the page; no browser connects to it."""
    server = open_server("127.0.0.1", 0)
    try:
        yield server
    finally:
        close_server(server)


def _build(server: Any, drawing: Drawing, row: Arrangement) -> tuple[Stage, list[int]]:
    """Build the scene; returns the stage and the kinds of contacts that occur."""
    aim(server, row.camera(_VIEW))
    light(server)
    stage = Stage(server, drawing, faint=row.faint[0])
    return stage, list(ContactNodes(server, stage).points)
