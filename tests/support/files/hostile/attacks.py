"""What hostile files are known by: `attack` and `harmless` put their makers into tables."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

Builder = Callable[[Path], Path]

#: What opens the file -> name of the attack -> what makes it.
ATTACKS: dict[str, dict[str, Builder]] = {
    "motion": {}, "scene": {}, "articulated": {}, "mesh": {}, "body": {},
}  # fmt: skip
#: Files that are read as if nothing were beside them: name -> what makes it.
HARMLESS: dict[str, Builder] = {}


def attack(opened_by: str) -> Callable[[Builder], Builder]:
    def add(build: Builder) -> Builder:
        ATTACKS[opened_by][build.__name__] = build
        return build

    return add


def harmless(build: Builder) -> Builder:
    HARMLESS[build.__name__] = build
    return build


def written(path: Path, content: bytes | str) -> Path:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path
