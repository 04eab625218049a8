"""halfphysics formats: which motion files are read and written."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

from halfphysics.cli.options import MotionOptions
from halfphysics.cli.wording import Voice, options_of, words_of

if TYPE_CHECKING:
    from halfphysics.formats.format import Format

EXAMPLES = """\
halfphysics formats
halfphysics formats --json"""

# Width of the text under a format's name [characters].
_WIDTH = 96


@dataclass(frozen=True)
class Row:
    """One format as users see it."""

    name: str
    about: str
    content: str
    reads: tuple[str, ...]
    writes: bool
    invents: str


@dataclass(frozen=True, kw_only=True)
class Command:
    """Print the motion formats: what each is, how it is told, what is read, what is invented.

    Formats are found by content, not by name. docs/formats.md has their axes, rates and options.
    """

    json: bool = False
    """As JSON, a list of objects."""

    def run(self) -> None:
        """Print the formats."""
        rows = [row(format) for format in known()]
        if self.json:
            print(json.dumps([asdict(one) for one in rows], indent=1))
            return
        for one in rows:
            print("\n".join(lines(one)))


def known() -> list[Format]:
    """Every format, by name."""
    from halfphysics.formats.registry import FORMATS

    return [FORMATS[name] for name in sorted(FORMATS)]


def row(format: Format) -> Row:
    """A format as users see it."""
    reads = ["the motion"] if format.sniff is not None else []
    if format.people is not None:
        reads.append("several people")
    if format.clips is not None:
        reads.append("several clips")
    if format.load_sequence is not None:
        reads.append("objects, scene, bodies")
    return Row(
        format.name,
        format.about,
        format.expects,
        tuple(reads),
        format.save is not None,
        words_of(format.invents, Voice(options_of(MotionOptions))),
    )


def lines(one: Row) -> list[str]:
    """A format in a few lines."""
    import textwrap

    verbs = [f"reads {', '.join(one.reads)}"] if one.reads else []
    verbs += ["writes"] if one.writes else []
    told = [f"{one.name}: {one.about}" if one.about else one.name]
    for text in (one.content, "; ".join(verbs), one.invents and f"not in the file: {one.invents}"):
        if text:
            told += textwrap.wrap(text, _WIDTH, initial_indent="  ", subsequent_indent="    ")
    return told
