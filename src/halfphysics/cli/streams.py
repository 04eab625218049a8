"""Standard output that nobody reads, or that has no room, ends a command quietly."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator

from halfphysics.errors import FileError

#: Exit code of a command whose reader has gone (`| head -1`): as of one that SIGPIPE ended.
READER_GONE = 141


@contextlib.contextmanager
def streams_for_closed_ones() -> Iterator[None]:
    """In the block, print to nowhere where a standard stream was closed before (``>&-``)."""
    with contextlib.ExitStack() as stack:
        for name, redirect in (
            ("stdout", contextlib.redirect_stdout),
            ("stderr", contextlib.redirect_stderr),
        ):
            if getattr(sys, name) is None:
                nowhere = stack.enter_context(open(os.devnull, "w", encoding="utf-8"))
                stack.enter_context(redirect(nowhere))
        yield


def flush_output() -> None:
    """Write what is printed.

    Raises:
        FileError: There is no room for it (`> /dev/full`).
        BrokenPipeError: Nobody reads it any more.
    """
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise output_lost(error) from None


def output_lost(error: OSError) -> FileError:
    """What to say where printing failed; what is still to print goes nowhere."""
    drop_output()
    return FileError(f"standard output: cannot write: {error.strerror or error}")


def drop_output() -> None:
    """Send what is left of standard output nowhere: the interpreter writes it when it ends."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def say(line: str) -> None:
    """A line on standard error, if it can be written."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        print(line, file=sys.stderr, flush=True)
