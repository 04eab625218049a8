"""JSON files of strangers: read whole, up to a size that memory holds many times."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from halfphysics.errors import FileError

#: Python's lists and numbers take up to 20 times the space of their text [bytes].
MAX_BYTES = 64 * 2**20


def is_json(head: bytes) -> bool:
    """Whether a file that begins with `head` is a JSON object or list."""
    return head.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] in (b"{", b"[")


def read(path: Path) -> Any:
    """The content of a JSON file.

    Raises:
        FileError: It is damaged, nested too deeply or larger than `MAX_BYTES`.
    """
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise FileError(
                f"{path}: {size / 2**20:.0f} MiB, expected at most {MAX_BYTES // 2**20} MiB of "
                "JSON. Save its arrays as .npz"
            )
        return json.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise FileError(f"{path}: cannot read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise FileError(
            f"{path}: not readable as JSON ({error}). Is it truncated? Copy the file again"
        ) from None
