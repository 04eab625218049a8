"""Warnings of the readers, shown at the line of the caller outside the package.

What a reader takes for granted is said once a file: `one_warning` puts all that is warned of while
a file is read into a single line.
"""

from __future__ import annotations

import contextlib
import re
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path

from halfphysics.errors import HalfPhysicsWarning

#: The package, and what stands between it and itself where a block of `one_warning` ends.
_INSIDE = (str(Path(__file__).resolve().parent.parent), contextlib.__file__)


def warn(message: str) -> None:
    """Warn at the first frame outside the package, however deep the reader is."""
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_INSIDE):
        frame, level = frame.f_back, level + 1
    warnings.warn(message, HalfPhysicsWarning, stacklevel=level)


@contextlib.contextmanager
def one_warning(path: Path) -> Iterator[None]:
    """All warnings of ours in the block as one: where they are once, then each after a semicolon.

    Args:
        path: The file that is read; warnings begin with it, or with "PATH, clip 'NAME'".

    Warns:
        HalfPhysicsWarning: What was warned of in the block. Warnings of others are passed on.
    """
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", HalfPhysicsWarning)
        yield
    texts = []
    for each in caught:
        if issubclass(each.category, HalfPhysicsWarning):
            texts.append(str(each.message))
        else:
            warnings.warn_explicit(each.message, each.category, each.filename, each.lineno)
    if not texts:
        return
    where = re.compile(rf"""{re.escape(str(path))}(?:, clip (?:'.*?'|".*?"))?: """)
    found = [match[0] for text in texts if (match := where.match(text))]
    told = dict.fromkeys(where.sub("", text, count=1).rstrip(".") for text in texts)
    warn(f"{max(found, key=len, default='')}{'; '.join(told)}")
