"""The nodes of a glTF file: a forest, each with a translation, rotation and scale in its parent."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.validation import shown
from halfphysics.formats.gltf.container import Container, is_index

Array = NDArray[np.float64]

#: Path of a channel -> number of columns.
PATHS = {"translation": 3, "rotation": 4, "scale": 3}
_DEFAULT = {"translation": (0.0, 0.0, 0.0), "rotation": (0.0, 0.0, 0.0, 1.0), "scale": (1.0,) * 3}
#: Nodes of a file: a furnished house has some thousands.
_MOST_NODES = 20_000
#: Nodes from the root to the tip of a finger: far above any skeleton.
_DEEPEST = 500
#: Positions and scales in any unit, beyond which products of them overflow.
_LARGEST = 1e9


class Nodes:
    """The hierarchy.

    Attributes:
        names: Of the nodes (N,), "node 3" for one without.
        parents: Of the nodes (N,), -1 for roots.

    Raises:
        FileError: A node has two parents, is below itself, or has an impossible transform.
    """

    def __init__(self, container: Container) -> None:
        self.container = container
        self.entries = container.entries("nodes")
        count = len(self.entries)
        if count > _MOST_NODES:
            raise container.error(f"found {count} nodes, expected at most {_MOST_NODES}")
        self.names = tuple(self._name(k) for k in range(count))
        parents = [-1] * count
        for k, entry in enumerate(self.entries):
            children = entry.get("children", [])
            if not isinstance(children, list) or not all(is_index(c, count) for c in children):
                raise container.error(f"node {k}: children: found {shown(children)}")
            for child in children:
                if parents[child] >= 0:
                    raise container.error(f"node {child} has two parents, expected a tree")
                parents[child] = k
        self.parents = tuple(parents)
        self.order = self._sorted()
        self._at_rest: dict[int, Array] = {}
        if max(self.depths, default=0) > _DEEPEST:
            raise container.error(f"nodes lie over {_DEEPEST} deep, expected a person's skeleton")

    def _name(self, k: int) -> str:
        name = self.entries[k].get("name")
        return name if isinstance(name, str) and name.isprintable() and name else f"node {k}"

    def _sorted(self) -> tuple[int, ...]:
        """All nodes, parents before children."""
        order = [k for k, parent in enumerate(self.parents) if parent < 0]
        for k in order:
            order.extend(self.entries[k].get("children", []))
        if len(order) != len(self.parents):
            raise self.container.error("a node is below itself, expected a tree")
        return tuple(order)

    def above(self, node: int) -> list[int]:
        """A node and all above it, the root last."""
        path = []
        while node >= 0:
            path.append(node)
            node = self.parents[node]
        return path

    @cached_property
    def depths(self) -> tuple[int, ...]:
        """Number of nodes above each."""
        depths = [0] * len(self.parents)
        for k in self.order:
            if self.parents[k] >= 0:
                depths[k] = depths[self.parents[k]] + 1
        return tuple(depths)

    def at_rest(self, node: int) -> Array:
        """World transform (4, 4) of a node as the file has it without animation."""
        way = []
        for above in self.above(node):
            if above in self._at_rest:
                break
            way.append(above)
        for each in reversed(way):
            own, parent = matrices(self.local(each)), self.parents[each]
            self._at_rest[each] = own if parent < 0 else self._at_rest[parent] @ own
        return self._at_rest[node]

    def local(self, node: int) -> dict[str, Array]:
        """Translation (3,), rotation (4,) as x, y, z, w, and scale (3,) of a node."""
        entry = self.entries[node]
        if "matrix" in entry:
            return self._of_matrix(node, self._numbers(node, "matrix", entry["matrix"], 16))
        return {
            path: self._numbers(node, path, entry.get(path, _DEFAULT[path]), width)
            for path, width in PATHS.items()
        }

    def _numbers(self, node: int, key: str, value: Any, width: int) -> Array:
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            array = np.zeros(0)
        if array.shape != (width,) or not (np.abs(array) < _LARGEST).all():
            raise self.container.error(
                f"node {self.names[node]!r}: {key}: found {shown(value)}, expected {width} numbers"
            )
        return array

    def _of_matrix(self, node: int, columns: Array) -> dict[str, Array]:
        matrix = columns.reshape(4, 4).T
        scale = np.linalg.norm(matrix[:3, :3], axis=0)
        extent = np.linalg.det(matrix[:3, :3])
        if (scale == 0.0).any() or extent == 0.0:
            raise self.container.error(
                f"node {self.names[node]!r}: its matrix has no extent, expected one that can be "
                "inverted"
            )
        if extent < 0.0:
            scale[0] = -scale[0]
        turn = rot.from_matrix(matrix[:3, :3] / scale)
        return {"translation": matrix[:3, 3], "rotation": turn[[1, 2, 3, 0]], "scale": scale}


def matrices(local: dict[str, Array]) -> Array:
    """Matrices (..., 4, 4) of translations (..., 3), rotations (..., 4) as x, y, z, w, scales."""
    turns = rot.to_matrix(rot.normalize(local["rotation"][..., [3, 0, 1, 2]]))
    turns, places, scales = np.broadcast_arrays(
        turns, local["translation"][..., None, :], local["scale"][..., None, :]
    )
    out = np.zeros((*turns.shape[:-2], 4, 4))
    out[..., :3, :3] = turns * scales
    out[..., :3, 3] = places[..., 0, :]
    out[..., 3, 3] = 1.0
    return out
