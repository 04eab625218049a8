"""What people save of SAM 3D Body: who is seen in which frame.

`process_one_image` gives a list of dicts, one for each person (sam_3d_body_estimator.py), and no
file. Saved with numpy, pickle, joblib, torch or as JSON, these are found:

- the dict of one person, or the list of an image;
- frames of a video: a list of such lists (empty: nobody), of dicts with such a list in them
  (`{"frame": "frame_000012.jpg", "outputs": [...]}`), or a dict of names of frames to any of these;
- one person's arrays over the frames: the same fields with one axis more in front;
- a folder with a file for each frame, or for each person in it (`img_subj00.npz`).

Numbers of frames are those at the end of names, where all have one; else their order. Boxes of
people in
one image overlap little (the detector removes those that overlap by more than 0.3), so a list of
dicts whose boxes overlap more from each to the next is one person in the frames of a video.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.arrays import as_array
from halfphysics.base.npz import Npz
from halfphysics.base.npz_objects import NpzObjects
from halfphysics.errors import FileError
from halfphysics.formats.estimates import files_in
from halfphysics.formats.format import Source

JOINTS, POINTS, CAMERA = "pred_joint_coords", "pred_keypoints_3d", "pred_cam_t"
#: What else such a dict has.
OTHERS = {"mhr_model_params", "body_pose_params", "pred_pose_raw", "pred_global_rots"}
_IDS = ("person_id", "track_id", "tid", "id")
_NUMBERS = ("frame_idx", "frame_id", "frame_number", "frame")
_LISTS = ("outputs", "people", "persons", "predictions", "results")
_BOX, _OVERLAP = "bbox", 0.3
#: Lists within lists that are looked into.
_DEPTH = 5
_DIGITS = re.compile(r"(\d{1,9})\D*$")
_FILE = re.compile(
    r"(?P<stem>.*?)(?:[_-](?:subj|subject|person|pid|p)_?(?P<who>\d{1,4}))?"
    r"\.(?:npz|npy|pkl|pickle|joblib|pt|pth|json)"
)


class Sighting(NamedTuple):
    """A person in a frame: the fields that are used, and the number that a tracker gave, if any."""

    number: int
    fields: Mapping[str, Any]
    who: str | None


def is_person(content: Any) -> bool:
    """Whether these are the fields of a person."""
    if not isinstance(content, Mapping):
        return False
    keys = {key for key in content if isinstance(key, str)}
    places = len(keys & {JOINTS, POINTS})
    return places + len(keys & (OTHERS | {CAMERA})) >= 2 and (places > 0 or bool(keys & OTHERS))


def is_output(content: Any, depth: int = _DEPTH) -> bool:
    """Whether these are the fields of a person, or something that begins with such fields."""
    if is_person(content):
        return True
    if depth == 0:
        return False
    return any(is_output(item, depth - 1) for item in _inner(content)[:4])


def content_of(source: Source) -> Any:
    """What is in a file; None: nothing of this kind."""
    if source.npz is not None:
        if all(not source.npz.header(key)[1].hasobject for key in source.npz):
            return source.npz
        objects = NpzObjects(source.path)
        plain = is_person(dict.fromkeys(objects))
        return objects if plain else {key: objects[key] for key in objects}
    found = source.document if source.document is not None else source.data
    return found


def files_of(folder: Path) -> list[tuple[int, str | None, Path]]:
    """The files of a folder: number of the frame, person or None, path; in order."""
    found = files_in(folder, _FILE)
    stems = list(dict.fromkeys(match["stem"] for match, _ in found))
    numbers = dict(zip(stems, _numbers(stems), strict=True))
    rows = [(numbers[match["stem"]], match["who"], path) for match, path in found]
    return sorted(rows, key=lambda row: (row[0], row[1] or "", row[2].name))


def sightings(source: Source) -> tuple[list[Sighting], float | None]:
    """All people in all frames, in order, and the frame rate if the file says one.

    Raises:
        FileError: Something else is between them.
    """
    if not source.is_folder:
        content = content_of(source)
        return list(_in_frames(str(source.path), content)), _rate(content)
    found = []
    for number, who, path in files_of(source.path):
        inside = list(_in_frames(str(path), content_of(Source(path))))
        if len({each.number for each in inside}) > 1:
            raise FileError(f"{path}: several frames in a file of a folder, expected one frame")
        found += [each._replace(number=number, who=each.who or who) for each in inside]
    return found, None


def _in_frames(where: str, content: Any) -> Iterator[Sighting]:
    """Everybody in a file."""
    while isinstance(content, Mapping) and not is_person(content) and len(_frames_in(content)) == 1:
        content = _frames_in(content)[0]
    if is_person(content):
        yield from _one(where, content)
        return
    items = _items(content)
    if items and all(is_person(item) for _, item in items) and not isinstance(content, Mapping):
        people = [item for _, item in items]
        follow = _numbered(people) or (len(people) > 1 and _one_person(people))
        for row, fields in enumerate(people):
            yield Sighting(_number_of(fields, row) if follow else 0, fields, _id(fields))
        return
    numbers = _numbers([name for name, _ in items])
    for (name, item), number in zip(items, numbers, strict=True):
        for fields in _people_of(f"{where}: frame {name!r}", item):
            yield Sighting(number, fields, _id(fields))


def _array(value: Any) -> NDArray[Any]:
    """An array of anything; lists of different lengths are an array of no numbers."""
    try:
        return as_array(value)
    except (MemoryError, OverflowError, TypeError, ValueError):
        return np.empty(0, dtype=object)


def _one(where: str, fields: Mapping[str, Any]) -> Iterator[Sighting]:
    """A person in one frame or, with one axis more, in many."""
    key = JOINTS if JOINTS in fields else POINTS
    shape: tuple[int, ...] = _array(fields[key]).shape if key in fields else ()
    if len(shape) != 3:
        yield Sighting(0, fields, _id(fields))
        return
    arrays = {k: _array(fields[k]) for k in (JOINTS, POINTS, CAMERA) if k in fields}
    name = next((n for n in _NUMBERS if n in fields), None)
    numbers = np.arange(shape[0]) if name is None else _array(fields[name]).reshape(-1)
    lengths = {k: len(v) if v.ndim else 1 for k, v in arrays.items()}
    lengths[name or "frames"] = len(numbers)
    fits = numbers.dtype.kind in "iuf" and np.isfinite(numbers).all()
    if len(set(lengths.values())) > 1 or not fits:
        raise FileError(
            f"{where}: fields of different length: {lengths}, expected one row per frame, and "
            "whole numbers of frames"
        )
    for row, number in enumerate(numbers):
        yield Sighting(int(number), {k: v[row] for k, v in arrays.items()}, "0")


def _people_of(where: str, item: Any) -> list[Mapping[str, Any]]:
    """The people of a frame."""
    if item is None:
        return []
    if is_person(item):
        return [item]
    if isinstance(item, Mapping):
        inside: Any = next((item[key] for key in _LISTS if key in item), None)
        return _people_of(where, inside)
    if isinstance(item, list | tuple | np.ndarray):
        people = [each for each in item if each is not None]
        if all(is_person(each) for each in people):
            return people
    raise FileError(
        f"{where}: found no people of SAM 3D Body, expected a list of dicts with {JOINTS} or "
        f"{POINTS}"
    )


def _frames_in(content: Mapping[Any, Any]) -> list[Any]:
    """What of a dict holds the frames: its lists of frames or people, or its only entry."""
    keys = [key for key in ("frames", *_LISTS) if key in content]
    if keys:
        return [content[keys[0]]]
    only = list(content.values()) if len(content) == 1 else []
    # The only name of a frame is no wrapper: its people are one image's all the same.
    return [each for each in only if not is_person(each)]


def _inner(content: Any) -> list[Any]:
    return [item for _, item in _items(content)]


def _items(content: Any) -> list[tuple[Any, Any]]:
    """Names and items of a list, of an array of objects, or of a dict."""
    if isinstance(content, dict):
        return list(content.items())
    if isinstance(content, np.ndarray) and content.dtype.hasobject:
        content = content.reshape(-1).tolist()
    if not isinstance(content, list | tuple):
        return []
    return [(_name(item, row), item) for row, item in enumerate(content)]


def _name(item: Any, row: int) -> Any:
    named = isinstance(item, Mapping) and not isinstance(item, Npz)
    return next((item[n] for n in _NUMBERS if n in item), row) if named else row


def _numbers(names: list[Any]) -> list[int]:
    """The numbers of frames: at the end of all names, else their order."""
    found = [_DIGITS.search(Path(str(name)).stem) for name in names]
    numbers = [int(match[1]) for match in found if match]
    return numbers if len(numbers) == len(names) else list(range(len(names)))


def _numbered(people: list[Mapping[str, Any]]) -> bool:
    return all(any(n in fields for n in _NUMBERS) for fields in people)


def _number_of(fields: Mapping[str, Any], row: int) -> int:
    name = next((n for n in _NUMBERS if n in fields), None)
    return row if name is None else _numbers([fields[name]])[0]


def _one_person(people: list[Mapping[str, Any]]) -> bool:
    """Whether each box overlaps the next one's by more than boxes of an image do."""
    try:
        boxes = [np.array(fields[_BOX], dtype=np.float64).reshape(4) for fields in people]
    except (KeyError, OverflowError, TypeError, ValueError):
        return False
    return all(_overlap(a, b) > _OVERLAP for a, b in pairwise(boxes))


def _overlap(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Intersection over union of boxes (x0, y0, x1, y1)."""
    both = np.prod(np.maximum(0.0, np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2])))
    areas = np.prod(a[2:] - a[:2]) + np.prod(b[2:] - b[:2])
    return float(both / max(areas - both, 1e-12))


def _id(fields: Mapping[str, Any]) -> str | None:
    found = next((_array(fields[key]) for key in _IDS if key in fields), None)
    return None if found is None or found.size != 1 else str(found.reshape(-1)[0])


def _rate(content: Any) -> float | None:
    """Frames per second, as `fps` beside the frames or in `video_info`."""
    if not isinstance(content, Mapping):
        return None
    info = content.get("video_info", content)
    rate = info.get("fps") if isinstance(info, Mapping) else None
    found = _array(rate)
    return float(found.reshape(-1)[0]) if found.size == 1 and found.dtype.kind in "iuf" else None
