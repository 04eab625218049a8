"""The motions in a result file, for readers of motions: of everybody, in the world of the result.

The keys on top of a result are for programs that read AMASS: the first person, in the axes, the
unit and the hands of the file that the motion came from, which these keys do not say. The fields
under `meta/` say it, and have the other people.
"""

from __future__ import annotations

import json
from collections.abc import Sequence as Listing
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.axes import AXES, axes_of
from halfphysics.base.npz import Npz
from halfphysics.errors import FileError, InputError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.people import Track
from halfphysics.formats.results.keys import VERSION_KEY, person_prefix
from halfphysics.motion import skeleton
from halfphysics.motion.motion import MODELS, Motion

Array = NDArray[np.float64]
_Document = dict[str, Any]

#: Rounding of turning a motion to the axes and the unit of its file and back [m, rad].
SAME = 1e-9
#: Metres per unit of translations that files have.
_UNITS = (0.01, 0.001)
_BODY = list(skeleton.BODY_JOINTS)


def first_person(npz: Npz) -> str | None:
    """The name of the first person of a result of several people; None: of any other file."""
    people = _people(npz)
    return people[0]["name"] if len(people) > 1 else None


def of_result(source: Source, format: Format) -> Format:
    """The format that reads the motions of a file: of a result with its people, else `format`."""
    people = _people(source.npz)
    if not people:
        return format

    def tracks(source: Source) -> list[Track]:
        frames = 0 if source.npz is None else source.npz.header("trans")[0][0]
        return [Track(person["name"], 0, frames) for person in people]

    return replace(
        format,
        load=lambda source, options: _load(source, options, format, people),
        people=tracks if len(people) > 1 else None,
    )


def _people(npz: Npz | None) -> list[_Document]:
    """What a result says of its people; none if it is damaged, which `Result.load` tells, or no
    result."""
    if npz is None or not {VERSION_KEY, "meta/people", "trans"} <= set(npz):
        return []
    try:
        people = json.loads(str(npz["meta/people"].reshape(-1)[0]))
    except (FileError, IndexError, ValueError, RecursionError):
        return []
    known = isinstance(people, list) and all(
        isinstance(person, dict) and isinstance(person.get("name"), str) for person in people
    )
    return people if known else []


def _load(source: Source, options: Options, format: Format, people: Listing[_Document]) -> Motion:
    """The motion of the person whom `clip` names, else of the first."""
    names = [person["name"] for person in people]
    index = names.index(options.clip) if options.clip in names else 0
    record = Record(source.path, {} if source.npz is None else source.npz)
    if index:
        return _other(record, options, people[index], person_prefix(index))
    where, rotations = f"{person_prefix(0)}translation", f"{person_prefix(0)}rotations"
    if where not in record or rotations not in record:
        return format.load(source, options)
    places = record.array(where, None, 3, frames=options.frames)
    turns = record.array(rotations, None, skeleton.N_JOINTS, 3, frames=options.frames)
    on_top = format.load(source, _as_written(record, options, people[0], places, turns))
    if options.hands is not None or not _is_same(on_top, places, turns):
        return on_top
    return on_top.with_frames(on_top.translation, turns)  # fingers may be about a mean hand on top


def _is_same(motion: Motion, places: Array, turns: Array) -> bool:
    """Whether what is on top is the motion of the result, but for its fingers; other axes shift
    it."""
    if len(motion) != len(places):
        return False
    shift = motion.translation - places
    near = np.abs(shift - shift[0]).max() < SAME
    same = np.abs(motion.rotations[:, [0, *_BODY]] - turns[:, [0, *_BODY]]).max() < SAME
    return bool(near and same)


def _as_written(
    record: Record, options: Options, person: _Document, places: Array, turns: Array
) -> Options:
    """The options with the axis and the unit that the keys on top are in."""
    trans = record.array("trans", None, 3, frames=options.frames)
    size = float(np.linalg.norm(places))
    if trans.shape != places.shape or size == 0.0:
        return options
    factor = float(np.linalg.norm(trans)) / size
    unit = next((unit for unit in _UNITS if abs(unit * factor - 1.0) < SAME), options.unit)
    return replace(options, unit=unit, up=options.up or _up(record, options, person, turns))


def _up(record: Record, options: Options, person: _Document, turns: Array) -> str | None:
    """The axis that is up on top; None: that of the format, as of a motion of another format."""
    axes = np.asarray(person.get("axes"))
    up = next((up for up in AXES if np.array_equal(axes_of(up), axes)), "z")
    key = "poses" if "poses" in record else "root_orient"
    if up == "z" or key not in record:
        return None
    rows = np.asarray(record.raw(key))[options.frames]
    root = rows.reshape(len(rows), -1)[:, :3]
    is_turned = root.shape == turns[:, 0].shape and np.abs(root - turns[:, 0]).max() > SAME
    return up if is_turned else None


def _other(record: Record, options: Options, person: _Document, prefix: str) -> Motion:
    """The motion of another person than the first, which is written as it is in the world."""
    said = str(options.model) if str(options.model) in MODELS else None
    try:
        return Motion(
            record.array(f"{prefix}translation", None, 3, frames=options.frames),
            record.array(f"{prefix}rotations", None, skeleton.N_JOINTS, 3, frames=options.frames),
            options.fps or record.number("meta/fps", above=0.0),
            betas=person.get("betas"),
            gender=options.gender or person.get("gender", "neutral"),
            model=said or person.get("model", "smplx"),
            axes=np.asarray(person.get("axes"), dtype=np.float64),
        )
    except InputError as error:
        raise FileError(f"{record.where}, clip {person['name']!r}: {error}") from None
