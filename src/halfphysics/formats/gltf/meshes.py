"""The triangles of a glTF mesh, and the joint that each vertex of a skin follows most."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.formats.gltf.accessors import rows, stored
from halfphysics.formats.gltf.container import Container

Array = NDArray[np.float64]

#: Vertices of all props of a file together: bounds the memory and the time.
MOST_VERTICES = 2_000_000
#: `mode` of a primitive: triangles.
_TRIANGLES = 4


class Triangles(NamedTuple):
    """Vertices (V, 3), faces (F, 3), and of each vertex the skin's joint that it follows most (V,),
    0 where there is no skin."""

    vertices: Array
    faces: NDArray[np.int64]
    joints: NDArray[np.int64]


def triangles(container: Container, name: str, index: Any) -> Triangles | None:
    """All triangles of a mesh; None: it has none.

    Args:
        container: The file.
        name: Of the node, for messages.
        index: The mesh.

    Raises:
        FileError: It cannot be read.
    """
    primitives = container.entry("meshes", index).get("primitives", [])
    if not isinstance(primitives, list) or not all(isinstance(p, dict) for p in primitives):
        raise container.error(f"mesh of {name!r}: expected a list of primitives")
    parts: list[Triangles] = []
    count = 0
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
        joints = _followed(container, name, attributes, len(places))
        parts.append(Triangles(places, corners.reshape(-1, 3) + count, joints))
        count += len(places)
        if count > MOST_VERTICES:
            raise container.error(f"mesh of {name!r}: over {MOST_VERTICES} vertices")
    if not parts:
        return None
    return Triangles(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _followed(
    container: Container, name: str, attributes: dict[str, Any], count: int
) -> NDArray[np.int64]:
    """The joint with the largest weight of each vertex."""
    if "JOINTS_0" not in attributes or "WEIGHTS_0" not in attributes:
        return np.zeros(count, dtype=np.int64)
    joints = stored(container, attributes["JOINTS_0"], "VEC4", f"joints of {name!r}")
    weights = rows(container, attributes["WEIGHTS_0"], "VEC4", f"weights of {name!r}")
    if len(joints) != count or len(weights) != count or joints.dtype.kind != "u":
        raise container.error(
            f"mesh of {name!r}: found {len(joints)} joints and {len(weights)} weights, expected "
            f"whole numbers and weights of its {count} vertices"
        )
    most = weights.argmax(axis=1)
    return np.take_along_axis(joints, most[:, None], axis=1)[:, 0].astype(np.int64)
