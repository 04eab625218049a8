"""Fewer than two frames of a file: the message says how many it has."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from halfphysics.base.reader_warnings import held
from halfphysics.errors import FileError, HalfPhysicsError, InputError
from halfphysics.formats.format import Options

T = TypeVar("T")


def in_range(
    where: str, options: Options, read: Callable[[Options], T], length: Callable[[T], int]
) -> T:
    """What `read` reads; where the frames asked for are to blame that it cannot, that is said.

    Args:
        where: Name of the file in messages.
        options: As the caller gave them.
        read: Reads the file.
        length: The number of frames of what was read.

    Raises:
        InputError: The file has fewer than two of the frames.
        FileError, InputError: As `read`.
    """
    try:
        return read(options)
    except (FileError, InputError) as error:
        if options.frames == slice(None):
            raise
        try:
            with held() as texts:
                total = length(read(replace(options, frames=slice(None))))
                texts.clear()
        except HalfPhysicsError:
            raise error from None
        too_few = few_frames(
            f"{where}: {options.clip!r}" if options.clip else where, options.frames, total
        )
        if too_few is None:
            raise
        raise too_few from None


def few_frames(where: str, frames: slice, total: int) -> InputError | None:
    """The error of a range that has fewer than two of a file's frames; None: it has more."""
    if len(range(*frames.indices(total))) >= 2:
        return None
    start, stop = ("" if end is None else end for end in (frames.start, frames.stop))
    return InputError(
        f"frames: found {start}:{stop}, but {where} has {total} frames, numbered from 0; "
        "expected at least 2 of them"
    )
