"""Lines of a shell, each run through the command line's own `main`."""

from __future__ import annotations

import importlib
import re
import shlex
import subprocess
from collections.abc import Callable, Sequence

from halfphysics.cli import COMMANDS, main
from halfphysics.cli.parsing import Exit, parse
from halfphysics.errors import InputError
from support.paths import ROOT
from support.printed.installed import packages_of

PROJECT = "halfphysics"
#: Modules of tools that make releases, which the document says to install.
ELSEWHERE = {"build", "cibuildwheel"}
#: Commands that are read to the last option, and not run.
READ_ONLY = {
    "bench": "takes minutes; tests/bench runs its cases",
}


#: Commands that depend on no file and make none that a later line reads: run once in a process, of
#: however many documents print them, and then read.
ONCE = {"demo"}
_run_once: set[tuple[str, ...]] = set()


def lines_of(text: str) -> list[str]:
    """The commands of a block: continued lines joined, comments and prompts left out."""
    joined = re.sub(r"\s*\\\n\s*", " ", text)
    lines = (line.strip().removeprefix("$ ") for line in joined.splitlines())
    return [line for line in lines if line and not line.startswith("#")]


def run_line(line: str) -> None:
    """Run one line in the current folder; fails with what it printed on a mistake."""
    words = shlex.split(line, comments=True)
    while re.match(r"^\w+=", words[0]):
        words.pop(0)
    program, *arguments = words
    _PROGRAMS[program](arguments)


def read_mention(arguments: Sequence[str]) -> None:
    """The same of a command in a sentence, which may leave out required options."""
    try:
        read_command(arguments)
    except InputError as error:
        if not str(error).startswith(("Required options", "missing")):
            raise


def read_command(arguments: Sequence[str]) -> None:
    """Read the options of a command of `halfphysics`; a mistake in them is an error."""
    name, *rest = arguments
    if name.startswith("-"):
        assert main(list(arguments)) == 0
        return
    assert name in COMMANDS, f"there is no command {name}"
    module = importlib.import_module(f"halfphysics.cli.{name}")
    if hasattr(module, "read"):
        found = module.read(f"halfphysics {name}", rest)
    else:
        found = parse(module.Command, f"halfphysics {name}", module.EXAMPLES, rest)
    assert not isinstance(found, Exit) or found.code == 0


def _halfphysics(arguments: Sequence[str]) -> None:
    if arguments[0] in READ_ONLY or tuple(arguments) in _run_once:
        read_command(arguments)
    else:
        if arguments[0] in ONCE:
            _run_once.add(tuple(arguments))
        assert main(list(arguments)) == 0, f"halfphysics {shlex.join(arguments)}"


def _run_script(arguments: Sequence[str]) -> None:
    """`./run COMMAND`: what would run in .venv is read, not run."""
    name, *rest = arguments
    if name == "evidence":
        _evidence(rest)
    elif name in ("test", "check", "docs"):
        _pytest(rest)
    else:
        read_command(arguments)


def _evidence(arguments: Sequence[str]) -> None:
    from evidence.command import EXAMPLES, PROGRAM, Command

    parse(Command, PROGRAM, EXAMPLES, arguments)


def _pytest(arguments: Sequence[str]) -> None:
    for word in arguments:
        if word.startswith(("tests/", "examples/")):
            assert (ROOT / word).exists(), word


def _pip(arguments: Sequence[str]) -> None:
    assert arguments[0] == "install"
    for word in arguments[1:]:
        if not word.startswith("-"):
            packages_of(word)


def _python(arguments: Sequence[str]) -> None:
    """A script of the repository, or a module of its tests: it must be there."""
    if arguments[0] == "-m":
        name = arguments[1].replace(".", "/")
        if arguments[1] == "pip":
            _pip(arguments[2:])
            return
        if arguments[1] in ELSEWHERE:
            return
        if arguments[1] == "pytest":
            _pytest(arguments[2:])
            return
        places = [ROOT / name, ROOT / f"{name}.py", ROOT / "tests" / f"{name}.py"]
        assert any(place.exists() for place in places), arguments[1]
    else:
        assert (ROOT / arguments[0]).is_file(), arguments[0]


def _uvx(arguments: Sequence[str]) -> None:
    """A command of the package as it will be published: read, not run."""
    assert arguments[0] == PROJECT
    read_command(arguments[1:])


def _docker(arguments: Sequence[str]) -> None:
    """What is built has its recipe; the command that runs inside is read."""
    assert (ROOT / "Dockerfile").is_file()
    if arguments[0] == "run":
        _uvx(arguments[arguments.index(PROJECT) :])


def _script(name: str) -> Callable[[Sequence[str]], None]:
    def check(_: Sequence[str]) -> None:
        path = ROOT / name
        subprocess.run(["/bin/bash", "-n", path], check=True)
        assert path.stat().st_mode & 0o100, f"{name} cannot be executed"

    return check


_PROGRAMS: dict[str, Callable[[Sequence[str]], None]] = {
    "halfphysics": _halfphysics,
    "./run": _run_script,
    "pip": _pip,
    "python": _python,
    "uvx": _uvx,
    "docker": _docker,
    "tools/test_native.sh": _script("tools/test_native.sh"),
    "tools/sanitize.sh": _script("tools/sanitize.sh"),
    "tools/build_inplace.sh": _script("tools/build_inplace.sh"),
    ".ci/run": _script(".ci/run"),
}
