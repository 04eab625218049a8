"""Safe reading of `.npy` files: memory-mapped, no pickles."""

from __future__ import annotations

import os
import tokenize
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import FileError


class Npy:
    """An array in a file. The header is read at once, the numbers when they are used.

    Raises:
        FileError: The file is no npy, or shorter than its header promises.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        readers = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }
        try:
            with self.path.open("rb") as stream:
                version = np.lib.format.read_magic(stream)
                if version not in readers:
                    raise ValueError(f"array format version {version}")
                #: Shape, order and type that the header promises.
                self.shape, self.fortran, self.dtype = readers[version](stream)
                self.offset = stream.tell()
                size = self.path.stat().st_size - self.offset
        except (ValueError, SyntaxError, tokenize.TokenError, EOFError, OSError) as error:
            raise FileError(
                f"{self.path}: damaged .npy file ({error}). Download or copy the file again"
            ) from None
        needed = int(np.prod(self.shape, dtype=np.float64)) * self.dtype.itemsize
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
