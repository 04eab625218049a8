"""The list of inputs of a sweep: fixed at the first start, so that variants keep their numbers."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path

from halfphysics.base import json_files
from halfphysics.base.json_files import reported
from halfphysics.errors import InputError

_SHOWN = 3


def check_inputs(path: Path, lines: Sequence[str]) -> None:
    """Write the list of inputs, or compare it with the list already in the folder.

    Args:
        path: The file with the list.
        lines: The plan's current inputs, sorted.

    Raises:
        InputError: Inputs were added or removed since the sweep began.
        FileError: The file cannot be read or written.
    """
    if not path.exists():
        with json_files.replacing(path) as handle:
            for line in lines:
                handle.write(f"{line}\n".encode())
        return
    with reported(path), path.open(encoding="utf-8") as handle:
        there = (line.rstrip("\n") for line in handle)
        if all(old == new for old, new in zip_longest(there, lines)):
            return
    raise InputError(_words(path, lines))


def _words(path: Path, lines: Sequence[str]) -> str:
    before = set(path.read_text(encoding="utf-8").rstrip("\n").split("\n"))
    now = set(lines)
    parts = []
    for word, names in (("new", now - before), ("gone", before - now)):
        if names:
            shown = ", ".join(name.replace("\t", " ") for name in sorted(names)[:_SHOWN])
            parts.append(f"{len(names)} {word} ({shown}{', ...' * (len(names) > _SHOWN)})")
    return (
        f"{path.parent}: the inputs are not those that this sweep began with: "
        f"{'; '.join(parts) or 'in another order'}. Numbers of variants depend on them: put them "
        "back as they were, or give another folder (--out)"
    )
