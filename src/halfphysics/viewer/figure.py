"""A person as a skinned mesh in the browser: the mesh is sent once, then only its bones."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import PARENTS
from halfphysics.render.rasterizer import Color, Surface
from halfphysics.viewer.bones import Bones

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

# A ghost's skin is drawn this far inside its true position [m]: where ghost and body agree, the
# body hides the ghost; otherwise the two flicker.
_INSIDE = 0.003
_INFLUENCES = 4  # most joints per vertex in the browser


def rgb(color: Color) -> tuple[int, int, int]:
    """Convert a colour from 0 to 1 to 0 to 255."""
    r, g, b = (round(255 * c) for c in color)
    return r, g, b


class Figure:
    """A person or a ghost: linear blend of the four strongest joints.

    Args:
        server: The viser server.
        name: Path of the node.
        surface: The surface at rest and its appearance. Translucent surfaces are ghosts.
        body: The body of the surface.
        bones: Joints with a bone (B,), with their parents; a joint without a bone moves with the
            nearest ancestor with one. None: all 55.
        fast: As in `Bones`.

    Attributes:
        body: The body of the surface.
        joints: Joints with a bone (B,).
        weights: Skin weights of the bones (V, B).
    """

    def __init__(
        self,
        server: Any,
        name: str,
        surface: Surface,
        body: Body,
        bones: NDArray[np.integer] | None = None,
        *,
        fast: bool = True,
    ) -> None:
        self.body = body
        total = len(body.rest_joints)
        self.joints = np.arange(total) if bones is None else np.asarray(bones)
        self.weights = strongest(_gathered(np.asarray(body.weights), self.joints))
        self._server, self._name = server, name
        self._meshes: list[Any] = []
        self._visible = True
        self._pose: tuple[Array, Array] | None = None
        vertices = np.asarray(surface.vertices)
        look: dict[str, Any] = {
            "color": rgb(surface.color),
            "cast_shadow": surface.casts,
            "receive_shadow": surface.receives,
        }
        if surface.alpha < 1.0:
            vertices = shrunk(vertices, surface.faces, _INSIDE)
            # An invisible mesh writes the depth: only the nearest layer of a ghost is drawn.
            self._add("-depth", vertices, surface.faces, opacity=0.0, **look)
            look["opacity"] = surface.alpha
        self.handle = self._add("", vertices, surface.faces, **look)
        self._bones = Bones(self._meshes, fast=fast)

    def _add(self, suffix: str, vertices: Array, faces: NDArray[np.integer], **look: Any) -> Any:
        """Add a mesh that moves with the bones. None is ever removed: viser's page fails then."""
        rest = np.zeros((len(self.joints), 4))
        rest[:, 0] = 1.0
        handle = self._server.scene.add_mesh_skinned(
            f"{self._name}{suffix}",
            vertices=vertices,
            faces=faces,
            bone_wxyzs=rest,
            bone_positions=np.asarray(self.body.rest_joints)[self.joints],
            skin_weights=self.weights,
            side="front",
            **look,
        )
        self._meshes.append(handle)
        return handle

    @property
    def name(self) -> str:
        """Path of the node."""
        return self._name

    @property
    def visible(self) -> bool:
        """Whether the figure is drawn. If not, poses are only sent when it is shown again."""
        return self._visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        self._visible = visible
        if visible:
            self._send()
        for mesh in self._meshes:
            mesh.visible = visible

    @property
    def bone_pose(self) -> tuple[Array, Array] | None:
        """Positions (B, 3) [m] and quaternions wxyz (B, 4) of the bones; None: never posed."""
        return self._pose

    def pose(self, positions: Array, quaternions: Array) -> None:
        """Set the pose.

        Args:
            positions: Positions of the joints (55, 3) [m].
            quaternions: Quaternions of the joints, wxyz (55, 4).
        """
        self._pose = positions[self.joints], quaternions[self.joints]
        if self._visible:
            self._send()

    def _send(self) -> None:
        if self._pose is not None:
            self._bones.send(*self._pose)


def moving_joints(*quaternions: Array, least: float = 1e-4) -> NDArray[np.integer]:
    """Joints that ever rotate relative to their parent in the world rotations (T, 55, 4).

    Fingers without relative rotation need no bones: they move exactly with the wrist's.

    Args:
        quaternions: World rotations of the joints, wxyz.
        least: Smaller rotations are ignored [rad].
    """
    parents = PARENTS
    keep = np.asarray(parents < 0)
    for q in quaternions:
        # |<p, q>| = cos(angle / 2); near 1 the sine keeps its digits.
        p = q[:, np.maximum(parents, 0)]
        sign = np.where(np.einsum("tja,tja->tj", p, q) < 0.0, -1.0, 1.0)
        keep = keep | (np.linalg.norm(q - sign[..., None] * p, axis=-1) > 0.5 * least).any(axis=0)
    return np.nonzero(keep)[0]


def _gathered(weights: Array, bones: NDArray[np.integer]) -> Array:
    """Sum skin weights of joints (V, J) to weights of the bones that carry them (V, B)."""
    column = {int(joint): k for k, joint in enumerate(bones)}
    out = np.zeros((len(weights), len(bones)))
    for joint in range(weights.shape[1]):
        carrier = joint
        while carrier not in column:
            carrier = int(PARENTS[carrier])
        out[:, column[carrier]] += weights[:, joint]
    return out


def strongest(weights: Array) -> Array:
    """Skin weights of only the strongest joints of each vertex, normalized to sum 1."""
    weights = np.array(weights, dtype=np.float64)
    drop = np.argsort(-weights, axis=1, kind="stable")[:, _INFLUENCES:]
    np.put_along_axis(weights, drop, 0.0, axis=1)
    result: Array = weights / weights.sum(axis=1, keepdims=True)
    return result


def shrunk(vertices: Array, faces: NDArray[np.integer], by: float) -> Array:
    """Vertices moved inwards along the area-weighted normals."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normals, faces[:, k], np.cross(b - a, c - a))
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return vertices - by * normals / np.where(length > 0, length, 1.0)
