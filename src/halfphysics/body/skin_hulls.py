"""The skin as convex pieces: vertex sets whose hulls cover it at every pose.

A face whose three vertices are in one set lies in the hull of that set at any pose. So if the hulls
do not overlap an obstacle, the skin does not either. `skin_cut` selects the faces of each set. For
the default body the sets come with the package: `assets/body_cut.npz`.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base.copying import ReadOnly
from halfphysics.base.short_repr import short_repr
from halfphysics.body.skin_cut import cut_faces, parts_of_faces
from halfphysics.body.symmetry import Symmetry, symmetry_of
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import N_JOINTS

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_BAKED = Path(__file__).parents[1] / "assets" / "body_cut.npz"

#: Size of the cache of divided skins: all shapes of one model share one division.
REMEMBERED = 16
_known: dict[bytes, SkinHulls] = {}


@dataclass(frozen=True, kw_only=True, eq=False)
class SkinHulls(ReadOnly):
    """Vertex sets of a skin, each of whole faces; every face in one of them. Read-only.

    Attributes:
        part: Joint that each hull belongs to, shape (H,), ascending: the one whose summed weight
            is largest on its faces.
        first: Where the vertices of each hull start in `vertex`, and their number, shape (H + 1,).
        vertex: Vertices of hull h: ``vertex[first[h]:first[h + 1]]``. Ascending, but where a hull
            is the mirror image of one before it: then in the order of that one's.
    """

    part: Ints
    first: Ints
    vertex: NDArray[np.int32]

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for array in (self.part, self.first, self.vertex):
            array.setflags(write=False)


def skin_hulls(
    faces: ArrayLike, weights: ArrayLike, rest_vertices: ArrayLike, rest_joints: ArrayLike
) -> SkinHulls:
    """Divide a skin into vertex sets of whole faces whose hulls are tight at people's poses.

    Vertices of no face are in no set. The same input gives the same arrays, and, in one process,
    the same object.

    Args:
        faces: Triangles, shape (F, 3).
        weights: Skinning weights, shape (V, 55).
        rest_vertices: Skin at rest [m], shape (V, 3).
        rest_joints: Joints at rest [m], shape (55, 3).

    Raises:
        InputError: The arrays do not fit together.
    """
    triangles, weights, rest, joints = _arrays(faces, weights, rest_vertices, rest_joints)
    skin = _digest(triangles, weights, rest)
    key = _digest(joints, of=skin).digest()
    if key not in _known:
        digest, pieces = baked()
        symmetry = symmetry_of(triangles, rest)
        image = None if symmetry is None else symmetry.face
        # Joints are not part of the key: they only define the poses in which bulges are evaluated,
        # and their last bits depend on the machine.
        if skin.hexdigest() != digest:
            pieces = cut_faces(triangles, weights, rest, joints, image=image)
        while len(_known) >= REMEMBERED:
            _known.pop(next(iter(_known)), None)
        _known[key] = _gathered(triangles, weights, pieces, symmetry)
    return _known[key]


def bake(
    faces: ArrayLike, weights: ArrayLike, rest_vertices: ArrayLike, rest_joints: ArrayLike
) -> dict[str, NDArray[Any]]:
    """The arrays of `assets/body_cut.npz`: sha256 of the skin, and the piece of each face (F,).

    Args:
        faces, weights, rest_vertices, rest_joints: As for `skin_hulls`.
    """
    skin = _arrays(faces, weights, rest_vertices, rest_joints)
    piece = np.zeros(len(skin[0]), dtype=np.uint8)
    symmetry = symmetry_of(skin[0], skin[2])
    image = None if symmetry is None else symmetry.face
    for number, some in enumerate(cut_faces(*skin, image=image)):
        piece[some] = number
    return {"skin": np.array(_digest(*skin[:3]).hexdigest()), "piece": piece}


@cache
def baked() -> tuple[str, list[Ints]]:
    """The digest of the skin of `assets/body_cut.npz`, and the faces of its pieces."""
    with np.load(_BAKED, allow_pickle=False) as file:
        piece = file["piece"]
        return str(file["skin"]), [np.flatnonzero(piece == k) for k in range(piece.max() + 1)]


def _arrays(
    faces: ArrayLike, weights: ArrayLike, rest_vertices: ArrayLike, rest_joints: ArrayLike
) -> tuple[Ints, Array, Array, Array]:
    """Of one type each, and checked."""
    triangles = np.ascontiguousarray(faces, dtype=np.int64).reshape(-1, 3)
    weights = np.ascontiguousarray(weights, dtype=np.float64)
    rest = np.ascontiguousarray(rest_vertices, dtype=np.float64)
    joints = np.ascontiguousarray(rest_joints, dtype=np.float64)
    if weights.shape != (len(rest), N_JOINTS) or joints.shape != (N_JOINTS, 3):
        raise InputError(
            f"skin hulls: found weights {weights.shape} and joints {joints.shape} for "
            f"{len(rest)} vertices, expected ({len(rest)}, {N_JOINTS}) and ({N_JOINTS}, 3)"
        )
    if len(triangles) and not 0 <= triangles.min() <= triangles.max() < len(rest):
        raise InputError(
            f"skin hulls: faces name vertices {triangles.min()} to {triangles.max()}, but there "
            f"are {len(rest)}"
        )
    return triangles, weights, rest, joints


def _digest(*arrays: NDArray[Any], of: Any = None) -> Any:
    """The sha256 of arrays and their shapes, after what `of` has seen."""
    digest = hashlib.sha256() if of is None else of.copy()
    for array in arrays:
        digest.update(repr(array.shape).encode())
        digest.update(array.tobytes())
    return digest


def _gathered(
    faces: Ints, weights: Array, pieces: list[Ints], symmetry: Symmetry | None
) -> SkinHulls:
    """Vertex sets of face sets, those of one part together, images in the order of the left."""
    part = parts_of_faces(faces, weights)
    placed = []
    for piece in pieces:
        own = (int(part[piece[0]]), int(piece[0]))
        seen, image = own, piece
        if symmetry is not None:
            image = np.sort(symmetry.face[piece])
            seen = (int(part[image[0]]), int(image[0]))
        if symmetry is None or seen >= own or not _is_piece(image, pieces):
            placed.append((own[0], own[1], 0, np.unique(faces[piece])))
        else:
            vertices = symmetry.vertex[np.unique(faces[image])]
            placed.append((own[0], seen[1], 1, vertices))
    placed.sort(key=lambda entry: entry[:3])
    sets = [vertices.astype(np.int32) for *_, vertices in placed]
    return SkinHulls(
        part=np.array([entry[0] for entry in placed], dtype=np.int64),
        first=np.cumsum([0, *(len(s) for s in sets)], dtype=np.int64),
        vertex=np.concatenate([np.zeros(0, dtype=np.int32), *sets]),
    )


def _is_piece(faces: Ints, pieces: list[Ints]) -> bool:
    return any(piece[0] == faces[0] and np.array_equal(piece, faces) for piece in pieces)
