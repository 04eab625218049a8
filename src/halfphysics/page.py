"""One HTML file that plays a result: no network, no server, opened with a double click."""

from __future__ import annotations

import contextlib
import html
import math
import os
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.drawing import FAINT_ALPHA, FLOOR, Drawing, Item
from halfphysics.errors import FileError, InputError, MissingDependencyError
from halfphysics.mesh_queries import is_closed
from halfphysics.render import Color, Surface
from halfphysics.viewpoint import FOV, choose_direction, page_camera, spread

if TYPE_CHECKING:
    from halfphysics.body import Body
    from halfphysics.motion import Motion
    from halfphysics.result import Result

Array = NDArray[np.float64]

#: A page plays at most this many frames per second; faster results are thinned.
MAX_FPS = 30.0
# Poses are rounded to this [m, and of a quaternion]: unseen, and short once compressed.
_GRAIN = 2.0**-14
# The ghost's skin is drawn this far inside its true place [m]: where ghost and body agree the
# body hides it, instead of the two flickering.
_INSIDE = 0.003
_INFLUENCES = 4  # joints per vertex that the page can take
_VIEW = (1280, 720)
_SKY, _GROUND, _SKY_STRENGTH = (255, 255, 255), (190, 185, 180), 1.4


def save_page(
    result: Result,
    path: str | os.PathLike[str],
    *,
    title: str = "halfphysics",
    max_fps: float = MAX_FPS,
    progress: bool = False,
) -> Path:
    """Writes a self-contained HTML page: body and ghost, objects and scene, slider and play.

    People are skinned in the browser from the poses of the joints (linear blend of the four
    strongest joints, without pose blend shapes). The page contains the skin of each person's
    body: pass on the page of a licensed body model only as its licence allows.

    Args:
        result: What to show.
        path: The file to write; whole or not at all.
        title: Title of the page.
        max_fps: Frames played per second at most; of a faster result every n-th frame is kept.
        progress: Shows a progress bar on stderr.

    Returns:
        The path written.

    Raises:
        InputError: `max_fps` is not above 0.
        FileError: The file cannot be written, or the machine refuses a local port.
        MissingDependencyError: viser is not installed.
    """
    from halfphysics.io.atomic import atomic_write

    if not max_fps > 0:
        raise InputError(f"max_fps: found {max_fps!r}, expected frames per second above 0")
    drawing = Drawing(result)
    step = max(1, math.ceil(result.fps / max_fps - 1e-9))
    frames = range(0, len(drawing), step)
    with atomic_write(path) as file, _quiet_server() as server:
        recorder = server.get_scene_serializer()
        players = _build(server, drawing)
        bar = _bar(len(frames), progress)
        # Nobody listens: without this the server's thread is woken for every bone and frame.
        with server.atomic():
            for frame in frames:
                for play in players:
                    play(frame)
                recorder.insert_sleep(step / result.fps)
                bar.update()
        bar.close()
        page = recorder.as_html()
        page = page.replace("<title>Viser</title>", f"<title>{html.escape(title)}</title>", 1)
        file.write(page.encode("utf-8"))
    return Path(path)


def _bar(total: int, progress: bool) -> Any:
    from tqdm import tqdm

    return tqdm(total=total, desc="page", unit="frame", disable=not progress)


@contextlib.contextmanager
def _quiet_server() -> Iterator[Any]:
    """A viser server on a free local port, without its banner, stopped at the end.

    viser writes pages from a server's scene; nothing connects to it.
    """
    try:
        import rich
        import viser
    except ImportError as error:
        raise MissingDependencyError(
            f"the page needs viser, which cannot be imported ({error}). pip install viser"
        ) from None
    # viser retries for ever where no port can be had: ask first.
    try:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
    except OSError as error:
        raise FileError(
            f"cannot open a port on 127.0.0.1, which writing a page needs: {error.strerror}"
        ) from None
    console = rich.get_console()
    was_quiet, console.quiet = console.quiet, True
    try:
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        try:
            yield server
        finally:
            server.stop()
    finally:
        console.quiet = was_quiet


def _rgb(color: Color) -> tuple[int, int, int]:
    r, g, b = (round(255 * c) for c in color)
    return r, g, b


def _build(server: Any, drawing: Drawing) -> list[Any]:
    """Adds everything to the scene; returns what to call with each frame."""
    frames = spread(len(drawing), 6)
    direction = choose_direction(drawing, frames, _VIEW)
    camera, faint = page_camera(drawing, frames, direction, _VIEW)
    server.initial_camera.position = tuple(camera.position)
    server.initial_camera.look_at = tuple(camera.target)
    server.initial_camera.up = (0.0, 0.0, 1.0)
    server.initial_camera.fov = math.radians(FOV)
    # The viewer's own surroundings bleach skin; a sky and a floor that reflects do not.
    server.scene.configure_environment_map(hdri=None)
    server.scene.add_light_hemisphere(
        "/light/sky", sky_color=_SKY, ground_color=_GROUND, intensity=_SKY_STRENGTH
    )
    for name, item in drawing.statics.items():
        if item.surface.fade is not None:
            _add_floor(server, name, item, drawing)
        else:
            _add_mesh(server, name, item, FAINT_ALPHA if name in faint else None)
    players = []
    for name, item in drawing.objects.items():
        players.append(_mover(_add_mesh(server, name, item, None), item))
    for k, person in enumerate(drawing.result.people):
        for kind, motion in (("person", person.motion), ("ghost", person.reference)):
            surface = drawing.skin(k, kind == "ghost")
            players.append(_add_person(server, f"{kind}/{k}", surface, person.body, motion))
    return players


