"""SMPLer-X: a folder with a file for each person in each frame of a video; SMPL-X, y down.

`smplx/00001_0.npz` (frame, person): `global_orient` (1, 3), `body_pose` (21, 3), `left_hand_pose`,
`right_hand_pose` (15, 3), `jaw_pose`, `leye_pose`, `reye_pose` (1, 3), `betas` (1, 10),
`expression`, `transl` (1, 3). People are not tracked: they are numbered by their order in each
frame. Fingers are about SMPL-X's relaxed hand; the depth is that of a made-up camera for each
crop.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from halfphysics.base.npz import Npz
from halfphysics.base.reader_warnings import warn
from halfphysics.formats.estimates import (
    CAMERA,
    FLOOR,
    Seen,
    estimated,
    files_in,
    relaxed,
    seen,
    tracked,
)
from halfphysics.formats.format import Options, Source
from halfphysics.formats.smplx_params import is_params, parts_of, stacked
from halfphysics.motion.motion import Motion

NAME = "smplerx"
_FOLDER = "smplx"
_FILE = re.compile(r"(\d{1,9})_(\d{1,4})\.npz")


def _files(source: Source) -> dict[str, list[tuple[int, Path]]]:
    """Person -> number of each frame and its file, in order."""
    inside = source.path / _FOLDER
    folder = inside if inside.is_dir() else source.path
    found: dict[str, list[tuple[int, Path]]] = {}
    for match, path in files_in(folder, _FILE):
        found.setdefault(match[2], []).append((int(match[1]), path))
    return {who: sorted(found[who]) for who in sorted(found, key=int)}


def _sniff(source: Source) -> bool:
    if not source.is_folder:
        return False
    files = _files(source)
    return bool(files) and is_params(Npz(next(iter(files.values()))[0][1]))


def _people(source: Source) -> dict[str, Seen]:
    files = _files(source)
    if len(files) > 1:
        warn(
            f"{source.path}: people are numbered by their order in each frame: nobody tracked them"
        )
    found = {}
    for who, rows in files.items():
        fields = stacked([dict(Npz(path)) for _, path in rows])
        found[who] = np.array([number for number, _ in rows]), fields
    return seen(source.path, found)


def _read(who: Seen, options: Options) -> Motion:
    parts = parts_of(who.record, options)
    hands, told = relaxed(options)
    return estimated(
        who.record.where,
        options,
        format=NAME,
        frames=who.frames,
        translation=parts.translation,
        rotations=parts.rotations,
        up="-y",
        model="smplx",
        betas=parts.betas,
        hands=hands,
        invented={**CAMERA, **told, **FLOOR},
    )


FORMAT = tracked(
    NAME,
    "a folder with smplx/00001_0.npz: global_orient (1, 3), body_pose (21, 3), transl",
    about="SMPLer-X: people of a video, a file for each frame",
    invents="frame rate, relaxed hand, floor, the world (it is the camera's frame), who is who",
    sniff=_sniff,
    people=_people,
    read=_read,
)
