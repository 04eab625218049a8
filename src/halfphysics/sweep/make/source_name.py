"""The name of a source file in records and cards: its path from the folder of the plan."""

from __future__ import annotations

import os
from pathlib import Path


def source_name(path: str | os.PathLike[str], base: str | os.PathLike[str]) -> str:
    """The path of a file from a folder, with /; absolute if the file is elsewhere.

    The name is the same for every path of the folder. A link to a folder below `base` stays in it,
    a link to the file too. What `..` stands for after a link only the file system knows: such a
    path is cut short only where that leads to the same folder.

    Args:
        path: The file, absolute or relative to `base`.
        base: The folder, absolute or relative to the working directory.
    """
    root, real = os.path.join(os.path.abspath(""), base, ""), os.path.realpath(base)
    whole = os.path.join(root, path)
    if whole.startswith(root):
        whole = os.path.join(real, whole[len(root) :])
    folder, file = os.path.split(whole)
    physical = os.path.join(os.path.realpath(folder), file)
    straight = os.path.normpath(whole)
    if os.path.realpath(os.path.dirname(straight)) != os.path.dirname(physical):
        straight = physical
    for one in (straight, physical):
        if Path(one).is_relative_to(real):
            return Path(one).relative_to(real).as_posix()
    return Path(physical).as_posix()
