"""From arguments to a command: tyro reads the arguments, mistakes become one message."""

from __future__ import annotations

import contextlib
import io
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

from halfphysics.cli.joint_options import joint_options
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

    errors = io.StringIO()
    try:
        with contextlib.redirect_stderr(errors), joint_options():
            parsed = tyro.cli(command, prog=prog, args=list(arguments))
    except SystemExit as stop:
        if stop.code:
            raise InputError(one_message(errors.getvalue(), prog)) from None
        print(f"examples:\n{_indented(examples)}")
        return Exit(0)
    sys.stderr.write(errors.getvalue())
    return parsed


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
    said = " ".join(sections[0])
    for section in sections[1:]:
        if section and section[0].startswith("Perhaps you meant"):
            said += f". {section[0]} {section[1] if len(section) > 1 else ''}".rstrip()
    # tyro names the group of a wrong value, which is not an option.
    said = re.sub(r"^Error parsing [a-z_]+: ", "", said)
    return f"{said.rstrip('.')}. {prog} --help explains the options"


def _indented(text: str) -> str:
    return "\n".join(f"  {line}" for line in text.strip().splitlines())
