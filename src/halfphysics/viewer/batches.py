"""Many small things of one colour as one node of a scene; their number changes with the frame."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.render.rasterizer import Color
from halfphysics.viewer.figure import rgb

Array = NDArray[np.float64]

_SHAFT, _HEAD, _HEAD_LENGTH = 0.0055, 0.0145, 0.042  # of an arrow [m]


class Batch:
    """A node that shows any number of things; hidden until its `show`.

    Attributes:
        handle: viser's handle.
    """

    handle: Any

    def hide(self) -> None:
        """Hide all until `show`."""
        self._set_visible(False)

    def _set_visible(self, visible: bool) -> None:
        # Every assignment is sent, even of the same value.
        if self.handle.visible != visible:
            self.handle.visible = visible


class Copies(Batch):
    """Copies of one mesh.

    Args:
        server: The viser server.
        name: Path of the node.
        mesh: Vertices (V, 3) [m] and faces (F, 3).
        color: Colour of all copies.
    """

    def __init__(
        self, server: Any, name: str, mesh: tuple[Array, NDArray[np.integer]], color: Color
    ) -> None:
        # Start with one copy: the browser builds its buffers from it.
        self.handle = server.scene.add_batched_meshes_simple(
            name,
            *mesh,
            batched_wxyzs=_unturned(1),
            batched_positions=np.zeros((1, 3)),
            batched_colors=rgb(color),
            lod="off",
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )

    def show(self, positions: Array, quaternions: Array | None = None) -> None:
        """Show copies at positions (n, 3) [m], turned by quaternions wxyz (n, 4); None: unturned.

        No copies at all: hide the node.
        """
        if len(positions):
            turns = _unturned(len(positions)) if quaternions is None else quaternions
            self.handle.batched_positions = positions
            self.handle.batched_wxyzs = turns
        self._set_visible(len(positions) > 0)


class Arrows(Batch):
    """Arrows.

    Args:
        server: The viser server.
        name: Path of the node.
        color: Colour of all arrows.
        thickness: Multiple of the usual thickness.
    """

    def __init__(self, server: Any, name: str, color: Color, thickness: float = 1.0) -> None:
        self.handle = server.scene.add_arrows(
            name,
            np.array([[[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]]]),
            rgb(color),
            shaft_radius=thickness * _SHAFT,
            head_radius=thickness * _HEAD,
            head_length=thickness * _HEAD_LENGTH,
            visible=False,
        )

    def show(self, segments: Array) -> None:
        """Show arrows from their starts to their ends (n, 2, 3) [m]. None at all: hide the node."""
        if len(segments):
            self.handle.points = segments.astype(np.float32)
        self._set_visible(len(segments) > 0)


def ball(radius: float) -> tuple[Array, NDArray[np.integer]]:
    """Mesh of a ball of a radius [m]."""
    from halfphysics.geometry.shapes import Sphere

    vertices, faces = Sphere(radius).triangles()
    return vertices, faces


def disc(radius: float, height: float) -> tuple[Array, NDArray[np.integer]]:
    """Mesh of a flat cylinder about the z axis, its middle at the origin [m]."""
    from halfphysics.geometry.shapes import Cylinder

    vertices, faces = Cylinder(radius, height).triangles()
    return vertices, faces


def _unturned(count: int) -> Array:
    return np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
