"""Standard output that nobody reads, or that has no room, ends a command quietly.

What its encoding does not have is written as an escape such as \\u28ff.
"""

from __future__ import annotations

import contextlib
import io
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


@contextlib.contextmanager
def streams_that_take_any_text() -> Iterator[None]:
    """In the block, what the encoding of a standard stream lacks is written as an escape."""
    with contextlib.ExitStack() as stack:
        for stream in (sys.stdout, sys.stderr):
            if not isinstance(stream, io.TextIOWrapper):
                continue
            before = stream.errors or "strict"
            unicode = stream.encoding.lower().replace("-", "").startswith("utf")
            # A name that is no text is written as it is where the encoding can.
            if before == "strict" or (before == "surrogateescape" and not unicode):
                stream.reconfigure(errors="backslashreplace")
                stack.callback(_restore, stream, before)
        yield


def _restore(stream: io.TextIOWrapper, errors: str) -> None:
    with contextlib.suppress(OSError, ValueError):  # closed in between, or without room
        stream.reconfigure(errors=errors)


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
