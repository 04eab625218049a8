"""Objects that Python programs stored: pickles and what is built on them.

Whatever it is, it goes through `restricted_pickle`: data comes out and nothing is run.
"""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

from halfphysics.io import restricted_pickle
from halfphysics.io.atomic import atomic_write

#: Protocol 2 and later say what they are; earlier ones are told by their names.
_PROTOCOL = b"\x80"
_SUFFIXES = (".pkl", ".pickle")


def is_stored(path: Path, head: bytes) -> bool:
    """Whether a file that begins with `head` is a stored object."""
    return head[:1] == _PROTOCOL or path.suffix.lower() in _SUFFIXES


def read(path: Path) -> Any:
    """What is stored in a file: numbers, strings, numpy arrays and containers.

    Raises:
        FileError: Anything else is in it, or it is damaged.
    """
    return restricted_pickle.load(path)


def write(path: Path, data: Any) -> None:
    """Pickle arrays, numbers, strings and containers of them.

    Raises:
        FileError: The folder is missing or cannot be written; nothing is left behind.
    """
    with atomic_write(path) as handle:
        pickle.dump(data, handle, protocol=4)
