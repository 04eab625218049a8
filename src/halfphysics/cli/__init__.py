"""The command line ``halfphysics COMMAND ...``.

A command is one file of this package with a dataclass `Command` (its fields are the options, its
docstring the help), a text `EXAMPLES`, and one line in `COMMANDS`. If the options of a command
depend on its first argument, the file has a function `read` instead.
"""

from __future__ import annotations

import contextlib
import errno
import importlib
import os
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from halfphysics.base.progress import progress
from halfphysics.base.suggestions import did_you_mean
from halfphysics.cli.loudness import is_quiet, taken
from halfphysics.cli.streams import (
    READER_GONE,
    drop_output,
    flush_output,
    output_lost,
    say,
    streams_for_closed_ones,
    streams_that_take_any_text,
)
from halfphysics.cli.wording import Voice, options_of, speak_as, spoken
from halfphysics.errors import HalfPhysicsError, HalfPhysicsWarning, InputError

#: Command -> description in one line. The module of the same name in this package implements it.
COMMANDS: Mapping[str, str] = MappingProxyType(
    {
        "demo": "play a built-in story and write result, pictures and a page",
        "scenario": "play a built-in scenario, --list names them",
        "simulate": "give a motion a body in a scene",
        "evaluate": "measure a result or a motion",
        "judge": "measure motions and results by the measures of others, and ours",
        "view": "show results in a browser, several side by side",
        "render": "make a page, a film or pictures of results",
        "pressure": "map the pressure on soft things and on skins",
        "page": "write one HTML file, with physics in it if you like",
        "fix": "put an estimator's or a generator's motion right",
        "play": "play with a simulation in a browser",
        "serve": "step a scene in real time for clients that send poses",
        "send": "play a motion as motion capture programs send it: VMC, mocopi, ...",
        "convert": "write a motion in another format or at another frame rate",
        "inspect": "say what a motion file is and how it is read, draw three poses",
        "formats": "list the motion formats",
        "sweep": "simulate variants of many clips, into a labelled data set",
        "bench": "measure speed beside a plain MuJoCo loop",
    }
)

#: Exit codes for a user's mistake and for an interruption by Ctrl-C.
MISTAKE, INTERRUPTED = 2, 130

#: Errors of the system where a stream has no room.
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)

# Commands that let numpy's libraries have one thread: they measure processor time.
_ONE_THREAD = ("bench",)

# A longer warning [characters] is told apart into its statements.
_LONG = 240

_USAGE = "usage: halfphysics COMMAND ...   (halfphysics COMMAND --help explains a command)"


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code.

    0; 2 for a user's mistake; 130 for Ctrl-C; 141 where nobody reads what it prints any more.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    speak_as(Voice)

    def run() -> int:
        words, loudness = taken(arguments)
        with loudness.applied():
            return _run(words)

    return guarded(run)


def guarded(run: Callable[[], int], program: str = "halfphysics") -> int:
    """The exit code of `run`: a user's mistake and a warning become one line each on stderr.

    Args:
        run: A command; returns its exit code.
        program: The name at the beginning of each message.
    """
    with (
        warnings.catch_warnings(),
        streams_for_closed_ones(),
        streams_that_take_any_text(),
    ):
        warnings.simplefilter("always", HalfPhysicsWarning)
        warnings.showwarning = _show_warning(warnings.showwarning, program)
        try:
            code = run()
            flush_output()
            return code
        except HalfPhysicsError as error:
            say(f"{program}: error: {spoken(str(error))}")
            with contextlib.suppress(HalfPhysicsError, OSError):
                flush_output()
            return MISTAKE
        except KeyboardInterrupt:
            return INTERRUPTED
        except BrokenPipeError:
            drop_output()
            return READER_GONE
        except OSError as error:
            # Files are written by `atomic_write`, which raises errors of ours: this is a stream.
            if error.errno not in FULL or error.filename is not None:
                raise
            say(f"{program}: error: {output_lost(error)}")
            return MISTAKE


def _run(arguments: list[str]) -> int:
    if not arguments or arguments[0] in ("-h", "--help"):
        print(_overview(), file=sys.stdout if arguments else sys.stderr)
        return 0 if arguments else MISTAKE
    name, *rest = arguments
    if name == "--version":
        from halfphysics import __version__

        print(f"halfphysics {__version__}")
        return 0
    if name not in COMMANDS:
        hint = did_you_mean(name, COMMANDS, otherwise=".")
        raise InputError(
            f"unknown command {name!r}{hint} Expected one of {', '.join(COMMANDS)}. "
            "halfphysics --help explains them"
        )
    # Before the import of numpy: its libraries read these variables once.
    if name in _ONE_THREAD and "numpy" not in sys.modules:
        from halfphysics.base.workers import THREADS

        os.environ.update(dict.fromkeys(THREADS, "1"))
    from halfphysics.cli.parsing import Exit, parse

    module: Any = importlib.import_module(f"{__name__}.{name}")
    if hasattr(module, "Command"):
        speak_as(lambda: Voice(options_of(module.Command), plan=name == "sweep"))
    if hasattr(module, "read"):
        command = module.read(f"halfphysics {name}", rest)
    else:
        command = parse(module.Command, f"halfphysics {name}", module.EXAMPLES, rest)
    if isinstance(command, Exit):
        return command.code
    with progress():  # at a terminal, whatever takes longer than two seconds
        command.run()
    return 0


def _overview() -> str:
    width = max(map(len, COMMANDS))
    lines = [f"  {name.ljust(width)}  {what}" for name, what in COMMANDS.items()]
    return "\n".join(
        [
            "halfphysics: give a kinematic human a body.",
            "",
            _USAGE,
            "",
            *lines,
            "",
            "example:",
            "  halfphysics demo",
            "  halfphysics simulate walk.npz --scene room.yaml --out result.npz",
            "",
            "-q prints nothing but errors, -v also what is done (-vv: in detail);",
            "halfphysics --version prints the version.",
        ]
    )


def _show_warning(other: Any, program: str) -> Any:
    """A handler that prints our warnings and passes other warnings to `other`.

    A warning is one line; a long one of several statements has each in a line of its own.
    """

    def show(message: Any, category: type[Warning], *rest: Any, **named: Any) -> None:
        if issubclass(category, HalfPhysicsWarning):
            if is_quiet():
                return
            text = spoken(str(message))
            text = text if len(text) <= _LONG else text.replace("; ", "\n  ")
            say(f"{program}: warning: {text}")
        else:
            other(message, category, *rest, **named)

    return show
