"""HTML of objects for notebooks: a picture and a summary, made when it is asked for.

Pictures are small and made by the software rasterizer: no display, no browser, tenths of a second.
What fails (a mesh that has gone, a scene too large) is left out and logged; nothing is raised.
"""

from __future__ import annotations

import base64
import html
import logging
from collections.abc import Callable, Sequence
from io import BytesIO
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Plane
from halfphysics.motion.motion import Motion
from halfphysics.motion.pose import Pose
from halfphysics.render.contact_sheet import key_frames
from halfphysics.render.rasterizer import Camera, Look, Surface, render
from halfphysics.render.result_meshes import Drawing
from halfphysics.render.viewpoint import cameras, facing, glass, spread
from halfphysics.results import overview
from halfphysics.results.contacts import Contacts
from halfphysics.results.moment import Figure, Moment, at_start, standing_still
from halfphysics.results.result import PersonResult, Result
from halfphysics.results.table import Table
from halfphysics.scene.scene import Scene

T = TypeVar("T")
Picture = NDArray[np.uint8]

logger = logging.getLogger(__name__)

#: Width and height of a tile, and of the one picture of a scene [pixels].
TILE, WIDE = (190, 210), (400, 250)
#: Frames that are shown of a motion.
TILES = 3
#: Of a scene with more triangles the largest meshes are left out: a second each million.
MOST_TRIANGLES = 300_000
#: Heights of cameras over the horizontal [degrees]; of the three-quarter view from ahead.
_ELEVATION, _THREE_QUARTER = 16.0, 50.0
#: The way from a scene without people to the camera.
_CORNER = (0.8, -1.0, 0.75)
_COLORS = 128  # of the palette: a third of the bytes
_OCTREE = 2  # Pillow's number of this quantization method


def html_of(shown: Any) -> str:
    """HTML of an object: its picture, its `repr` and its lines."""
    picture = _left_out(shown, "picture", lambda: _image(shown)) or ""
    lines = _left_out(shown, "summary", lambda: _lines(shown)) or []
    text = html.escape("\n".join(lines))
    body = f'<pre style="margin:0;white-space:pre-wrap;font-size:12px">{text}</pre>' if text else ""
    return (
        '<div style="display:flex;flex-wrap:wrap;gap:14px;align-items:flex-start;max-width:1100px">'
        f"{picture}"
        '<div style="flex:1 1 360px;min-width:260px">'
        f'<div style="font-weight:600;margin-bottom:6px">{html.escape(repr(shown))}</div>'
        f"{body}</div></div>"
    )


def _left_out(shown: Any, what: str, make: Callable[[], T]) -> T | None:
    """What `make` makes; None, with a line in the log, where it fails."""
    try:
        return make()
    except Exception as error:  # a notebook would show a traceback in place of the object
        logger.debug("no %s of a %s: %s", what, type(shown).__name__, error, exc_info=True)
        return None


def _lines(shown: Any) -> Sequence[str]:
    """The summary of an object."""
    if isinstance(shown, PersonResult):
        return overview.person_lines(shown)
    if isinstance(shown, Scene):
        return overview.scene_lines(shown)
    if isinstance(shown, Contacts):
        return overview.contact_lines(shown)
    own = getattr(shown, "_notebook_lines", None)
    return own() if own is not None else []


def _image(shown: Any) -> str:
    """The picture as an element of HTML."""
    if isinstance(shown, Table):
        return overview.strip(shown)
    drawn = _moment(shown)
    if drawn is None:
        return ""
    data = base64.b64encode(_png(_picture(*drawn))).decode("ascii")
    style = "border-radius:6px;max-width:100%;height:auto"
    alt = html.escape(f"picture of {shown!r}", quote=True)
    return f'<img alt="{alt}" style="{style}" src="data:image/png;base64,{data}">'


