"""The names under which files have their frame rate."""

from __future__ import annotations

from collections.abc import Iterable

from halfphysics.formats.checked_fields import Record

#: Without case and what separates words ("mocap_frame_rate", "frameRate", "video-fps"); of several
#: in a file the first of these counts: the motion's own before that of the video it is from.
_NAMES = ("mocapframerate", "mocapfps", "fps", "framerate", "videofps")
_SEPARATORS = str.maketrans("", "", "_- ")


def is_rate(name: object) -> bool:
    """Whether a field of this name is a frame rate."""
    return isinstance(name, str) and _bare(name) in _NAMES


def is_of_video(name: str) -> bool:
    """Whether a rate of this name may differ from that of the motion."""
    return _bare(name) == _NAMES[-1]


def rate_keys(names: Iterable[object], first: Iterable[str] = ()) -> list[str]:
    """The names of frame rates among these, the one that counts first; `first`: before others."""
    found = sorted((str(n) for n in names if is_rate(n)), key=lambda n: _NAMES.index(_bare(n)))
    before = [name for name in first if name in found]
    return [*before, *(name for name in found if name not in before)]


def said_rate(record: Record, first: Iterable[str] = ()) -> float | None:
    """The frame rate that a file says; None: it has no such field, or None in it.

    Raises:
        FileError: The field is no positive number.
    """
    for key in rate_keys(record.fields, first):
        if record.raw(key) is not None:
            return record.number(key, above=0.0)
    return None


def _bare(name: str) -> str:
    return name.lower().translate(_SEPARATORS)
