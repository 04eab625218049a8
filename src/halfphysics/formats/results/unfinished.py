"""Results that are still being written: a file to which blocks are appended.

A block is complete or it is not there: whatever kills the writer, all blocks before are read.

    file    = MAGIC block*
    block   = kind (4 bytes), length of the payload and its CRC-32 (two u32, little-endian), payload
    "head"  JSON: fps, settings, people (name, gender, model, axes, betas, body)
    "scen"  JSON: a scene document, at the start and after every change of it
    "fram"  .npz: some frames; see `FrameBlock`
"""

from __future__ import annotations

import json
import os
import struct
import zlib
from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.npz import Npz
from halfphysics.base.npz_bytes import npz_bytes
from halfphysics.baselines.options import OPTIONS, from_options
from halfphysics.errors import FileError, InputError
from halfphysics.formats.results.keys import BREACHES, CONTACT, INSIDE
from halfphysics.motion.motion import Motion
from halfphysics.results.contacts import Contacts
from halfphysics.results.inside import Breaches, Inside
from halfphysics.results.records import BodyRecord, SceneRecord, checked_document
from halfphysics.results.result import DIAGNOSTICS, ObjectTrack, PersonResult, Result
from halfphysics.results.soft_contacts import SoftContacts
from halfphysics.results.table import Table
from halfphysics.simulation.recording import kept_of

MAGIC = b"halfphysics unfinished result 1\n"
HEAD, SCENE, FRAMES = b"head", b"scen", b"fram"
_BLOCK = struct.Struct("<4sII")
#: Largest block that is read [bytes]: a second of a hundred people.
_LARGEST = 256 * 2**20

Fields = dict[str, NDArray[Any]]
T = TypeVar("T", bound=Table)


def is_unfinished(path: str | os.PathLike[str]) -> bool:
    """Whether a file is one that was not finished, by content."""
    try:
        if not Path(path).is_file():
            return False
        with Path(path).open("rb") as handle:
            return handle.read(len(MAGIC)) == MAGIC
    except OSError:
        return False


def write_document(file: BinaryIO, kind: bytes, document: Mapping[str, Any]) -> None:
    """Append a block of JSON."""
    _write(file, kind, json.dumps(document, allow_nan=False).encode())


def write_frames(file: BinaryIO, fields: Fields) -> None:
    """Append frames: arrays with one row per frame, by the keys of `frame_keys`.

    Besides, `names` (n,): what contacts refer to; the columns of contacts as "contact/COLUMN", and
    of overlaps as "inside/COLUMN" and "breaches/COLUMN" (older files have none), whose frames are
    counted from the first of the block; and, where something is soft, those of samples under
    pressure as "pressed/COLUMN", with "pressed/count", their number in each frame.
    """
    _write(file, FRAMES, npz_bytes(fields))


def _write(file: BinaryIO, kind: bytes, payload: bytes) -> None:
    block = memoryview(_BLOCK.pack(kind, len(payload), zlib.crc32(payload)) + payload)
    while block:  # a file without a buffer may take a part only
        block = block[file.write(block) :]


def load_unfinished(path: Path) -> Result:
    """The result of all complete blocks.

    Raises:
        FileError: There are fewer than two frames, or it is damaged before its end.
    """
    blocks: dict[bytes, list[bytes]] = defaultdict(list)
    for kind, payload in _blocks(path):
        blocks[kind].append(payload)
    try:
        if not blocks[HEAD] or not blocks[SCENE] or not blocks[FRAMES]:
            raise InputError("found no frames, expected at least two. The session ended before")
        head = json.loads(blocks[HEAD][0])
        keys = ("fps", "settings", "people")
        head = checked_document(head, "head", keys)
        parts = [Npz(path, payload) for payload in blocks[FRAMES]]
        scene = _merged([json.loads(block) for block in blocks[SCENE]])
        return _result(head, SceneRecord(scene, str(path)), parts)
    except (
        AttributeError, IndexError, InputError, KeyError, RecursionError, TypeError, ValueError,
    ) as error:  # fmt: skip
        raise FileError(f"{path}: an unfinished result that cannot be read: {error}") from None


