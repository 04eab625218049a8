"""Files of one array (.npy): a clip, or several along a leading axis.

Several are named "0", "1", ...; one alone by its file.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from halfphysics.errors import FileError
from halfphysics.formats.format import Options, Source


def clip_names(source: Source, axes: int) -> list[str]:
    """Names of the clips of a file whose clips have so many axes."""
    shape = source.npy.shape if source.npy is not None else ()
    if len(shape) > axes and shape[0] != 1:
        if 0 in shape[1:]:  # as many clips as a header likes to say, of nothing
            raise FileError(f"{source.path}: found clips of shape {shape[1:]}, expected frames")
        return [str(k) for k in range(shape[0])]
    return [source.path.stem]


def clip_of(source: Source, options: Options, axes: int) -> tuple[str, NDArray[Any]]:
    """Name in messages and array of the clip that is asked for.

    Raises:
        FileError: The file holds no array.
    """
    if source.npy is None:
        raise FileError(f"{source.path}: no array of numbers")
    array, where = source.npy.array, str(source.path)
    if array.ndim == axes:
        return where, array
    names = clip_names(source, axes)
    if len(names) > 1:
        where = f"{where}, clip {options.clip!r}"
    return where, array[names.index(options.clip)]
