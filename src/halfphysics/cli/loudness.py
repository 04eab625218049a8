"""How much a command prints: -q only errors, -v also what is done, -vv in detail."""

from __future__ import annotations

import contextlib
import logging
import os
import sys
from collections.abc import Iterator, Sequence
from contextvars import ContextVar
from dataclasses import dataclass

from halfphysics.errors import InputError

#: Option -> how much louder it makes a command; quiet is one less.
_STEPS = {"-q": -1, "--quiet": -1, "-v": 1, "--verbose": 1, "-vv": 2}
#: Steps -> level of the logger "halfphysics".
_LEVELS = {1: logging.INFO, 2: logging.DEBUG}

_quiet: ContextVar[bool] = ContextVar("quiet", default=False)


def is_quiet() -> bool:
    """Whether only errors are printed."""
    return _quiet.get()


@dataclass(frozen=True)
class Loudness:
    """How much is printed: -1 errors alone, 0 as usual, 1 or 2 the log too."""

    steps: int = 0

    @contextlib.contextmanager
    def applied(self) -> Iterator[None]:
        """While the block runs, print this much."""
        with contextlib.ExitStack() as stack:
            if self.steps < 0:
                before = _quiet.set(True)
                stack.callback(_quiet.reset, before)
                nowhere = stack.enter_context(open(os.devnull, "w", encoding="utf-8"))
                stack.enter_context(contextlib.redirect_stdout(nowhere))
            elif self.steps > 0:
                stack.enter_context(_logged(_LEVELS[min(self.steps, max(_LEVELS))]))
            yield


def taken(arguments: Sequence[str]) -> tuple[list[str], Loudness]:
    """The arguments without those of this file, and what these ask for.

    Raises:
        InputError: Both less and more is asked for.
    """
    end = arguments.index("--") if "--" in arguments else len(arguments)
    mine = [word for word in arguments[:end] if word in _STEPS]
    rest = [word for word in arguments[:end] if word not in _STEPS]
    steps = [_STEPS[word] for word in mine]
    if steps and min(steps) < 0 < max(steps):
        raise InputError(f"{' and '.join(mine)}: expected --quiet or --verbose, found both")
    return [*rest, *arguments[end:]], Loudness(max(sum(steps), -1))


@contextlib.contextmanager
def _logged(level: int) -> Iterator[None]:
    """The package's log on standard error."""
    logger = logging.getLogger("halfphysics")
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter("halfphysics: %(message)s"))
    before = logger.level
    logger.addHandler(handler)
    logger.setLevel(level)
    try:
        yield
    finally:
        logger.setLevel(before)
        logger.removeHandler(handler)
