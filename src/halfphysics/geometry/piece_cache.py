"""Cache on disk of convex decompositions: one small npz per mesh and set of options.

They are in the folder `pieces` of the `cache_folder`.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.cache_folder import cache_folder
from halfphysics.base.npz import Npz, write_npz
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.geometry.mesh import Mesh

Array = NDArray[np.float64]


def read(key: str) -> tuple[list[Mesh], Array] | None:
    """Pieces and error figures stored under `key`; None: there are none, or the file is damaged."""
    path = _path(key)
    if path is None or not path.is_file():
        return None
    try:
        file = Npz(path)
        if str(file["key"]) != key:
            return None
        figures = np.asarray(file["figures"], dtype=np.float64)
        vertices, faces = np.asarray(file["vertices"]), np.asarray(file["faces"])
        ends = [np.cumsum(np.asarray(file[n], dtype=np.int64)) for n in ("n_vertices", "n_faces")]
        if ends[0][-1] != len(vertices) or ends[1][-1] != len(faces):
            return None
        parts = (
            np.split(array, end[:-1]) for array, end in zip((vertices, faces), ends, strict=True)
        )
        pieces = [Mesh(v, f) for v, f in zip(*parts, strict=True)]
    except (FileError, InputError, KeyError, ValueError, IndexError):
        return None
    return pieces, figures


def write(key: str, pieces: list[Mesh], figures: Array) -> None:
    """Store pieces and error figures; failure gives a `HalfPhysicsWarning`."""
    path = _path(key)
    if path is None:
        return
    arrays = {
        "key": np.array(key),
        "figures": figures,
        "vertices": np.concatenate([p.vertices for p in pieces]),
        "faces": np.concatenate([p.faces for p in pieces]),
        "n_vertices": np.array([len(p.vertices) for p in pieces]),
        "n_faces": np.array([len(p.faces) for p in pieces]),
    }
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_npz(path, arrays)
    except (FileError, OSError) as error:
        warnings.warn(
            f"the pieces of a mesh cannot be kept for the next time: {error}. Set "
            "HALFPHYSICS_CACHE to a folder that can be written",
            HalfPhysicsWarning,
            stacklevel=2,
        )


def _path(key: str) -> Path | None:
    folder = cache_folder()
    return None if folder is None else folder / "pieces" / f"{key}.npz"
