"""One HTML file that plays a result offline: it needs no network and no server."""

from __future__ import annotations

import contextlib
import html
import logging
import math
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from halfphysics.base import progress as bars
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.errors import InputError
from halfphysics.render.result_meshes import Drawing
from halfphysics.viewer.arrange import Arrangement, arrange
from halfphysics.viewer.comparison import References, has_reference
from halfphysics.viewer.contacts import ContactNodes
from halfphysics.viewer.dents import dent_document
from halfphysics.viewer.first_picture import WAITING, with_first_picture
from halfphysics.viewer.layers import show_support
from halfphysics.viewer.lights import Lights
from halfphysics.viewer.motions import as_result
from halfphysics.viewer.page_data import body_data, camera_data, common_data, layer_data
from halfphysics.viewer.page_key import key
from halfphysics.viewer.player_script import page_head
from halfphysics.viewer.reel import Recording, reel
from halfphysics.viewer.server import close_server, open_server
from halfphysics.viewer.stage import Stage, aim, light, middle
from halfphysics.viewer.theme import style
from halfphysics.viewer.whereabouts import starts

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import Result

logger = logging.getLogger(__name__)

#: A page plays at most this many frames per second; frames of faster results are skipped.
MAX_FPS = 30.0
_VIEW = (1280, 720)
# viser's own colours are those that the reader's system has.
_DARK = (
    "<script>window.__VISER_EMBED_CONFIG__ = "
    '{darkMode: matchMedia("(prefers-color-scheme: dark)").matches};</script>'
)


def save_page(
    result: Result | Motion | list[Any] | tuple[Any, ...],
    path: str | os.PathLike[str],
    *,
    title: str = "halfphysics",
    notes: Sequence[str] = (),
    labels: Sequence[str] | None = None,
    max_fps: float = MAX_FPS,
    support: bool = False,
    progress: bool = False,
) -> Path:
    """Writes a self-contained HTML page that plays: body, ghost, objects, contacts and scene.

    It has a time line with marks, a camera that follows, layers, and a slider between reference and
    simulated, and shows further motions that are dropped onto it (docs/viewer.md).

    People are skinned in the browser from the poses of the joints (linear blend of the four
    strongest joints, without pose blend shapes). The page contains the skin of each person's
    body: share the page of a licensed body model only as its licence allows.

    Args:
        result: The result or `Motion` to show, or several of the same frame rate: they play side by
            side, each as long as it lasts.
        path: The file to write; written completely or not at all.
        title: Title of the page.
        notes: Lines of text below the title.
        labels: Names of several results; None: their numbers.
        max_fps: Most frames played per second; a faster result keeps every n-th frame.
        support: Also shows what holds the people up (`PersonResult.support`): pressure on the
            skin, forces, centres of pressure and of mass. Bodies are drawn as glass.
        progress: Show a progress bar (`halfphysics.progress`).

    Returns:
        The path written.

    Raises:
        InputError: `max_fps` is not above 0, or the frame rates differ.
        FileError: The file cannot be written, or no local port can be opened.
        MissingDependencyError: viser is not installed.
    """
    from halfphysics.base.atomic import atomic_write

    if not max_fps > 0:
        raise InputError(f"max_fps: found {max_fps!r}, expected frames per second above 0")
    given: list[Any] = list(result) if isinstance(result, list | tuple) else [result]
    results = [as_result(one, f"result {k + 1}") for k, one in enumerate(given)]
    if not results or len({one.fps for one in results}) > 1:
        rates = ", ".join(f"{one.fps:g}" for one in results) or "no results"
        raise InputError(f"result: found {rates} fps, expected results of one frame rate")
    if labels is not None and len(labels) != len(results):
        raise InputError(f"labels: found {len(labels)}, expected {len(results)}, one a result")
    names = [f"result {k + 1}" for k in range(len(results))] if labels is None else list(labels)
    drawings, fps = [Drawing(one) for one in results], results[0].fps
    step = max(1, math.ceil(fps / max_fps - 1e-9))
    frames = range(0, max(map(len, drawings)), step)
    clock = Stopwatch(logger)
    with atomic_write(path) as file, quiet_server() as server:
        row = arrange(drawings, _VIEW)
        stages, contacts = _build(server, drawings, row)
        lights = light(server, row.direction.tolist(), row.reach)
        if support:
            for stage in stages:
                show_support(server, stage)
        # Reference poses are in the same reel: they differ where somebody was touched.
        if len(stages) == 1 and has_reference(drawings[0]):
            References(server, stages[0], on=True)
        first, recorded = _recorded(server, stages, lights, frames, step / fps, progress)
        data = {
            **common_data(stages, names, title, [range(0, len(d), step) for d in drawings]),
            **camera_data(stages, row, frames),
            "fps": fps / step,
            "layers": layer_data(stages, support),
            "key": key(drawings, contacts, support, notes),
            "body": body_data(results[0].people[0].body),
            "starts": starts(drawings, row.offsets).round(3).tolist(),
            "reel": reel(Recording(recorded), len(frames), step / fps),
            "dents": [one for stage in stages for one in dent_document(stage, step)],
        }
        file.write(assembled(first, page_head(data), title, drawings, row).encode("utf-8"))
    clock.done("wrote the page %s, %d frames", path, len(frames), count=len(frames))
    return Path(path)


