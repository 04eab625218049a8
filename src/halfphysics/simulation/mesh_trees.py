"""Trees of static meshes in the world: the simulators of a scene share them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from halfphysics.geometry.mesh import Mesh
    from halfphysics.scene.items import Static

Array = NDArray[np.float64]

#: For as long as their scenes are there.
_trees: WeakKeyDictionary[Static, Any] = WeakKeyDictionary()


def mesh_tree(static: Static, rotation: Array, position: Array) -> Any:
    """The tree of a static mesh in the world; other statics of the same triangles share it.

    Args:
        static: What has the mesh.
        rotation: World from its frame (3, 3).
        position: Of its frame in the world (3,) [m].
    """
    from halfphysics import _native

    tree = _trees.get(static)
    if tree is None:
        tree = _trees[static] = _native.MeshTree(*world_triangles(static, rotation, position))
    return tree


def world_triangles(
    static: Static, rotation: Array, position: Array
) -> tuple[Array, NDArray[np.int32]]:
    """Vertices (V, 3) [m] in the world and faces (F, 3) of a static mesh, for the core."""
    mesh = cast("Mesh", static.frame)
    vertices = np.ascontiguousarray(mesh.vertices @ rotation.T + position)
    return vertices, np.ascontiguousarray(mesh.faces, dtype=np.int32)
