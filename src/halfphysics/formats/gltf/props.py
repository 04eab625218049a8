"""The meshes of a glTF file that are no people's skin: what stands, and what moves."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.formats.gltf.accessors import rows, stored
from halfphysics.formats.gltf.animation import Animation
from halfphysics.formats.gltf.container import Container
from halfphysics.formats.gltf.nodes import Nodes
from halfphysics.formats.gltf.rig import rotations_of_matrices, world
from halfphysics.geometry.mesh import Mesh

Array = NDArray[np.float64]

#: `mode` of a primitive: triangles.
_TRIANGLES = 4
#: Vertices of all props together: bounds the memory.
_MOST_VERTICES = 10_000_000
#: A flat mesh at least so wide is a floor [m], if its height differs by less than that [m].
_FLOOR = (4.0, 1e-3)


class Prop(NamedTuple):
    """A mesh, its size applied, and its poses in the file's world.

    Attributes:
        name: New among the props.
        mesh: In the node's frame, at its first size.
        positions: (T, 3), one row for what stands.
        rotations: (T, 3, 3).
    """

    name: str
    mesh: Mesh
    positions: Array
    rotations: Array

    @property
    def moves(self) -> bool:
        return len(self.positions) > 1


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
    joints = set(people)
    moved = {node for node, _ in animation.keys}
    for node, entry in enumerate(nodes.entries):
        above = nodes.above(node)
        if "mesh" not in entry or "skin" in entry or joints & set(above):
            continue
        mesh = _mesh(container, nodes.names[node], container.entry("meshes", entry["mesh"]))
        if mesh is None:
            continue
        vertices += len(mesh.vertices)
        if vertices > _MOST_VERTICES:
            raise container.error(f"meshes of over {_MOST_VERTICES} vertices, expected a room")
        at = times if moved & set(above) else times[:1]
        transforms = world(nodes, animation, (node,), at)[:, 0]
        try:
            turns = rotations_of_matrices(transforms)[0]
        except ValueError as error:
            raise container.error(
                f"node {nodes.names[node]!r}: transforms {error}, expected rotations and scales"
            ) from None
        # Columns of the linear part over their rotation: the size, which stays that of the start.
        sizes = np.linalg.norm(transforms[0, :3, :3], axis=0)
        found.append(
            Prop(
                names.new(nodes.names[node]),
                Mesh(mesh.vertices * sizes, mesh.faces),
                transforms[:, :3, 3],
                rot.to_matrix(turns),
            )
        )
    return found


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


def _mesh(container: Container, name: str, entry: dict[str, Any]) -> Mesh | None:
    """The triangles of a mesh; None: it has none."""
    primitives = entry.get("primitives", [])
    if not isinstance(primitives, list) or not all(isinstance(p, dict) for p in primitives):
        raise container.error(f"mesh of {name!r}: expected a list of primitives")
    vertices, faces, count = [], [], 0
    for primitive in primitives:
        attributes = primitive.get("attributes")
        if not isinstance(attributes, dict) or "POSITION" not in attributes:
            continue
        if primitive.get("mode", _TRIANGLES) != _TRIANGLES:
            continue
        places = rows(container, attributes["POSITION"], "VEC3", f"vertices of {name!r}")
        if "indices" in primitive:
            what = f"triangles of {name!r}"
            corners = stored(container, primitive["indices"], "SCALAR", what)[:, 0].astype(np.int64)
        else:
            corners = np.arange(len(places))
        if len(corners) % 3 or (len(corners) and corners.max() >= len(places)):
            raise container.error(f"triangles of {name!r}: indices of no vertex, or no triangles")
        vertices.append(places)
        faces.append(corners.reshape(-1, 3) + count)
        count += len(places)
    if not faces:
        return None
    try:
        return Mesh(np.concatenate(vertices), np.concatenate(faces))
    except InputError as error:
        raise container.error(f"mesh of {name!r}: {error}") from None