def assembled(
    scene: str, head: str, title: str, drawings: Sequence[Drawing], row: Arrangement
) -> str:
    """A page of viser's with our script, title, sky and first picture.

    Args:
        scene: viser's page of the scene.
        head: Of `page_head` or `play_head`.
        title: Title of the page.
        drawings, row: What the page shows at first.
    """
    page = scene.replace("<title>Viser</title>", f"<title>{html.escape(title)}</title>", 1)
    page = page.replace("</head>", f"<style>{style()}</style>{_DARK}</head>", 1)
    waiting = head.replace("<script>", WAITING, 1)
    return with_first_picture(page.replace("<body>", f"<body>{waiting}", 1), drawings, row)


def _recorded(
    server: Any,
    stages: Sequence[Stage],
    lights: Lights,
    frames: range,
    seconds: float,
    progress: bool,
) -> tuple[str, bytes]:
    """The page of the first frame, and the recording of all frames."""
    with bars.asked(progress):
        bar = bars.bar(len(frames), "page", "frame")
    for stage in stages:
        stage.show(0)
    lights.follow(middle(stages))
    first: str = server.get_scene_serializer().as_html()
    recorder = server.get_scene_serializer()
    # Without this the server's thread wakes for every bone and frame, with no browser to serve.
    with server.atomic():
        for frame in frames:
            for stage in stages:
                stage.show(min(frame, len(stage.drawing) - 1))
            lights.follow(middle(stages))
            recorder.insert_sleep(seconds)
            bar.update()
    bar.close()
    return first, recorder.serialize()


@contextlib.contextmanager
def quiet_server() -> Iterator[Any]:
    """A viser server whose scene becomes the page; no browser connects to it."""
    server = open_server("127.0.0.1", 0)
    try:
        yield server
    finally:
        close_server(server)


def _build(
    server: Any, drawings: Sequence[Drawing], row: Arrangement
) -> tuple[list[Stage], list[int]]:
    """Build the scene; returns the stages and the kinds of contacts that occur."""
    aim(server, row.first(_VIEW, panel=False))
    stages = [
        Stage(
            server,
            drawing,
            prefix=f"/{k}" if k else "",
            offset=row.offsets[k],
            faint=row.faint[k],
            dents=False,  # the page's script shows them
        )
        for k, drawing in enumerate(drawings)
    ]
    kinds = {kind for stage in stages for kind in ContactNodes(server, stage).points}
    return stages, sorted(kinds)
