"""Cache on disk of insets: one small npz per surface and thickness.

They are in the folder `insets` of the `cache_folder`, named by a digest of the surface, of its
thickness and of the source that makes them; the files that were not used for the longest time are
removed (`piece_cache`).
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.cache_folder import cache_folder
from halfphysics.base.made_by import made_by
from halfphysics.base.npz import Npz, write_npz
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.geometry.piece_cache import trim

Array = NDArray[np.float64]

#: Surfaces of fewer vertices are made anew: that takes some milliseconds.
FEWEST = 200
#: Bytes of a file that is read: 3 million vertices.
_MOST_FILE = 2**27


def key_of(vertices: Array, faces: NDArray[np.int32], thickness: Array) -> str:
    """What an inset is kept under: it depends on the bytes of these arrays and on the program."""
    digest = hashlib.sha256(made_by(("base", "geometry")).encode())
    for array in (vertices, faces, thickness):
        digest.update(f"{array.dtype.str}{array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def read(key: str, count: int) -> tuple[Array, Array] | None:
    """Vertices (count, 3) and thickness (count,) [m]; None: not there, or the file is damaged."""
    path = _path(key)
    if path is None or not path.is_file():
        return None
    try:
        if path.stat().st_size > _MOST_FILE:
            return None
        file = Npz(path)
        vertices = np.asarray(file["vertices"], dtype=np.float64)
        thickness = np.asarray(file["thickness"], dtype=np.float64)
        if str(file["key"]) != key or vertices.shape != (count, 3) or thickness.shape != (count,):
            return None
        if not (np.isfinite(vertices).all() and np.isfinite(thickness).all()):
            return None
    except (FileError, InputError, KeyError, ValueError, IndexError, TypeError, OSError):
        return None
    with contextlib.suppress(OSError):  # used now; a folder that is only read stays as it is
        os.utime(path)
    return vertices, thickness


def write(key: str, vertices: Array, thickness: Array) -> None:
    """Store an inset; failure gives a `HalfPhysicsWarning`."""
    path = _path(key)
    if path is None:
        return
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_npz(path, {"key": np.array(key), "vertices": vertices, "thickness": thickness})
        trim(path)
    except (FileError, OSError) as error:
        warnings.warn(
            f"the frame of a soft mesh cannot be kept for the next time: {error}. Set "
            "HALFPHYSICS_CACHE to a folder that can be written",
            HalfPhysicsWarning,
            stacklevel=2,
        )


def _path(key: str) -> Path | None:
    above = cache_folder()
    return None if above is None else above / "insets" / f"{key}.npz"
