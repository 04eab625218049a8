"""The contents of a file of a sample, read from its bytes."""

from __future__ import annotations

import io
import json
import tarfile
import zipfile
import zlib
from typing import Any

import numpy as np

#: Exceptions that reading a damaged file or archive can raise.
DAMAGE = (
    tarfile.TarError,
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    ValueError,
    KeyError,
    OSError,
)


def contents(name: str, data: bytes) -> Any:
    """The values of a JSON file, or the arrays of an npz file by name; nothing is unpickled.

    Raises one of `DAMAGE` if the file is neither.
    """
    if name.endswith(".json"):
        return json.loads(data)
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        return dict(arrays)
