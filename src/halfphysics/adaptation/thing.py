"""A recorded thing: its surface, and how it moved."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.geometry.mesh_queries import MeshQuery

if TYPE_CHECKING:
    from halfphysics.results.result import ObjectTrack
    from halfphysics.scene.items import Object

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Thing:
    """An object of a scene with its recorded poses.

    Attributes:
        name: Its name in the scene.
        item: The object.
        position: Of its frame (T, 3) [m].
        quaternion: Of its frame (T, 4), of length 1.
    """

    name: str
    item: Object
    position: Array
    quaternion: Array

    @classmethod
    def of(cls, item: Object, track: ObjectTrack) -> Thing:
        """An object and its recorded track, whose quaternions may have any length but 0.

        Raises:
            InputError: A quaternion is 0: it is no rotation.
        """
        length = np.linalg.norm(track.quaternion, axis=1)
        if (none := np.flatnonzero(length == 0.0)).size:
            raise InputError(
                f"recorded {item.name!r}: found quaternion (0, 0, 0, 0) in frame {none[0]}, "
                "expected a rotation. Cut the track, or fill the gap with the rotation before it"
            )
        return cls(item.name, item, track.position, rot.normalize(track.quaternion))

    @cached_property
    def turn(self) -> Array:
        """Rotation of its frame, world from object (T, 3, 3)."""
        return rot.to_matrix(self.quaternion)

    @cached_property
    def _triangles(self) -> tuple[Array, NDArray[np.int32]]:
        """Corners (V, 3) and faces (F, 3) of its surface as given, in its own frame."""
        return self.item.true_shape.triangles()

    @cached_property
    def surface(self) -> MeshQuery:
        """Answers where its surface is."""
        return MeshQuery(*self._triangles)

    @cached_property
    def normals(self) -> Array:
        """Outward unit normals of the faces of `surface` (F, 3)."""
        vertices, faces = self._triangles
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        across = np.cross(b - a, c - a)
        lengths = np.linalg.norm(across, axis=1, keepdims=True)
        result: Array = across / np.maximum(lengths, 1e-300)
        return result

    @cached_property
    def centre(self) -> Array:
        """Its centre of mass in the world (T, 3) [m]."""
        result: Array = self.position + self.turn @ self.item.com
        return result

    def seen(self, points: Array) -> Array:
        """World points (T, n, 3) in the thing's frame of each frame."""
        result: Array = (points - self.position[:, None]) @ self.turn
        return result

    def gaps(self, points: Array) -> Array:
        """Distance of points (..., 3) of its frame from the surface [m], negative inside."""
        flat = np.ascontiguousarray(points.reshape(-1, 3))
        away = self.surface.closest(flat)[0]
        signed = np.where(self.surface.inside(flat), -away, away)
        result: Array = signed.reshape(points.shape[:-1])
        return result
