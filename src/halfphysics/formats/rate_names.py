"""The names under which files have their frame rate."""

from __future__ import annotations

from collections.abc import Iterable

from halfphysics.formats.checked_fields import Record

#: Without case and what separates words: "mocap_frame_rate", "frameRate", "video-fps".
_NAMES = frozenset({"fps", "framerate", "mocapfps", "mocapframerate", "videofps"})
_SEPARATORS = str.maketrans("", "", "_- ")


def is_rate(name: object) -> bool:
    """Whether a field of this name is a frame rate."""
    return isinstance(name, str) and name.lower().translate(_SEPARATORS) in _NAMES


def rate_key(names: Iterable[object], first: Iterable[str] = ()) -> str | None:
    """The name of the frame rate among these: one of `first` before others; None: there is none."""
    found = [str(name) for name in names if is_rate(name)]
    return next((name for name in (*first, *found) if name in found), None)


def said_rate(record: Record, first: Iterable[str] = ()) -> float | None:
    """The frame rate that a file says; None: it has no such field, or None in it.

    Raises:
        FileError: The field is no positive number.
    """
    there = [key for key in record.fields if is_rate(key) and record.raw(key) is not None]
    key = rate_key(there, first)
    return None if key is None else record.number(key, above=0.0)
