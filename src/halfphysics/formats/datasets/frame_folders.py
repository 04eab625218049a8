"""Data sets with a folder for each frame and a pickle for each person in it (PROX, RICH).

Folders are named by the number of the frame ("00017") or contain it ("s001_frame_00017__00.00.01").
A pickle is a dict of the parameters of the `smplx` package, one row each: `global_orient (1, 3)`.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.stored_objects import read
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.median_shape import median_shape
from halfphysics.formats.datasets.relaxed_fingers import HANDS, relaxed_fingers
from halfphysics.formats.format import Options
from halfphysics.formats.motion_builder import rotations_of
from halfphysics.formats.people import Track, filled
from halfphysics.motion.smplx_names import PARTS

Array = NDArray[np.float64]

ENDING = ".pkl"
_NUMBER = re.compile(r"^(\d{1,9})$|frame_(\d{1,9})")
_FIRST = 64
_NEEDED = ("global_orient", "body_pose")


class Person(NamedTuple):
    """A person of a folder of frames, from their first frame to their last, without gaps.

    Attributes:
        translation: (T, 3) [m], file axes.
        rotations: Axis-angle (T, 55, 3), file axes.
        betas: (n,), the median over the frames; None: there are none.
        hands: What zero fingers mean, for `motion_of`.
    """

    translation: Array
    rotations: Array
    betas: Array | None
    hands: Literal["flat", "mean"]


def frames_in(folder: Path, most: int | None = None) -> list[tuple[int, Path]]:
    """Numbers and folders of the frames in a folder, in order; of at most `most` of them."""
    found = []
    with os.scandir(folder) as entries:
        for entry in entries:
            match = _NUMBER.search(entry.name)
            if match is not None and entry.is_dir():
                found.append((int(match[1] or match[2]), Path(entry.path)))
                if most is not None and len(found) == most:
                    break
    return sorted(found)


def a_frame(folder: Path) -> dict[str, object] | None:
    """The content of a pickle of any frame in a folder; None: it is no folder of frames."""
    for _, frame in frames_in(folder, _FIRST):
        for path in sorted(frame.glob(f"*{ENDING}")):
            data = read(path)
            named = {"global_orient", "body_pose"}
            return data if isinstance(data, dict) and named <= data.keys() else None
    return None


def people_in(folder: Path) -> list[Track]:
    """The people of a folder of frames: names of the pickles, first frame and the one after the
    last."""
    seen: dict[str, list[int]] = {}
    for number, frame in frames_in(folder):
        for entry in sorted(os.listdir(frame)):
            if entry.endswith(ENDING):
                seen.setdefault(entry.removesuffix(ENDING), []).append(number)
    return [Track(name, numbers[0], numbers[-1] + 1) for name, numbers in sorted(seen.items())]


def person_in(where: str, folder: Path, track: Track, options: Options, gender: str) -> Person:
    """One person; frames in which they are not seen are between those before and after.

    Args:
        where: Name in messages.
        folder: The folder of the frames.
        track: One of `people_in`.
        options: The caller's, of which `frames` is applied.
        gender: Selects a model file for the fingers, where `model` is a folder.

    Raises:
        FileError: A file cannot be read, or lacks what the first frame has.
    """
    numbers, record = _rows(where, folder, track)
    parts = {
        joints: record.array(key, None, 3 * len(joints))
        for key, joints in PARTS.items()
        if key not in HANDS and (key in record or key in _NEEDED)
    }
    hands = {k: record.array(k, None, record.raw(k).shape[1]) for k in HANDS if k in record}
    fingers, meaning = relaxed_fingers(record, options, gender, hands)
    translation, rotations = filled(
        record.where,
        numbers,
        record.array("transl", None, 3),
        rotations_of({**parts, **fingers}),
    )
    return Person(
        translation[options.frames],
        rotations[options.frames],
        median_shape(record, len(numbers)),
        meaning,
    )


def _rows(where: str, folder: Path, track: Track) -> tuple[Array, Record]:
    """Numbers (n,) of a person's frames, and the parameters with one row for each."""
    numbers, rows = [], []
    for number, frame in frames_in(folder):
        path = frame / f"{track.name}{ENDING}"
        if path.is_file():
            rows.append(_parameters(path))
            numbers.append(number)
    columns = {}
    for key, value in rows[0].fields.items():
        parts = []
        for record in rows:
            part = record.flat(key)
            if part.size != value.size:
                raise record.error(
                    key, f"found {part.size} numbers, expected {value.size} as in the first frame"
                )
            parts.append(part)
        columns[key] = np.stack(parts)
    return np.asarray(numbers, dtype=np.float64), Record(where, columns)


def _parameters(path: Path) -> Record:
    """The arrays of a pickle."""
    data = read(path)
    if not isinstance(data, dict):
        raise FileError(f"{path}: found a {type(data).__name__}, expected a dict of arrays")
    kept = {}
    for key, value in data.items():
        array = np.asarray(value) if not isinstance(value, dict | list | str) else np.zeros(0)
        if array.dtype.kind in "fiu" and array.size:
            kept[str(key)] = array
    return Record(path, kept)
