"""Safe reading of `.npy` files: memory-mapped, no pickles."""

from __future__ import annotations

import math
import os
import tokenize
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import FileError


def read_header(stream: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Shape, whether in Fortran's order, and type of the array that a stream begins with.

    Raises:
        ValueError: It is no header of an array. Errors of the stream itself are passed on.
    """
    readers = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }
    version = np.lib.format.read_magic(stream)
    if version not in readers:
        raise ValueError(f"array format version {version}")
    try:
        shape, fortran, dtype = readers[version](stream)
    except (SyntaxError, tokenize.TokenError, TypeError, RecursionError, MemoryError) as error:
        # numpy parses the header as Python source.
        raise ValueError(f"its header is no header of an array: {error}") from None
    if any(isinstance(n, bool) or n < 0 for n in shape) or not dtype.itemsize:
        raise ValueError(f"its header says shape {shape} of {dtype}")
    return shape, fortran, dtype


class Npy:
    """An array in a file. The header is read at once, the numbers when they are used.

    Raises:
        FileError: The file is no npy, or shorter than its header promises.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        try:
            with self.path.open("rb") as stream:
                #: Shape, order and type that the header promises.
                self.shape, self.fortran, self.dtype = read_header(stream)
                self.offset = stream.tell()
                size = self.path.stat().st_size - self.offset
        except (ValueError, EOFError, OSError) as error:
            raise FileError(
                f"{self.path}: damaged .npy file ({error}). Download or copy the file again"
            ) from None
        needed = math.prod(self.shape) * self.dtype.itemsize
        if not self.dtype.hasobject and size < needed:
            raise FileError(
                f"{self.path}: truncated: {size} bytes of numbers for shape {self.shape} of "
                f"{self.dtype}, which needs {needed}. Download or copy the file again"
            )

    @property
    def array(self) -> NDArray[Any]:
        """The numbers, read from the disk as they are used; read-only.

        Raises:
            FileError: It holds Python objects.
        """
        if self.dtype.hasobject:
            raise FileError(
                f"{self.path}: holds Python objects (a pickle), expected an array of numbers"
            )
        if 0 in self.shape:
            return np.empty(self.shape, self.dtype)
        return np.memmap(
            self.path,
            dtype=self.dtype,
            mode="r",
            offset=self.offset,
            shape=self.shape,
            order="F" if self.fortran else "C",
        )
