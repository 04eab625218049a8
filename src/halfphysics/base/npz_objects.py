"""`.npz` files with members that numpy pickled because they are no arrays of numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from halfphysics.base import pickle_placeholders, restricted_pickle
from halfphysics.base.npz import DAMAGE, Npz
from halfphysics.errors import FileError


class NpzObjects(Npz):
    """As `Npz`, and fields of Python objects go through the restricted unpickler.

    An array of no dimensions around an object (``numpy.savez(path, body={...})``) is that object.
    """

    def __getitem__(self, key: str) -> Any:
        if key not in self._members or not self.header(key)[1].hasobject:
            return super().__getitem__(key)
        size = self._members[key].file_size
        if size > pickle_placeholders.MAX_BYTES:
            raise FileError(
                f"{self.path}: field '{key}' unpacks to {size / 2**30:.1f} GiB, expected at most "
                f"{pickle_placeholders.MAX_BYTES / 2**30:.0f} GiB in one pickle"
            )
        try:
            with self._open(key) as stream:
                self._read_header(key, stream)
                data = stream.read()
        except DAMAGE as error:
            raise self._damaged(key, str(error)) from None
        content = restricted_pickle.loads(data, f"{self.path}: field '{key}'")
        return content.item() if isinstance(content, np.ndarray) and content.ndim == 0 else content