def _moment(shown: Any) -> tuple[Result | Moment, list[int]] | None:
    """What is drawn, and at which frames."""
    if isinstance(shown, Result):
        return shown, key_frames(shown, TILES)
    if isinstance(shown, PersonResult):
        found = overview.alone(shown)
        return found, spread(len(found), TILES)
    if isinstance(shown, Motion):
        figure = Figure(Body.default(), shown)
        return Moment(people=(figure,), scene=_floor([figure])), spread(len(shown), TILES)
    if isinstance(shown, Pose):
        figure = Figure(Body.default(), standing_still(shown))
        return Moment(people=(figure,), scene=_floor([figure])), [0]
    if isinstance(shown, Body):
        upright = Pose(np.zeros(3), np.eye(55, 1) * np.array([[0.5 * np.pi, 0.0, 0.0]]))
        figure = Figure(shown, standing_still(upright))
        return Moment(people=(figure,), scene=_floor([figure])), [0]
    if isinstance(shown, Scene):
        if not shown._items():
            return None
        return Moment(scene=shown, objects=at_start(shown)), [0]
    own = getattr(shown, "_notebook_moment", None)
    if own is None:
        return None
    moment: Moment = own()
    return moment, spread(len(moment), TILES if len(moment) > TILES else 1)


def _floor(people: Sequence[Figure]) -> Scene:
    """A floor under the lowest vertex of people in the frames that are shown."""
    skins = [f.body.vertices(f.motion, frames=spread(len(f.motion), TILES)) for f in people]
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, min(s[..., 2].min() for s in skins)))
    return scene


def _picture(moment: Result | Moment, frames: Sequence[int]) -> Picture:
    """Tiles of some frames side by side; one wide picture of a scene without people."""
    drawing = Drawing(cast("Result", moment))
    shown = [_affordable(drawing.surfaces(frame)) for frame in frames]
    size = TILE
    if moment.people:
        views = cameras(drawing, frames, _ahead(drawing, frames), size)
    else:
        size = WIDE
        views = [_corner(surfaces, size) for surfaces in shown]
    tiles = []
    for frame, surfaces, camera in zip(frames, shown, views, strict=True):
        if moment.people:
            still = drawing.still(glass(surfaces, camera, size), frame)
            surfaces = surfaces | {name: s for name, s in still.items() if name in surfaces}
        look = Look().aimed(camera, drawing.middle)
        tiles.append(render(list(surfaces.values()), camera, size, look=look))
    return np.concatenate(tiles, axis=1)


def _affordable(surfaces: dict[str, Surface]) -> dict[str, Surface]:
    """The surfaces without the largest static meshes, where they are too many triangles."""
    kept, count = dict(surfaces), sum(len(s.faces) for s in surfaces.values())
    statics = [name for name in surfaces if name.startswith("static/")]
    for name in sorted(statics, key=lambda name: -len(surfaces[name].faces)):
        if count <= MOST_TRIANGLES:
            break
        count -= len(kept.pop(name).faces)
    return kept


def _ahead(drawing: Drawing, frames: Sequence[int]) -> NDArray[np.float64]:
    """The direction of a camera that sees people three-quarter from the front."""
    x, y = facing(drawing, frames).mean(axis=0)[:2]
    angle = np.arctan2(y, x) + np.radians(_THREE_QUARTER)
    up = np.tan(np.radians(_ELEVATION))
    return np.array([np.cos(angle), np.sin(angle), up])


def _corner(surfaces: dict[str, Surface], size: tuple[int, int]) -> Camera:
    """A camera that sees all but planes, which have no end."""
    ends = [s.vertices for s in surfaces.values() if s.fade is None and len(s.faces) > 2]
    points = np.concatenate(ends) if ends else np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 1.0]])
    return Camera.framing(points, _CORNER, size=size)


def _png(picture: Picture) -> bytes:
    from PIL import Image

    data = BytesIO()
    image = Image.fromarray(picture).quantize(_COLORS, method=_OCTREE, dither=0)  # type: ignore[arg-type]
    image.save(data, format="PNG", optimize=True)
    return data.getvalue()
