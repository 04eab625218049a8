"""The fenced blocks of a document, and the commands in its sentences."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from support.paths import DOCS, ROOT

_FENCE = re.compile(r"^( *)```([^\n]*)\n(.*?)^\1```[ ]*$", re.MULTILINE | re.DOTALL)
_INLINE = re.compile(r"`(halfphysics [^`\n]+)`")
#: A word that stands for something of the reader's: FILE, CMD, OUT, "...".
_PLACEHOLDER = re.compile(r"^(?:[A-Z]{2,}\S*|\.\.\.)$")


@dataclass(frozen=True)
class Block:
    """A fenced block, its language, and the line of the document at which it begins."""

    document: str
    line: int
    language: str
    text: str

    @property
    def name(self) -> str:
        return f"{self.document}:{self.line}"


def documents() -> list[Path]:
    """The documents that readers are told to follow."""
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]


def blocks_of(path: Path) -> list[Block]:
    """All fenced blocks of a document, in their order, without their indentation."""
    text, name = path.read_text(encoding="utf-8"), path.relative_to(ROOT).as_posix()
    found = []
    for match in _FENCE.finditer(text):
        indent, language, inside = match.groups()
        line = text[: match.start()].count("\n") + 2
        lines = [line.removeprefix(indent) for line in inside.splitlines()]
        word = language.split()[0] if language.split() else ""
        found.append(Block(name, line, word, "\n".join(lines) + "\n"))
    return found


def commands_in_sentences(path: Path) -> list[str]:
    """`halfphysics ...` in backquotes, outside of blocks, without placeholders."""
    text = _FENCE.sub("", path.read_text(encoding="utf-8"))
    found = [" ".join(command.split()) for command in _INLINE.findall(text)]
    return [c for c in found if not any(_PLACEHOLDER.match(word) for word in c.split())]
