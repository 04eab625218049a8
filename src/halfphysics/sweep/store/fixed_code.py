"""The code that makes a sweep: fixed at the first start, so that no finished data is discarded.

The data depends on the code. All data of another version would have to be made again, which may
take weeks: the user decides that.
"""

from __future__ import annotations

from typing import Any

from halfphysics.base import json_files
from halfphysics.errors import InputError
from halfphysics.sweep.make.provenance import changed, versions
from halfphysics.sweep.plan.layout import Layout

#: The file in the folder of a sweep.
NAME = "program.json"
#: Its entry with the identity of plan and code: a record of a shard with another is of other code.
OF = "of"


def check_code(layout: Layout, code: str, identity: str, *, remake: bool) -> None:
    """Record the hash of the code, or compare it with the recorded one.

    Args:
        layout: The folder.
        code: Hash of this code.
        identity: Identity of the plan with that code, as in records.
        remake: Make data of other code again.

    Raises:
        InputError: Other code has made the data in the folder, and `remake` is not set.
        FileError: The recorded hash cannot be read or written.
    """
    path = layout.folder / NAME
    here = {**versions(), "program": code, OF: identity}
    there = json_files.read(path)
    if there == here:
        return
    if not remake and _made_by_another(layout, identity):
        raise InputError(
            f"{layout.folder}: what is done was made by another program: "
            f"{_words(there, code)}. Use that one, give another folder (--out), or have "
            "everything made again (--remake)"
        )
    json_files.write(path, here)


def check_same(layout: Layout, code: str) -> None:
    """Check that a worker runs the code that started the sweep.

    Raises:
        InputError: The worker runs other code.
    """
    there = json_files.read(layout.folder / NAME)
    if there is not None and there.get("program") != code:
        raise InputError(
            f"{layout.folder}: a worker has another program than the sweep was started with: "
            f"{_words(there, code)}. Expected the same versions everywhere"
        )


def _words(there: dict[str, Any] | None, code: str) -> str:
    if there is None:
        return f"which one is not known, {NAME} is missing"
    return "; ".join(changed({k: v for k, v in there.items() if k != OF}, code))


def _made_by_another(layout: Layout, identity: str) -> bool:
    """Whether other code made the first finished batch or shard found."""
    for folder, pattern in ((layout.shard_folder, "*/*.json"), (layout.work, "0*/*.json")):
        first = next(folder.glob(pattern), None)
        if first is not None:
            record = json_files.read(first)
            return record is not None and record.get("of") != identity
    return False
