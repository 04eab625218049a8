"""Warnings of readers and of what they load, shown at the caller's line outside the package.

What a reader takes for granted is said once a file: `one_warning` puts all that is warned of while
a file is read into a single line.
"""

from __future__ import annotations

import contextlib
import re
import sys
import warnings
from collections.abc import Iterator
from contextvars import ContextVar
from pathlib import Path

from halfphysics.errors import HalfPhysicsWarning

#: The package, and what stands between it and itself where a block of `one_warning` ends.
_INSIDE = (str(Path(__file__).resolve().parent.parent), contextlib.__file__)


#: What is warned of in the block of `one_warning` that runs, if one does.
_texts: ContextVar[list[str] | None] = ContextVar("texts", default=None)


def warn(message: str) -> None:
    """Warn at the first frame outside the package, however deep the reader is."""
    if (texts := _texts.get()) is not None:
        texts.append(message)
        return
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_INSIDE):
        frame, level = frame.f_back, level + 1
    warnings.warn(message, HalfPhysicsWarning, stacklevel=level)


@contextlib.contextmanager
def held() -> Iterator[list[str]]:
    """What the block warns of, kept in the list: the caller warns of it, or drops it.

    Where the block ends in an error, all of it is warned of.
    """
    texts: list[str] = []
    before = _texts.set(texts)
    try:
        yield texts
    except BaseException:
        _texts.reset(before)
        for text in texts:
            warn(text)
        raise
    _texts.reset(before)


@contextlib.contextmanager
def one_warning(path: Path) -> Iterator[None]:
    """All warnings of `warn` in the block as one: where they are once, each after a semicolon.

    Only this thread's: others may read at the same time.

    Args:
        path: The file that is read; warnings begin with it, or with "PATH, clip 'NAME'".

    Warns:
        HalfPhysicsWarning: What was warned of in the block, also where it ends in an error.
    """
    texts: list[str] = []
    before = _texts.set(texts)
    try:
        yield
    finally:
        _texts.reset(before)
        if texts:
            where = re.compile(rf"""{re.escape(str(path))}(?:, clip (?:'.*?'|".*?"))?: """)
            found = [match[0] for text in texts if (match := where.match(text))]
            told = dict.fromkeys(where.sub("", text, count=1).rstrip(".") for text in texts)
            warn(f"{max(found, key=len, default='')}{'; '.join(told)}")