def _blocks(path: Path) -> Iterator[tuple[bytes, bytes]]:
    """Kind and payload of all complete blocks; what comes after a broken one is lost."""
    try:
        with path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise FileError(f"{path}: expected an unfinished result, found another file")
            while len(head := file.read(_BLOCK.size)) == _BLOCK.size:
                kind, length, crc = _BLOCK.unpack(head)
                if length > _LARGEST:
                    return
                payload = file.read(length)
                if len(payload) < length or zlib.crc32(payload) != crc:
                    return
                yield kind, payload
    except OSError as error:
        raise FileError(f"{path}: cannot read: {error.strerror}") from None


def _merged(documents: list[dict[str, Any]]) -> dict[str, Any]:
    """One scene with every item that any of the scenes had."""
    merged = checked_document(documents[0], "scene", ("version",))
    for other in documents[1:]:
        for key, value in checked_document(other, "scene", ("version",)).items():
            if isinstance(value, dict) and isinstance(merged.get(key), dict):
                merged[key] = {**merged[key], **value}
            else:
                merged[key] = value
    return merged


def _result(head: dict[str, Any], scene: SceneRecord, parts: list[Npz]) -> Result:
    people = [str(person["name"]) for person in head["people"]]
    names = _names(parts, people, scene.document)
    whole = {key: np.concatenate([part[key] for part in parts]) for key in _common(parts)}
    counts = [len(part["clearance"]) for part in parts]
    return Result(
        people=tuple(
            _person(whole, i, data, float(head["fps"])) for i, data in enumerate(head["people"])
        ),
        objects={
            name: ObjectTrack(
                position=_filled(parts, counts, f"object/{name}/position"),
                quaternion=_filled(parts, counts, f"object/{name}/quaternion"),
            )
            for name in sorted(_after(parts, "object/", "/position"), key=names.index)
        },
        joints={
            name: _filled(parts, counts, f"joint/{name}") for name in _after(parts, "joint/", "")
        },
        scene=scene,
        names=names,
        contacts=_rows(parts, counts, names, CONTACT, Contacts),
        inside=_rows(parts, counts, names, INSIDE, Inside),
        breaches=_rows(parts, counts, names, BREACHES, Breaches),
        soft_contacts=_pressures(parts, counts, names),
        clearance=whole["clearance"],
        lost_time=whole["lost_time"],
        settings=from_options({k: v for k, v in head["settings"].items() if k in OPTIONS}),
        diagnostics={name: whole[f"diagnostics/{name}"] for name in DIAGNOSTICS},
    )


def _common(parts: list[Npz]) -> list[str]:
    """Keys of arrays with a row per frame that all blocks have."""
    apart = (CONTACT, INSIDE, BREACHES, "pressed/", "object/", "joint/", "names")
    keys = [key for key in parts[0] if not key.startswith(apart)]
    return [key for key in keys if all(key in part for part in parts)]


def _after(parts: list[Npz], prefix: str, suffix: str) -> list[str]:
    """What stands between a prefix and a suffix of the keys, in order of appearance."""
    found = dict.fromkeys(
        key[len(prefix) : len(key) - len(suffix)]
        for part in parts
        for key in part
        if key.startswith(prefix) and key.endswith(suffix)
    )
    return list(found)


def _person(whole: Fields, index: int, data: dict[str, Any], fps: float) -> PersonResult:
    keys = ("name", "gender", "model", "axes", "betas", "body")
    data = checked_document(data, f"person {index}", keys)
    common: dict[str, Any] = {key: data[key] for key in ("gender", "model", "axes", "betas")}
    at = f"person/{index}/"
    return PersonResult(
        name=str(data["name"]),
        motion=Motion(whole[f"{at}translation"], whole[f"{at}rotations"], fps, **common),
        reference=Motion(
            whole[f"{at}target_translation"], whole[f"{at}target_rotations"], fps, **common
        ),
        body=BodyRecord(data["body"], "an unfinished result"),
        torque=whole[f"{at}torque"],
        corrected=whole.get(f"{at}corrected"),
    )


