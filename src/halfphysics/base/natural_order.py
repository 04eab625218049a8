"""Names in the order in which people count: "frame2" before "frame10"."""

from __future__ import annotations

import re

#: Digits beyond these are compared as text: no number of a frame has more.
_LONGEST = 18
_NUMBER = re.compile(rf"(\d{{1,{_LONGEST}}})")


def natural(name: str) -> tuple[tuple[str, int], ...]:
    """A key for `sorted`: the text between numbers, and the numbers, in turns."""
    parts = _NUMBER.split(name)
    numbers = [int(part) for part in parts[1::2]]
    return tuple(zip(parts[::2], [*numbers, -1], strict=True))
