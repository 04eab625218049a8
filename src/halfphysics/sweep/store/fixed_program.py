"""Which program a sweep is made with: fixed at the first start, so that no data is lost to another.

Numbers depend on the program. What another version has made would have to be made again, all of
it, which may be weeks of work: that is for the user to say.
"""

from __future__ import annotations

from typing import Any

from halfphysics.errors import InputError
from halfphysics.sweep.store import documents
from halfphysics.sweep.store.layout import Layout
from halfphysics.sweep.store.provenance import changed, versions

#: In the folder of a sweep.
NAME = "program.json"


def check_program(layout: Layout, program: str, identity: str, *, remake: bool) -> None:
    """Write down which program it is, or compare it with what is there.

    Args:
        layout: The folder.
        program: This program's hash.
        identity: Of the plan with it, as records have it.
        remake: Whether what another program has made is to be made again.

    Raises:
        InputError: Another program has made what is there, and `remake` is not said.
        FileError: It cannot be read or written.
    """
    path = layout.folder / NAME
    here = {**versions(), "program": program}
    there = documents.read(path)
    if there == here:
        return
    if not remake and _made_by_another(layout, identity):
        raise InputError(
            f"{layout.folder}: what is done was made by another program: "
            f"{_words(there, program)}. Use that one, give another folder (--out), or have "
            "everything made again (--remake)"
        )
    documents.write(path, here)


def check_same(layout: Layout, program: str) -> None:
    """Whether a worker runs the program that the sweep was begun with.

    Raises:
        InputError: It does not.
    """
    there = documents.read(layout.folder / NAME)
    if there is not None and there.get("program") != program:
        raise InputError(
            f"{layout.folder}: a worker has another program than the sweep was started with: "
            f"{_words(there, program)}. Expected the same versions everywhere"
        )


def _words(there: dict[str, Any] | None, program: str) -> str:
    if there is None:
        return f"which one is not known, {NAME} is missing"
    return "; ".join(changed(there, program))


def _made_by_another(layout: Layout, identity: str) -> bool:
    """Whether the first thing found that is done is of another program."""
    for folder, pattern in ((layout.shard_folder, "*/*.json"), (layout.work, "0*/*.json")):
        first = next(folder.glob(pattern), None)
        if first is not None:
            record = documents.read(first)
            return record is not None and record.get("of") != identity
    return False
