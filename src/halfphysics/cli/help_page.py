"""The help of a command as plain text: one paragraph for each option, no frames.

tyro draws boxes, keeps the line ends of docstrings and shows defaults as Python writes them; what
it says is taken out of its boxes and laid out again for the width of the terminal.
"""

from __future__ import annotations

import re
import shutil
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, field

from halfphysics.cli.wording import spoken

#: Columns at which tyro draws one column of boxes and breaks next to no line of a docstring.
BOX_COLUMNS = 129
#: Widest and narrowest text [characters], and where the meaning of an option begins.
_WIDEST, _NARROWEST, _MARGIN = 100, 50, 24

#: Options of every command, which are read before the command's own.
EVERYWHERE = (
    ("-h, --help", "Show this help."),
    ("-q, --quiet", "Print nothing but errors."),
    ("-v, --verbose", "Log what is done on standard error; -vv: in detail."),
)


@dataclass
class Section:
    """A group of options: its name, what it is about, and its options with their meanings."""

    title: str
    about: str = ""
    entries: list[tuple[str, str]] = field(default_factory=list)


def help_page(boxes: str, examples: str) -> str:
    """The help that tyro printed at `BOX_COLUMNS`, laid out anew, with examples."""
    width = text_width()
    usage, description, sections = parsed(boxes)
    parts = [textwrap.fill(usage, width, subsequent_indent="  ")]
    parts += [textwrap.fill(_plain(text), width) for text in description]
    for section in sections:
        parts.append("\n".join(_laid_out(section, width)))
    parts.append("examples:\n" + textwrap.indent(examples.strip(), "  "))
    return "\n\n".join(parts) + "\n"


def text_width() -> int:
    """Width of text for the terminal [characters]."""
    return max(_NARROWEST, min(shutil.get_terminal_size((80, 24)).columns, _WIDEST))


def parsed(boxes: str) -> tuple[str, list[str], list[Section]]:
    """Usage, paragraphs of the description, and sections of tyro's help."""
    head, _, rest = boxes.partition("╭")
    usage, *description = [" ".join(text.split()) for text in head.strip().split("\n\n")]
    sections: list[Section] = []
    for line in f"╭{rest}".splitlines():
        if line.startswith("╭"):
            sections.append(Section(line.strip("╭╮─ ")))
        elif line.startswith("│"):
            _take(line[1:].rstrip().removesuffix("│").rstrip(), sections[-1])
    for section in sections:
        section.entries = [(name, _meaning(text)) for name, text in section.entries]
    return usage.replace(" [-h]", ""), description, sections


def _take(line: str, section: Section) -> None:
    """One line of a box: the rule under its description, a new option, or more of the last."""
    if line.strip().startswith("─"):
        section.about = " ".join(f"{name} {text}" for name, text in section.entries).strip()
        section.entries = []
    elif line.startswith("   "):
        name, text = section.entries[-1]
        section.entries[-1] = (name, f"{text} {line.strip()}".strip())
    elif line.strip():
        name, _, text = line.strip().partition("  ")
        section.entries.append((name, text.strip()))


def _meaning(text: str) -> str:
    """What an option means, with its default in plain words."""
    unset = re.search(r"\((?:default: none|repeatable)\)$", text) is not None
    text = re.sub(r" ?\((?:default: (?:none|None|False|)|required)\)$", "", text)
    if unset:
        text = re.sub(r"(^|\. )None: ", r"\1If not given: ", text).replace(
            "None: ", "if not given: "
        )
    text = re.sub(r"\(default: True\)$", "(default: yes)", text)
    text = re.sub(r"\(default: (-?\d+)\.0\)$", r"(default: \1)", text)
    return _plain(text)


def _plain(text: str) -> str:
    """Text of a docstring without its marks of code, in the words of the command line."""
    return spoken(text).replace("`", "")


def _laid_out(section: Section, width: int) -> Iterator[str]:
    title = section.title.removesuffix(" options").replace("-", " ").replace("positional ", "")
    # A dataclass says what it raises, to callers in Python.
    about = _plain(re.sub(r"\s*Raises \w+Error[^.]*\.", "", section.about))
    head = f"{title}: {about[:1].lower()}{about[1:]}" if about else f"{title}:"
    yield from textwrap.wrap(head, width)
    for name, text in section.entries:
        if name.startswith("-h,"):
            continue
        yield from _option(_invocation(name), text, width)
    if title == "options":
        for name, text in EVERYWHERE:
            yield from _option(name, text, width)


def _invocation(name: str) -> str:
    """`-o FILE, --out FILE` as `-o, --out FILE`."""
    first, comma, second = name.partition(", ")
    if comma and " " in first and first.split(" ", 1)[1] == second.split(" ", 1)[-1]:
        return f"{first.split(' ')[0]}, {second}"
    return name


def _option(name: str, text: str, width: int) -> Iterator[str]:
    indent = " " * _MARGIN
    lines = textwrap.wrap(
        text, width, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False
    )
    if len(name) + 4 <= _MARGIN and lines:
        yield f"  {name.ljust(_MARGIN - 2)}{lines.pop(0)[_MARGIN:]}"
    else:
        yield from _broken(f"  {name}", width)
    yield from lines


def _broken(name: str, width: int) -> Iterator[str]:
    """An option with its value in lines; words to choose from are broken after a bar."""
    line = ""
    for word in re.split(r"(?<=\|)", name):
        if line and len(line) + len(word) > width:
            yield line
            line = "      "
        line += word
    yield line
