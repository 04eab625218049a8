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

from halfphysics.base import rotations as rot
from halfphysics.base.axes import AXES, axes_of
from halfphysics.base.npz import Npz
from halfphysics.errors import FileError, InputError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.people import Track
from halfphysics.formats.results.keys import VERSION_KEY, person_prefix
from halfphysics.motion import skeleton
from halfphysics.motion.motion import MODELS, Motion
from halfphysics.motion.pose import checked_axes

Array = NDArray[np.float64]
_Document = dict[str, Any]

#: Rounding of turning a motion to the axes and the unit of its file and back [m, rad].
SAME = 1e-9
#: Metres per unit of translations that files have; a motion that was changed is as large as before
#: but for this factor.
_UNITS, _NEAR = (0.01, 0.001), 2.0
#: Pelvis of people at rest in their model's frame, and how far bodies are off it [m].
_PELVIS, _PELVIS_NEAR = np.array([0.0, -0.35, 0.0]), 0.25
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
        shape = () if source.npz is None else source.npz.header("trans")[0]
        return [Track(person["name"], 0, shape[0] if shape else 0) for person in people]

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
    asked = [name for name in ("up", "hands") if getattr(options, name) is not None]
    if asked and len(people) > 1:
        raise InputError(
            f"{asked[0]}: found {getattr(options, asked[0])!r}, but {source.path} is a result, "
            "which says it of all its people. Leave it out"
        )
    if index:
        return _other(record, options, people[index], person_prefix(index))
    where, rotations = f"{person_prefix(0)}translation", f"{person_prefix(0)}rotations"
    if asked or where not in record or rotations not in record:
        return format.load(source, options)
    places = record.array(where, None, 3, frames=options.frames)
    turns = record.array(rotations, None, skeleton.N_JOINTS, 3, frames=options.frames)
    axes = _axes(record, people[0])
    on_top = format.load(source, _as_written(record, options, axes, places, turns))
    if not _is_same(on_top, axes, places, turns):
        return on_top  # somebody has changed it since
    # Fingers may be about a mean hand on top, and places those of a body with another pelvis.
    origin = on_top.origin if np.array_equal(on_top.axes, axes) else None
    return replace(on_top, translation=places, rotations=turns, axes=axes, origin=origin)


def _is_same(motion: Motion, axes: Array, places: Array, turns: Array) -> bool:
    """Whether what is on top is the motion of the result, but for its fingers."""
    if len(motion) != len(places):
        return False
    shift = motion.translation - places
    same = np.abs(motion.rotations[:, [0, *_BODY]] - turns[:, [0, *_BODY]]).max() < SAME
    near = np.abs(shift - shift[0]).max() < SAME and _is_of_axes(shift[0], axes - motion.axes)
    return bool(same and near)


def _is_of_axes(shift: Array, between: Array) -> bool:
    """Whether a shift (3,) [m] is what other axes make of the pelvis at rest (`Motion.rebased`)."""
    pelvis = np.linalg.pinv(between) @ shift
    rest = np.abs(between @ pelvis - shift).max() < SAME
    return bool(rest and (not between.any() or np.abs(pelvis - _PELVIS).max() < _PELVIS_NEAR))


def _as_written(
    record: Record, options: Options, axes: Array, places: Array, turns: Array
) -> Options:
    """The options with the axis and the unit that the keys on top are in, also where somebody has
    changed the motion a little."""
    trans = record.array("trans", None, 3, frames=options.frames)
    size = float(np.linalg.norm(places))
    unit = options.unit
    if trans.shape == places.shape and size > 0.0:
        factor = float(np.linalg.norm(trans)) / size
        unit = next((u for u in _UNITS if 1.0 / _NEAR < u * factor < _NEAR), unit)
    return replace(options, unit=unit, up=_up(record, options, axes, turns))


def _up(record: Record, options: Options, axes: Array, turns: Array) -> str | None:
    """The axis that is up on top; None: that of the format, as of a motion of another format."""
    key = "poses" if "poses" in record else "root_orient"
    up = next((up for up in AXES if np.array_equal(axes_of(up), axes)), "z")
    if up == "z" or key not in record:
        return None
    root = record.raw(key)[options.frames]
    root = np.asarray(root, dtype=np.float64).reshape(len(root), -1)[:, :3]
    if root.shape != turns[:, 0].shape:
        return None
    written, turned = rot.exp(root), rot.multiply(rot.from_matrix(axes), rot.exp(root))
    world = rot.conjugate(rot.exp(turns[:, 0]))
    off = [
        np.linalg.norm(rot.log(rot.multiply(world, its)), axis=1).mean()
        for its in (turned, written)
    ]
    return up if off[0] < off[1] else None


def _axes(record: Record, person: _Document) -> Array:
    """World from file axes (3, 3) of a person's file."""
    try:
        return checked_axes(person.get("axes"))
    except InputError as error:
        raise FileError(f"{record.where}, {person['name']!r}: {error}") from None


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
            axes=_axes(record, person),
        )
    except InputError as error:
        raise FileError(f"{record.where}, clip {person['name']!r}: {error}") from None
