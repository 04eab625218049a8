"""The core alone with furniture 1 m away: the cost of collision detection without contact."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from halfphysics.bench.clips import SUBSTEPS, body, story
from halfphysics.bench.free import core_loop
from halfphysics.bench.mujoco_loop import MujocoLoop
from halfphysics.bench.record import Options, Record
from halfphysics.bench.room import Piece, mesh_of
from halfphysics.bench.sides import driven
from halfphysics.geometry.shapes import Box, Plane
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: Distance of the furniture from the volume that the parts reach [m].
OFF = 1.0
_TRIANGLES = 100_000


def near(options: Options) -> Iterator[Record]:
    """Records with floor and boxes, with floor and meshes; both drives at stiffness 1."""
    motion = options.short(story().motions[0])
    low, high = reached(motion)
    pieces = _furniture(low - OFF, high + OFF)
    for label, (scene, hulls) in {
        "boxes": (_boxes(pieces, low), {}),
        "meshes": _meshes(pieces, low, _TRIANGLES // (10 if options.quick else 1)),
    }.items():
        peer = MujocoLoop(body(), motion.fps, SUBSTEPS, scene, hulls).player(motion)
        for _, done in driven(
            "near", label, motion, options, ours=core_loop, peer=peer, scene=scene
        ):
            yield done.record


def reached(motion: Motion) -> tuple[Array, Array]:
    """Corners (3,) of the bounding box of all parts in all frames [m]."""
    skin = body().vertices(motion)
    return skin.min(axis=(0, 1)), skin.max(axis=(0, 1))


def _furniture(low: Array, high: Array) -> tuple[Piece, ...]:
    """Two rows of cupboards along the path, with the box from `low` to `high` between them."""
    out = []
    for x in np.arange(low[0], high[0], 1.2):
        for y0, y1 in ((low[1] - 0.5, low[1]), (high[1], high[1] + 0.5)):
            out.append(Piece(low=(x, y0, low[2]), high=(x + 1.0, y1, 2.0), radius=0.01))
    return tuple(out)


def _with_floor(low: Array) -> Scene:
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, low[2] - OFF))
    return scene


def _boxes(pieces: tuple[Piece, ...], low: Array) -> Scene:
    scene = _with_floor(low)
    for i, piece in enumerate(pieces):
        size = np.subtract(piece.high, piece.low)
        scene.add_static(f"box{i}", Box(tuple(size)), position=np.add(piece.low, 0.5 * size))
    return scene


def _meshes(
    pieces: tuple[Piece, ...], low: Array, triangles: int
) -> tuple[Scene, dict[str, tuple[Array, ...]]]:
    made = mesh_of(pieces, triangles)
    scene = _with_floor(low)
    scene.add_static("furniture", made.mesh)
    return scene, {"furniture": made.hulls}
