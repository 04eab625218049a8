"""A person as skinned meshes in the browser: the meshes are sent once, then only their bones."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import PARENTS
from halfphysics.render.clothes import dressed
from halfphysics.render.cutting import Cut
from halfphysics.render.ghost import opacity, parts
from halfphysics.render.look import GHOST_ALPHA, Color
from halfphysics.render.rasterizer import Surface
from halfphysics.viewer.bones import Bones

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

# A ghost's skin is drawn this far inside its true position [m]: where ghost and body agree, the
# body hides the ghost; otherwise the two flicker.
_INSIDE = 0.003
_INFLUENCES = 4  # most joints per vertex in the browser
# Smaller skin weights are left out of a piece, which saves bones to send.
_LEAST = 0.02
# Number of steps in which a ghost's opacity changes.
_STEPS = 6


def rgb(color: Color) -> tuple[int, int, int]:
    """Convert a colour from 0 to 1 to 0 to 255."""
    r, g, b = (round(255 * c) for c in color)
    return r, g, b


class Figure:
    """A person or a ghost: linear blend of the four strongest joints.

    A person's skin is drawn in pieces of one colour, its clothes; a ghost's in parts, each of which
    fades out while it coincides with the body (`fade`). A piece has copies of only those bones that
    move it.

    Args:
        server: The viser server.
        name: Path of the node.
        surface: The surface at rest and its appearance. Translucent surfaces are ghosts.
        body: The body of the surface.
        bones: Joints with a bone (B,), with their parents; a joint without a bone moves with the
            nearest ancestor with one. None: all 55.
        person: Index of the person, which decides the shirt.
        fast: As in `Bones`.

    Attributes:
        body: The body of the surface.
        joints: Joints with a bone (B,).
        weights: Skin weights of the bones (V, B).
        node: The parent of all pieces.
        handles: Name -> viser's handle of each piece.
    """

    def __init__(
        self,
        server: Any,
        name: str,
        surface: Surface,
        body: Body,
        bones: NDArray[np.integer] | None = None,
        *,
        person: int = 0,
        fast: bool = True,
    ) -> None:
        self.body = body
        total = len(body.rest_joints)
        self.joints = np.arange(total) if bones is None else np.asarray(bones)
        self.weights = strongest(_gathered(np.asarray(body.weights), self.joints))
        self._server, self._name = server, name
        self._visible = True
        self._pose: tuple[Array, Array] | None = None
        self.node = server.scene.add_frame(name, show_axes=False)
        self.handles: dict[str, Any] = {}
        self._senders: dict[str, tuple[Ints, Bones]] = {}
        self._ghost = surface.alpha < 1.0
        vertices = np.asarray(surface.vertices)
        if self._ghost:
            vertices = shrunk(vertices, surface.faces, _INSIDE)
            for part, one in parts(body).items():
                look = {"color": rgb(surface.color), "opacity": surface.alpha, "visible": False}
                self._add(part, vertices, one, fast, cast_shadow=False, **look)
        else:
            for piece in dressed(body, person):
                look = {"color": rgb(piece.color), "receive_shadow": False}
                self._add(piece.name, vertices, piece.cut, fast, **look)
        self._steps = dict.fromkeys(self.handles, 0)

    def _add(self, name: str, vertices: Array, cut: Cut, fast: bool, **look: Any) -> None:
        """Add a piece that moves with bones. None is ever removed: viser's page fails then."""
        weights = cut.of(self.weights)
        weights = strongest(np.where(weights < _LEAST, 0.0, weights))
        used = np.flatnonzero(weights.any(axis=0))
        rest = np.zeros((len(used), 4))
        rest[:, 0] = 1.0
        self.handles[name] = self._server.scene.add_mesh_skinned(
            f"{self._name}/{name}",
            vertices=cut.of(vertices),
            faces=cut.faces,
            bone_wxyzs=rest,
            bone_positions=np.asarray(self.body.rest_joints)[self.joints[used]],
            skin_weights=weights[:, used],
            side="front",
            **look,
        )
        self._senders[name] = used, Bones([self.handles[name]], fast=fast)

    def bones_of(self, name: str) -> Ints:
        """The bones of a piece, indices into `joints`."""
        return self._senders[name][0]

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
        self.node.visible = visible

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

    def fade(self, apart: Mapping[str, float]) -> None:
        """Fade the parts of a ghost that coincide with the body.

        Args:
            apart: Part -> its distance from the body [m], from `Separation.of`.
        """
        late = []
        for name, handle in self.handles.items():
            # In steps: each change of the opacity is a message.
            step = round(_STEPS * float(opacity(apart[name])) / GHOST_ALPHA)
            before, self._steps[name] = self._steps[name], step
            if step == before:
                continue
            if step:
                handle.opacity = GHOST_ALPHA * step / _STEPS
            if bool(step) != bool(before):
                handle.visible = bool(step)
                late.append(name)
        if late and self._visible:
            self._send()

    def _send(self) -> None:
        if self._pose is None:
            return
        positions, quaternions = self._pose
        for name, (used, sender) in self._senders.items():
            if not self._ghost or self._steps[name]:
                sender.send(positions[used], quaternions[used])


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
