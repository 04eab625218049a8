"""halfphysics scenario: play one of the built-in scenarios."""

from __future__ import annotations

import textwrap
import time
from collections.abc import Sequence as Several
from dataclasses import dataclass, field, make_dataclass
from types import SimpleNamespace
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import tyro

from halfphysics.base.suggestions import did_you_mean
from halfphysics.cli.help_page import text_width
from halfphysics.cli.options import BaselineOptions, progress
from halfphysics.cli.outputs import Outputs
from halfphysics.cli.parsing import Exit, parse
from halfphysics.cli.wording import speak_as, voice_of
from halfphysics.errors import InputError
from halfphysics.settings import Settings

if TYPE_CHECKING:
    from halfphysics.simulation.sequence import Sequence

EXAMPLES = """\
halfphysics scenario --list
halfphysics scenario kick_ball
halfphysics scenario kick_ball --mass 200 --fps 60 --out result.npz
halfphysics scenario kick_ball --fixed --stiffness 0 --drive-time none --page kick.html"""

#: Options of a scenario that cannot be written as text.
_OBJECTS = ("body", "other")


@dataclass(frozen=True)
class Play:
    """The scenario described by the arguments."""

    name: str
    sequence: Sequence
    settings: Settings
    outputs: Outputs

    def run(self) -> None:
        """Simulate, print the summary, write the requested files."""
        from halfphysics import scenarios
        from halfphysics.simulation.simulate import simulate

        print(scenarios.describe(self.name))
        story = self.sequence
        start = time.perf_counter()
        result = simulate(
            story.motion, story.scene, body=story.body, settings=self.settings, progress=progress()
        )
        seconds = time.perf_counter() - start
        print(result.summary())
        print(f"simulated {len(result)} frames in {seconds:.2f} s, preparing the body included")
        self.outputs.write(result, f"halfphysics {self.name}")


def read(prog: str, arguments: Several[str]) -> Play | Exit:
    """The scenario described by the arguments, or `Exit` after printing the list or help.

    Raises:
        InputError: The scenario is unknown, or the arguments do not fit it.
    """
    from halfphysics import scenarios

    if "--list" in arguments:
        _lone("--list", prog, arguments)
        print(overview())
        return Exit(0)
    if arguments and arguments[0] in ("-h", "--help"):
        print(_help(prog))
        return Exit(0)
    if not arguments or arguments[0].startswith("-"):
        found = repr(arguments[0]) if arguments else "nothing"
        raise InputError(
            f"scenario: found {found}, expected a name first: one of "
            f"{', '.join(scenarios.names())}. {prog} --list explains them"
        )
    name, *rest = arguments
    if name not in scenarios.names():
        hint = did_you_mean(name, scenarios.names(), otherwise=".")
        raise InputError(
            f"unknown scenario {name!r}{hint} Expected one of {', '.join(scenarios.names())}. "
            f"{prog} --list explains them"
        )
    return _play(f"{prog} {name}", name, rest)


def overview() -> str:
    """Every scenario, its description, and its options with their defaults."""
    from halfphysics import scenarios

    blocks = []
    for name in scenarios.names():
        known = scenarios.options(name).items()
        said = [_default(o, default) for o, default in known if o not in _OBJECTS]
        lines = [*textwrap.wrap(scenarios.describe(name), text_width() - 4), *_wrapped(said)]
        blocks.append("\n".join([name, *(f"  {line}" for line in lines)]))
    return "\n\n".join(blocks)


def _play(prog: str, name: str, arguments: list[str]) -> Play | Exit:
    from halfphysics import scenarios

    speak_as(lambda: voice_of(_command(name, Settings())))

    def parsed(settings: Settings) -> Any:
        return parse(_command(name, settings), prog, EXAMPLES, arguments)

    command = parsed(Settings())
    if isinstance(command, Exit):
        return command
    command.outputs.check()
    chosen = {option: getattr(command, option) for option in _texts(name)}
    sequence = scenarios.load(name, **chosen)
    if sequence.settings != Settings():
        # Options that are not given keep the scenario's settings, known only after building it.
        command = parsed(sequence.settings)
    settings = command.baseline.applied(command.settings)
    return Play(name, sequence, settings, command.outputs)


def _texts(name: str) -> dict[str, Any]:
    """The options of a scenario that a command line can give, and their defaults."""
    from halfphysics import scenarios

    return {o: default for o, default in scenarios.options(name).items() if o not in _OBJECTS}


def _command(name: str, settings: Settings) -> type[Any]:
    """The dataclass of all options of a scenario: its own, outputs, and settings."""
    from halfphysics import scenarios

    build = scenarios.builder(name)
    # Omitted options are excluded: their types are available to type checkers only.
    types = {o: kind for o, kind in build.__annotations__.items() if o in _texts(name)}
    hints = get_type_hints(SimpleNamespace(__annotations__=types), build.__globals__)
    helps = scenarios.explain(name)
    fields: list[tuple[str, Any, Any]] = []
    for option, default in _texts(name).items():
        kind: Any = hints[option]
        explained = tyro.conf.arg(help=helps.get(option, ""))
        fields.append((option, Annotated[kind, explained], field(default=default)))
    fields += [
        ("outputs", tyro.conf.OmitArgPrefixes[Outputs], field(default_factory=Outputs)),
        (
            "settings",
            tyro.conf.OmitArgPrefixes[Settings],
            field(default_factory=lambda: settings),
        ),
        (
            "baseline",
            tyro.conf.OmitArgPrefixes[BaselineOptions],
            field(default_factory=BaselineOptions),
        ),
    ]
    made = make_dataclass("Command", fields, frozen=True, kw_only=True)
    made.__doc__ = scenarios.describe(name)
    return made


def _help(prog: str) -> str:
    return "\n".join(
        [
            f"usage: {prog} NAME ...",
            "",
            *textwrap.wrap(
                "Play a built-in scenario: simulate it, print the summary, write the files named. "
                f"{prog} NAME --help explains the options of one.",
                text_width(),
            ),
            "",
            *textwrap.indent(overview(), "  ").splitlines(),
            "",
            f"{prog} --list prints this list.",
            "",
            "examples:",
            *textwrap.indent(EXAMPLES, "  ").splitlines(),
        ]
    )


def _lone(flag: str, prog: str, arguments: Several[str]) -> None:
    if len(arguments) > 1:
        others = " ".join(a for a in arguments if a != flag)
        raise InputError(f"{flag}: found {others!r} beside it, expected it alone: {prog} {flag}")


def _default(option: str, value: Any) -> str:
    """An option with its default as a command line gives it."""
    flag = option.replace("_", "-")
    if isinstance(value, bool):
        return f"--no-{flag}" if value else f"--{flag}"
    if value is None:
        return f"--{flag} none"
    if isinstance(value, float):
        return f"--{flag} {value:g}"
    return f"--{flag} {' '.join(map(str, value)) if isinstance(value, tuple) else value}"


def _wrapped(words: Several[str]) -> list[str]:
    """Words wrapped into lines; a word keeps its inner spaces."""
    lines = [""]
    for word in words:
        if lines[-1] and len(lines[-1]) + 2 + len(word) > text_width() - 4:
            lines.append("")
        lines[-1] += f"  {word}" if lines[-1] else word
    return lines
