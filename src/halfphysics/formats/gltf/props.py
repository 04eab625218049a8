"""The meshes of a glTF file that are no people's skin: what stands, and what moves.

The skin of a thing (a cabinet whose doors are joints) is cut into rigid parts, each the triangles
that follow one joint most.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.formats.gltf.animation import Animation
from halfphysics.formats.gltf.container import Container
from halfphysics.formats.gltf.meshes import MOST_VERTICES, triangles
from halfphysics.formats.gltf.nodes import Nodes
from halfphysics.formats.gltf.rig import bind_poses, rotations_of_matrices, world
from halfphysics.geometry.mesh import Mesh

Array = NDArray[np.float64]

#: A flat mesh at least so wide is a floor [m], if its height differs by less than that [m].
_FLOOR = (4.0, 1e-3)


class Prop(NamedTuple):
    """A mesh, its size applied, and its poses in the file's world.

    Attributes:
        name: New among the props.
        mesh: In the prop's frame, at its first size.
        positions: (T, 3), one row for what stands.
        rotations: (T, 3, 3).
        whole: Name of the thing of which it is one of several parts, else "".
    """

    name: str
    mesh: Mesh
    positions: Array
    rotations: Array
    whole: str = ""

    @property
    def moves(self) -> bool:
        """Whether it has a pose per frame."""
        return len(self.positions) > 1


class _Piece(NamedTuple):
    """Triangles in the frame of a node."""

    node: int
    name: str
    vertices: Array
    faces: NDArray[np.int64]
    whole: str = ""


def props(
    container: Container, nodes: Nodes, animation: Animation, people: Iterable[int], times: Array
) -> list[Prop]:
    """All props; what hangs on a person's joints is part of the person and left out.

    Args:
        container, nodes, animation: The file.
        people: Nodes of the people's skeletons.
        times: Of the frames [s].

    Raises:
        FileError: A mesh cannot be read.
    """
    found: list[Prop] = []
    names, vertices = _Names(), 0
    moved = {node for node, _ in animation.keys}
    for piece in _pieces(container, nodes, set(people)):
        vertices += len(piece.vertices)
        if vertices > MOST_VERTICES:
            raise container.error(f"meshes of over {MOST_VERTICES} vertices, expected a room")
        at = times if moved & set(nodes.above(piece.node)) else times[:1]
        transforms = world(nodes, animation, (piece.node,), at)[:, 0]
        try:
            mesh, turns = _sized(piece, transforms)
        except (ValueError, InputError) as error:
            raise container.error(f"mesh of {piece.name!r}: {error}") from None
        name = names.new(piece.name)
        found.append(Prop(name, mesh, transforms[:, :3, 3], turns, piece.whole))
    return found


def _pieces(container: Container, nodes: Nodes, people: set[int]) -> Iterator[_Piece]:
    """The rigid parts of all meshes that are no people's."""
    for node, entry in enumerate(nodes.entries):
        if "mesh" not in entry:
            continue
        name = nodes.names[node]
        if "skin" not in entry:
            found = None
            if not people & set(nodes.above(node)):
                found = triangles(container, name, entry["mesh"])
            if found is not None:
                yield _Piece(node, name, found.vertices, found.faces)
            continue
        joints, bind = bind_poses(container, entry["skin"], nodes)
        found = None if people & set(joints) else triangles(container, name, entry["mesh"])
        if found is None:
            continue
        if found.joints.max(initial=0) >= len(joints):
            raise container.error(f"mesh of {name!r}: follows joints that its skin does not have")
        owner = np.median(found.joints[found.faces], axis=1).astype(np.int64)
        parts = np.unique(owner)
        for part in parts:
            inverse = np.linalg.inv(bind[part])
            used, faces = np.unique(found.faces[owner == part], return_inverse=True)
            places = found.vertices[used] @ inverse[:3, :3].T + inverse[:3, 3]
            own = f"{name}_{nodes.names[joints[part]]}" if len(parts) > 1 else name
            whole = name if len(parts) > 1 else ""
            yield _Piece(joints[part], own, places, faces.reshape(-1, 3), whole)


def _sized(piece: _Piece, transforms: Array) -> tuple[Mesh, Array]:
    """The mesh at its first size, and its rotations (T, 3, 3).

    What stands has its whole transform but the place in its vertices: rooms mirror and shear what
    they repeat.
    """
    first, faces = transforms[0, :3, :3], piece.faces.astype(np.int32)
    mirrored = np.linalg.det(first) < 0.0
    if mirrored:
        faces = faces[:, ::-1]
    if len(transforms) == 1:
        return Mesh(piece.vertices @ first.T, faces), np.eye(3)[None]
    flip = np.diag([-1.0 if mirrored else 1.0, 1.0, 1.0])
    moving = np.array(transforms)
    moving[:, :3, :3] = moving[:, :3, :3] @ flip
    try:
        turns = rotations_of_matrices(moving)[0]
    except ValueError as error:
        raise ValueError(f"transforms {error}, expected rotations and scales") from None
    # Columns of the linear part over their rotation: the size, which stays that of the start.
    sizes = np.linalg.norm(first, axis=0)
    return Mesh(piece.vertices @ flip * sizes, faces), rot.to_matrix(turns)


class _Names:
    """Names that are new: "cup", "cup#2"."""

    def __init__(self) -> None:
        self._counts: dict[str, int] = {}

    def new(self, name: str) -> str:
        self._counts[name] = self._counts.get(name, 0) + 1
        return name if self._counts[name] == 1 else self.new(f"{name}#{self._counts[name]}")


def floor_height(prop: Prop, up: Array) -> float | None:
    """The height of a prop along `up` (3,) if it is a floor that stands, else None."""
    if prop.moves:
        return None
    corners = prop.mesh.vertices @ prop.rotations[0].T + prop.positions[0]
    heights = corners @ up
    across = corners - heights[:, None] * up
    wide = float(np.ptp(across, axis=0).max())
    return float(heights.mean()) if np.ptp(heights) < _FLOOR[1] and wide > _FLOOR[0] else None