def _filled(parts: list[Npz], counts: list[int], key: str) -> NDArray[Any]:
    """Rows of an item that was not always there: before it came and after it went it rests."""
    there = [key in part for part in parts]
    first = there.index(True)
    rows = parts[first][key][:1]
    pieces = []
    for part, here, count in zip(parts, there, counts, strict=True):
        pieces.append(part[key] if here else np.repeat(rows, count, axis=0))
        rows = pieces[-1][-1:]
    return np.concatenate(pieces)


def _names(parts: list[Npz], people: list[str], scene: Mapping[str, Any]) -> tuple[str, ...]:
    """All names that contacts ever referred to, in the order of a scene: statics, free objects,
    those that move, links, then people. An object that came later stands before those that move.
    """
    items = dict.fromkeys(str(name) for part in parts for name in part["names"])
    groups = (scene.get(group) or {} for group in ("statics", "objects", "moving"))
    own = [name for group in groups for name in group if name in items]
    return (*dict.fromkeys([*own, *(name for name in items if name not in people)]), *people)


def _rows(
    parts: list[Npz], counts: list[int], names: tuple[str, ...], prefix: str, of: type[T]
) -> T:
    """All rows of contacts or overlaps, with frames and names of the whole."""
    none = of.none()
    columns: dict[str, list[NDArray[Any]]] = {name: [getattr(none, name)] for name in of.columns()}
    first = 0
    for part, count in zip(parts, counts, strict=True):
        if prefix == CONTACT or f"{prefix}frame" in part:  # older files have contacts alone
            new = _renamed(part, names)
            for name, found in columns.items():
                values = part[f"{prefix}{name}"]
                if name in ("other", "subject"):
                    values = new[values]
                found.append(values + first if name == "frame" else values)
        first += count
    return of(**{name: np.concatenate(values) for name, values in columns.items()})


def _pressures(parts: list[Npz], counts: list[int], names: tuple[str, ...]) -> SoftContacts | None:
    """All samples under pressure; None: nothing was soft.

    Warns:
        HalfPhysicsWarning: There are too many to keep those of every frame.
    """
    none = [np.zeros(count, dtype=np.int64) for count in counts]
    each = [part.get("pressed/count", no) for part, no in zip(parts, none, strict=True)]
    if not any("pressed/count" in part for part in parts):
        return None
    whole = np.concatenate(each)
    if len(whole) != sum(counts) or whole.min(initial=0) < 0:
        raise InputError("found numbers of pressures that are not those of its frames")
    every = kept_of(whole)
    columns: dict[str, list[NDArray[Any]]] = {name: [] for name in SoftContacts.columns()}
    first = 0
    for part, count, rows in zip(parts, counts, each, strict=True):
        frame = np.repeat(np.arange(first, first + count), rows)
        first += count
        if "pressed/count" not in part:
            continue
        some, new = frame % every == 0, _renamed(part, names)
        columns["frame"].append(frame[some])
        for name in SoftContacts.columns():
            if name != "frame":
                values = part[f"pressed/{name}"][some]
                columns[name].append(new[values] if name in ("layer", "other") else values)
    return SoftContacts(**{name: np.concatenate(values) for name, values in columns.items()})


def _renamed(part: Npz, names: tuple[str, ...]) -> NDArray[np.int64]:
    """The index in `names` of each name of a block; one more entry for index -1: nothing."""
    index = {name: i for i, name in enumerate(names)}
    return np.array([*(index[str(name)] for name in part["names"]), -1], dtype=np.int64)
