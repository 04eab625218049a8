"""From arguments to a command: tyro reads the arguments, mistakes become one message."""

from __future__ import annotations

import contextlib
import io
import os
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

from halfphysics.cli.help_page import BOX_COLUMNS, help_page
from halfphysics.cli.value_types import value_types
from halfphysics.errors import InputError

T = TypeVar("T")

_ANSI = re.compile(r"\x1b\[[0-9;]*m")
_FRAME = "╭╮╰╯│─"


@dataclass(frozen=True)
class Exit:
    """The result of arguments that only request help."""

    code: int


def parse(command: type[T], prog: str, examples: str, arguments: Sequence[str]) -> T | Exit:
    """The command that the arguments describe, or `Exit` after printing its help.

    Raises:
        InputError: The arguments do not fit; all mistakes are in one message.
    """
    import tyro

    printed, errors = _Caught(), _Caught()
    try:
        with (
            contextlib.redirect_stdout(printed),
            contextlib.redirect_stderr(errors),
            _columns(BOX_COLUMNS),
            value_types(),
        ):
            parsed = tyro.cli(command, prog=prog, args=list(arguments))
    except SystemExit as stop:
        if stop.code:
            raise InputError(one_message(errors.text(), prog)) from None
        print(help_page(_ANSI.sub("", printed.text()), examples), end="")
        return Exit(0)
    sys.stdout.write(printed.text())
    sys.stderr.write(errors.text())
    return parsed


class _Caught(io.TextIOWrapper):
    """What is printed, as text. Its encoding says that frames can be drawn."""

    def __init__(self) -> None:
        super().__init__(io.BytesIO(), encoding="utf-8")

    def text(self) -> str:
        """All that was printed."""
        self.flush()
        self.seek(0)
        return self.read()


@contextlib.contextmanager
def _columns(count: int) -> Iterator[None]:
    """The width that tyro draws for, whatever the terminal has."""
    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = str(count)
    try:
        yield
    finally:
        if before is None:
            del os.environ["COLUMNS"]
        else:
            os.environ["COLUMNS"] = before


def one_message(box: str, prog: str) -> str:
    """The text of tyro's framed error box as one line."""
    sections: list[list[str]] = [[]]
    for raw in _ANSI.sub("", box).splitlines():
        if raw.startswith(("╭", "╰")):
            continue
        line = raw.strip(" │")
        if line and not line.strip(_FRAME):
            sections.append([])
        elif line:
            sections[-1].append(line)
    said = _plainly(" ".join(sections[0]))
    for section in sections[1:]:
        if section and section[0].startswith("Perhaps you meant") and len(section) > 1:
            said += f"; did you mean {_option_in(section[1])}?"
    # A question mark ends a sentence as a full stop does.
    stop = "" if said.endswith("?") else "."
    return f"{said.rstrip('.')}{stop} {prog} --help explains the options"


def _option_in(line: str) -> str:
    """The long option of a line of help, such as `-o FILE, --out FILE`."""
    found = re.search(r"--[\w-]+", line)
    return found[0] if found else line.split()[0]


def _plainly(said: str) -> str:
    """What tyro says, in our words."""
    # tyro names the group of a wrong value, which is not an option.
    said = re.sub(r"^Error parsing [a-z_]+: ", "", said)
    said = re.sub(r"^Error parsing (\S+): ", r"\1: ", said)
    if found := re.match(r"Missing value for argument '(\S+?)'", said):
        return f"{found[1].split('/')[-1]} needs a value"
    if said.startswith("Unrecognized options: "):
        words = said.removeprefix("Unrecognized options: ").split(", ")
        wrong = [word for word in words if word.startswith("-")]
        if wrong:
            return f"unknown option {' and '.join(wrong)}"
        return f"found {', '.join(map(repr, words))} beyond what is expected"
    if found := re.match(r"Missing from .*?: (.*)", said):
        entries = re.findall(r"(\S+) (.*?)\.? \(required\)", found[1])
        missing = ", and ".join(f"{name} ({about.lower()})" for name, about in entries)
        return f"missing: {missing or found[1]}"
    return said
