"""Body parts coloured by the force on them: patches of skin, visible during contact.

A skinned mesh in the browser has one colour. So every part that ever is in contact gets a patch:
the faces with the largest weight of its joint, slightly above the skin. A patch has its own copy
of the bones that move it; they are only sent while it is visible: parts without contact cost
nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import JOINT_NAMES, N_JOINTS
from halfphysics.render.cutting import Faces, cut
from halfphysics.render.rasterizer import Color
from halfphysics.viewer.bones import Bones
from halfphysics.viewer.figure import rgb, shrunk, strongest

if TYPE_CHECKING:
    from halfphysics.results.result import Result
    from halfphysics.viewer.figure import Figure
    from halfphysics.viewer.stage import Stage

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Forces at which a part changes its colour [N], and the colours between them.
BOUNDS = (10.0, 50.0, 250.0)
RAMP: tuple[Color, ...] = (
    (0.98, 0.80, 0.25),
    (0.96, 0.55, 0.16),
    (0.87, 0.22, 0.17),
    (0.55, 0.05, 0.20),
)

# Height of a patch above the skin [m].
_ABOVE = 0.0012
# Smaller skin weights are left out, which saves bones to send.
_LEAST = 0.02


def part_forces(result: Result, person: int) -> Array:
    """Sum of the force magnitudes on each part of a person per frame (T, 55) [N]."""
    contacts = result.contacts
    mine = np.asarray(contacts.person) == person
    force = np.zeros((len(result.motion), N_JOINTS))
    size = np.linalg.norm(np.asarray(contacts.impulse)[mine], axis=1) * result.fps
    np.add.at(force, (np.asarray(contacts.frame)[mine], np.asarray(contacts.part)[mine]), size)
    return force


def level(force: Array | float) -> Any:
    """Index into `RAMP` for forces [N]."""
    return np.searchsorted(BOUNDS, force, side="right")


def patch(
    field: Array, vertices: Array, faces: NDArray[np.integer], weights: Array
) -> tuple[Array, Faces, Array]:
    """The part of a surface on which a field is not negative, cut along its zero line.

    Args:
        field: Values at the vertices (V,); linear in the faces.
        vertices: (V, 3).
        faces: (F, 3).
        weights: Other values at the vertices (V, K); linear in the faces.

    Returns:
        Vertices (N, 3), faces (M, 3) and weights (N, K) of the patch.
    """
    part = cut(field, faces)
    return part.of(vertices), part.faces, part.of(weights)


class Patch:
    """The skin of one part, drawn over the body's skin; hidden until `show`."""

    def __init__(self, server: Any, name: str, figure: Figure, part: int) -> None:
        body = figure.body
        share = np.asarray(body.weights)
        rest = np.delete(share, part, axis=1).max(axis=1)
        above = shrunk(np.asarray(body.rest_vertices), body.faces, -_ABOVE)
        vertices, faces, weights = patch(share[:, part] - rest, above, body.faces, figure.weights)
        weights = strongest(np.where(weights < _LEAST, 0.0, weights))
        #: The figure's bones that move the patch.
        self.bones: Ints = np.flatnonzero(weights.any(axis=0))
        at_rest = np.zeros((len(self.bones), 4))
        at_rest[:, 0] = 1.0
        self.level = 0
        self.handle = server.scene.add_mesh_skinned(
            name,
            vertices=vertices,
            faces=faces,
            bone_wxyzs=at_rest,
            bone_positions=np.asarray(body.rest_joints)[figure.joints[self.bones]],
            skin_weights=weights[:, self.bones],
            color=rgb(RAMP[0]),
            side="front",
            cast_shadow=False,
            visible=False,
        )
        self._sender = Bones([self.handle])

    def hide(self) -> None:
        """Hide the patch until `show`."""
        if self.handle.visible:
            self.handle.visible = False

    def show(self, positions: Array, quaternions: Array, step: int) -> None:
        """Show the patch at the figure's bone pose (B, 3) [m] and (B, 4), in `RAMP[step]`."""
        self._sender.send(positions[self.bones], quaternions[self.bones])
        if step != self.level:
            self.level = step
            self.handle.color = rgb(RAMP[step])
        if not self.handle.visible:
            self.handle.visible = True


class Touched:
    """Patches of all people of a result.

    Args:
        server: The viser server.
        stage: The stage of the result; it calls `show` from then on.

    Attributes:
        forces: Forces on the parts of each person (T, 55) [N].
        patches: For each person, part -> `Patch`, for all parts that ever are in contact.
    """

    def __init__(self, server: Any, stage: Stage) -> None:
        result = stage.drawing.result
        self._people = stage.people
        self.forces = [part_forces(result, k) for k in range(len(stage.people))]
        self.patches: list[dict[int, Patch]] = []
        for k, figure in enumerate(stage.people):
            parts = np.flatnonzero(self.forces[k].any(axis=0)).tolist()
            name = stage.path(f"person/{k}/touch-")
            self.patches.append(
                {p: Patch(server, f"{name}{JOINT_NAMES[p]}", figure, p) for p in parts}
            )
        self._visible = True
        self._frame = -1
        stage.followers.append(self.show)

    @property
    def visible(self) -> bool:
        """Whether parts are coloured. If not, nothing is sent."""
        return self._visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        self._visible = visible
        if visible and self._frame >= 0:
            self.show(self._frame)
        elif not visible:
            for patches in self.patches:
                for one in patches.values():
                    one.hide()

    def show(self, frame: int) -> None:
        """Colour the parts in contact in a frame, in the present pose of the figures."""
        self._frame = frame
        if not self._visible:
            return
        for figure, force, patches in zip(self._people, self.forces, self.patches, strict=True):
            if figure.bone_pose is None:
                continue
            positions, quaternions = figure.bone_pose
            for part, one in patches.items():
                if force[frame, part] > 0.0:
                    one.show(positions, quaternions, int(level(force[frame, part])))
                else:
                    one.hide()
