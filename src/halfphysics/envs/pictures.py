"""Pictures of episodes, by the package's own renderer: no GPU and no display are needed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import is_whole, shown
from halfphysics.errors import InputError
from halfphysics.render.rasterizer import Camera, Look, render
from halfphysics.render.result_meshes import Drawing

if TYPE_CHECKING:
    from halfphysics.envs.task import Task
    from halfphysics.results.result import Result

#: Width and height if not said otherwise [pixels].
SIZE = (640, 480)
#: The largest side of a picture [pixels].
MOST = 4096


def checked_size(size: Any) -> tuple[int, int]:
    """Width and height of pictures [pixels]. Raises `InputError` for an impossible size."""
    fine = isinstance(size, tuple | list) and len(size) == 2
    if not (fine and all(is_whole(s, least=1, plain=False) and s <= MOST for s in size)):
        raise InputError(f"size: found {shown(size)}, expected two whole numbers from 1 to {MOST}")
    return int(size[0]), int(size[1])


def picture(task: Task, i: int = 0, size: tuple[int, int] = SIZE) -> NDArray[np.uint8]:
    """Episode `i` as it is now, as the task's camera sees it, (H, W, 3).

    Args:
        task: The episodes.
        i: Index of the episode.
        size: Width and height [pixels].

    Raises:
        InputError: An impossible size.
    """
    size = checked_size(size)
    drawing = Drawing(cast("Result", task.worlds.moment(i)))
    view = task.view
    camera = Camera(position=np.array(view.position), target=np.array(view.target), fov=view.fov)
    look = Look().aimed(camera, drawing.middle)
    surfaces = [
        *drawing.still().values(),
        *drawing.moving(0, ghost=False),
        *drawing.edges(camera, size[1]),
    ]
    return np.asarray(render(surfaces, camera, size, look=look), dtype=np.uint8)