def _add_floor(server: Any, name: str, item: Item, drawing: Drawing) -> None:
    corners = item.surface.vertices
    server.scene.add_grid(
        f"/{name}",
        width=float(np.linalg.norm(corners[1] - corners[0])),
        height=float(np.linalg.norm(corners[3] - corners[0])),
        cell_size=0.5,
        section_size=1.0,
        cell_color=_rgb(FLOOR[1]),
        section_color=tuple(int(0.92 * c) for c in _rgb(FLOOR[1])),
        plane_color=_rgb(FLOOR[0]),
        plane_opacity=1.0,
        shadow_opacity=0.25,
        fade_distance=4 * drawing.radius + 20.0,
        position=tuple(corners.mean(axis=0)),
        wxyz=_upright(corners),
    )


def _upright(corners: Array) -> Array:
    """Quaternion that turns the x-y plane into the square of these corners."""
    from halfphysics import rotations as rot

    x = corners[1] - corners[0]
    y = corners[3] - corners[0]
    axes = [x / np.linalg.norm(x), y / np.linalg.norm(y)]
    return rot.from_matrix(np.stack([*axes, np.cross(*axes)], axis=1))


def _add_mesh(server: Any, name: str, item: Item, opacity: float | None) -> Any:
    surface = item.surface
    # Seen from outside only, where there is an outside: no shadow stripes, one layer of glass.
    solid = is_closed(surface.faces, len(surface.vertices))
    return server.scene.add_mesh_simple(
        f"/{name}",
        surface.vertices,
        surface.faces,
        color=_rgb(surface.color),
        opacity=opacity,
        flat_shading=surface.crease < 180.0,
        side="front" if surface.cull == "back" or solid else "double",
        cast_shadow=opacity is None and surface.casts,
        position=tuple(item.position[0]),
        wxyz=tuple(item.quaternion[0]),
    )


def _grain(values: Array) -> Array:
    return np.round(values / _GRAIN) * _GRAIN


def _mover(handle: Any, item: Item) -> Any:
    position, quaternion = _grain(item.position), _grain(item.quaternion)

    def play(frame: int) -> None:
        handle.position = position[frame]
        handle.wxyz = quaternion[frame]

    return play


def _strongest(weights: Array) -> Array:
    """Skin weights with only the strongest joints of each vertex, adding up to 1."""
    weights = np.array(weights, dtype=np.float64)
    drop = np.argsort(-weights, axis=1, kind="stable")[:, _INFLUENCES:]
    np.put_along_axis(weights, drop, 0.0, axis=1)
    return weights / weights.sum(axis=1, keepdims=True)


def _shrunk(vertices: Array, faces: NDArray[np.integer], by: float) -> Array:
    """Vertices moved inwards along the area-weighted normals."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normals, faces[:, k], np.cross(b - a, c - a))
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return vertices - by * normals / np.where(length > 0, length, 1.0)


def _add_person(server: Any, name: str, surface: Surface, body: Body, motion: Motion) -> Any:
    """A skinned mesh bound in the rest pose; its bones are the 55 joints in the world."""
    ghost = surface.alpha < 1.0
    vertices = np.asarray(surface.vertices)
    if ghost:
        vertices = _shrunk(vertices, surface.faces, _INSIDE)
    rest = np.zeros((len(body.rest_joints), 4))
    rest[:, 0] = 1.0
    common: dict[str, Any] = {
        "vertices": vertices,
        "faces": surface.faces,
        "bone_wxyzs": rest,
        "bone_positions": np.asarray(body.rest_joints),
        "skin_weights": _strongest(body.weights),
        "color": _rgb(surface.color),
        "side": "front",
        "cast_shadow": surface.casts,
        "receive_shadow": surface.receives,
    }
    handles = []
    if ghost:
        # Unseen, but it leaves its depth: of the ghost only the nearest layer is drawn then.
        handles.append(server.scene.add_mesh_skinned(f"/{name}-depth", opacity=0.0, **common))
    opacity = surface.alpha if ghost else None
    handles.append(server.scene.add_mesh_skinned(f"/{name}", opacity=opacity, **common))
    positions, quaternions = body.joint_frames(motion)
    positions, quaternions = _grain(positions), _grain(_continuous(quaternions))

    def play(frame: int) -> None:
        for handle in handles:
            for bone, position, quaternion in zip(
                handle.bones, positions[frame], quaternions[frame], strict=True
            ):
                bone.position = position
                bone.wxyz = quaternion

    return play


def _continuous(quaternions: Array) -> Array:
    """The same rotations over time (T, J, 4) without changes of sign."""
    turn = np.einsum("tja,tja->tj", quaternions[1:], quaternions[:-1]) < 0.0
    sign = np.where(np.cumsum(turn, axis=0) % 2 == 1, -1.0, 1.0)
    return np.concatenate([quaternions[:1], quaternions[1:] * sign[..., None]])
