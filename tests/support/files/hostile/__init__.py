"""Files that a stranger made to hang, fill or kill the process that reads them; small on disk.

`ATTACKS`: name -> function (folder) -> path of the file, by what opens it. Each must end in one
error of ours within 5 s and 1 GB (`tests/formats/test_hostile.py`).
"""

from support.files.hostile import (
    arrays,
    articulated,
    beside,
    meshes,
    packed,
    pickles,
    scene_files,
    torch_files,
)
from support.files.hostile.attacks import ATTACKS, HARMLESS

__all__ = [
    "ATTACKS",
    "HARMLESS",
    "arrays",
    "articulated",
    "beside",
    "meshes",
    "packed",
    "pickles",
    "scene_files",
    "torch_files",
]
