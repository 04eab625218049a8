"""Cache on disk of convex decompositions: one small npz per mesh and set of options.

They are in the folder `pieces` of the `cache_folder`, which holds `MOST_BYTES`: the files that were
not used for the longest time are removed.
"""

from __future__ import annotations

import contextlib
import os
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.cache_folder import cache_folder
from halfphysics.base.npz import Npz, write_npz
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.geometry.mesh import Mesh

Array = NDArray[np.float64]

#: Bytes of all files (0.3 MB for a chair of 160 pieces), and of one that is read.
MOST_BYTES, _MOST_FILE = 2**28, 2**26


def read(key: str) -> tuple[list[Mesh], Array] | None:
    """Pieces and error figures stored under `key`; None: there are none, or the file is damaged."""
    path = _path(key)
    if path is None or not path.is_file():
        return None
    try:
        if path.stat().st_size > _MOST_FILE:
            return None
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
    except (FileError, InputError, KeyError, ValueError, IndexError, TypeError, OSError):
        return None
    with contextlib.suppress(OSError):  # used now; a folder that is only read stays as it is
        os.utime(path)
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
        trim(path)
    except (FileError, OSError) as error:
        warnings.warn(
            f"the pieces of a mesh cannot be kept for the next time: {error}. Set "
            "HALFPHYSICS_CACHE to a folder that can be written",
            HalfPhysicsWarning,
            stacklevel=2,
        )


def folder() -> Path | None:
    """Where pieces are kept; None: nowhere."""
    above = cache_folder()
    return None if above is None else above / "pieces"


def _path(key: str) -> Path | None:
    where = folder()
    return None if where is None else where / f"{key}.npz"


def trim(newest: Path) -> None:
    """Remove files that were not used for the longest time, down to `MOST_BYTES`."""
    known = []
    for path in newest.parent.glob("*.npz"):
        with contextlib.suppress(OSError):  # another process removed it
            known.append((path.stat().st_mtime, path.stat().st_size, path))
    total = sum(size for _, size, _ in known)
    for _, size, path in sorted(known, key=lambda entry: (entry[0], str(entry[2]))):
        if total <= MOST_BYTES:
            return
        if path != newest:
            with contextlib.suppress(OSError):
                path.unlink()
                total -= size
