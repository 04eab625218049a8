"""Small JSON files of a sweep: canonical text, written whole, read with care."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from halfphysics.base.atomic import atomic_write, reason
from halfphysics.errors import FileError


def text_of(document: Mapping[str, Any]) -> str:
    """One line of JSON: the same values give the same text.

    Raises:
        ValueError: A number is not finite: no JSON reader takes it.
    """
    return json.dumps(
        document, ensure_ascii=False, sort_keys=True, separators=(",", ":"), allow_nan=False
    )


@contextmanager
def replacing(path: Path, *, lasting: bool = False) -> Iterator[IO[bytes]]:
    """A binary file to write to that replaces `path` when the block ends without an error.

    Args:
        path: Its folder is made where it is missing.
        lasting: Wait until the bytes are on the disk: what is deleted next depends on them.

    Raises:
        FileError: It cannot be written; nothing is left behind.
    """
    with reported(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as handle:
            yield handle
            if lasting:
                handle.flush()
                os.fsync(handle.fileno())


@contextmanager
def reported(path: Path) -> Iterator[None]:
    """Errors of the system as `FileError`."""
    try:
        yield
    except OSError as error:
        raise FileError(f"{path}: cannot write: {reason(error)}") from None


def write(path: Path, document: Mapping[str, Any], *, lasting: bool = False) -> None:
    """Write a document, whole or not at all."""
    with replacing(path, lasting=lasting) as handle:
        handle.write(text_of(document).encode() + b"\n")


def read(path: Path) -> dict[str, Any] | None:
    """A document; None where there is none, or half of one, or something else.

    Raises:
        FileError: It is there and the system does not let us read it.
    """
    try:
        document = json.loads(path.read_bytes())
    except FileNotFoundError:
        return None
    except OSError as error:
        raise FileError(f"{path}: cannot read: {error.strerror}") from None
    except (ValueError, RecursionError):
        return None
    return document if isinstance(document, dict) else None
