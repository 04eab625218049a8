"""Reads result files: one npz with a motion that motion readers open, and all other results.

docs/result-files.md describes the keys. Arrays are float64 and are restored bit for bit. The
motions of all persons are in the z-up world; the top-level keys are those of the input file, in the
axes of that file.
"""

from __future__ import annotations

import dataclasses
import json
import logging
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.npz import Npz
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.base.validation import file_path, shown
from halfphysics.baselines.options import OPTIONS, from_options
from halfphysics.errors import FileError, InputError
from halfphysics.formats import load_motion
from halfphysics.formats.results.keys import (
    BREACHES,
    CONTACT,
    DIAGNOSTICS,
    HOLD,
    INSIDE,
    JOINT,
    OBJECT,
    SOFT,
    SUBSTEPS,
    VERSION,
    VERSION_KEY,
    person_prefix,
)
from halfphysics.formats.results.motion_of_result import SAME, first_person
from halfphysics.formats.results.unfinished import is_unfinished, load_unfinished
from halfphysics.motion.adapted_hold import AdaptedHold
from halfphysics.motion.motion import Motion
from halfphysics.results.contacts import Contacts
from halfphysics.results.inside import Breaches, Inside
from halfphysics.results.records import BodyRecord, SceneRecord, checked_document
from halfphysics.results.result import ObjectTrack, PersonResult, Result
from halfphysics.results.soft_contacts import SoftContacts
from halfphysics.results.substeps import Substeps, at_substeps
from halfphysics.results.table import Table
from halfphysics.settings import AS_IT_IS, Settings

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.scene.scene import Scene

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]
Fields = dict[str, NDArray[Any]]
T = TypeVar("T", bound=Table)


def is_result(path: str | os.PathLike[str]) -> bool:
    """Whether a file is a result file, by content."""
    try:
        if not Path(path).is_file():  # opening a pipe would wait for a writer
            return False
        if is_unfinished(path):
            return True
        with Path(path).open("rb") as handle:
            if handle.read(2) != b"PK":
                return False
        return VERSION_KEY in Npz(path)
    except (OSError, FileError):
        return False


def load_result(
    path: str | os.PathLike[str],
    *,
    scene: Scene | None = None,
    body: Body | tuple[Body, ...] | list[Body] | None = None,
) -> Result:
    """Implements `Result.load`; see there."""
    clock = Stopwatch(logger)
    path = file_path(path)
    if scene is not None:
        _check_scene(scene)
    if not path.is_file():
        kind = "this is a folder" if path.is_dir() else "no such file"
        raise FileError(f"{path}: {kind}, expected a result file (Result.save writes one)")
    try:
        with path.open("rb") as handle:
            head = handle.read(2)
    except OSError as error:
        raise FileError(f"{path}: cannot read: {error.strerror}") from None
    if is_unfinished(path):
        result = load_unfinished(path)
        clock.done("loaded the unfinished %s: %r", path, result)
        _check_names(scene, result, path)
        return _replaced(result, scene, body)
    if head != b"PK":
        raise FileError(f"{path}: not an .npz archive, expected a result file (Result.save)")
    npz = Npz(path)
    if VERSION_KEY not in npz:
        raise FileError(
            f"{path}: found no '{VERSION_KEY}', expected a result file (Result.save writes one). "
            "A motion file is read with Motion.load"
        )
    version = npz[VERSION_KEY]
    if version.size != 1 or version.dtype.kind not in "iu" or int(version.flat[0]) != VERSION:
        raise FileError(
            f"{path}: field '{VERSION_KEY}': found {version.tolist()!r}, expected {VERSION}. A "
            "newer halfphysics may read it"
        )
    try:
        people = _parsed(npz, "meta/people")
        if not isinstance(people, list) or not people:
            raise InputError("field 'meta/people': found no people, expected at least one")
    except InputError as error:
        raise FileError(f"{path}: {error}") from None
    bodies = None if body is None else _given(body, len(people))
    try:
        result = _read(npz, people, scene, bodies)
    except InputError as error:
        raise FileError(f"{path}: {error}") from None
    clock.done("loaded %s: %r", path, result)
    _check_names(scene, result, path)
    return result


def _replaced(result: Result, scene: Scene | None, body: Any) -> Result:
    """The result with another scene and other bodies, where they are given."""
    if body is not None:
        bodies = _given(body, len(result.people))
        people = zip(result.people, bodies, strict=True)
        new = tuple(dataclasses.replace(person, body=one) for person, one in people)
        result = dataclasses.replace(result, people=new)
    return result if scene is None else dataclasses.replace(result, scene=scene)


def _check_scene(scene: Any) -> None:
    from halfphysics.scene.scene import Scene

    if not isinstance(scene, Scene):
        raise InputError(f"scene: found {shown(scene)}, expected a halfphysics.Scene")


def _check_names(scene: Scene | None, result: Result, path: Path) -> None:
    """Refuse a scene with something that a result does not have; it may have less."""
    if scene is None:
        return
    moving = set(result.objects)
    fixed = set(result.names[: len(result.names) - len(moving) - len(result.people)])
    links = [name for item in scene.articulated.values() for name in item.link_names]
    statics = [name for name in scene.statics if name not in fixed]
    objects = [name for name in (*scene.objects, *links) if name not in moving]
    if statics or objects:
        found = [
            f"{kind} {_listed(names)}"
            for kind, names in (("static", statics), ("object", objects))
            if names
        ]
        has = f"static: {_listed(sorted(fixed))}; objects: {_listed(sorted(moving))}"
        raise InputError(
            f"scene: found {' and '.join(found)}, which {path} does not have; expected the scene "
            f"that was simulated, with its names ({has})"
        )


def _listed(names: list[str]) -> str:
    return ", ".join(map(repr, names)) or "none"


def _given(body: Any, people: int) -> list[Body]:
    """The bodies passed to `Result.load`, one for each person."""
    from halfphysics.body.body import Body

    bodies = list(body) if isinstance(body, list | tuple) else [body] * people
    for one in bodies:
        if not isinstance(one, Body):
            raise InputError(
                f"body: found {shown(one)}, expected a halfphysics.Body, such as Body.default()"
            )
    if len(bodies) != people:
        raise InputError(f"body: found {len(bodies)} bodies, expected {people}")
    return bodies


def _read(npz: Npz, people_data: list[Any], scene: Scene | None, bodies: Any) -> Result:
    path = npz.path
    if bodies is None:
        bodies = _bodies(path, people_data)
    fps = _scalar(npz, "meta/fps")
    people = tuple(
        _person(npz, index, data, fps, bodies[index]) for index, data in enumerate(people_data)
    )
    document = checked_document(_parsed(npz, "meta/scene"), "field 'meta/scene'", ("version",))
    names = _field(npz, "meta/names")
    if names.ndim != 1 or names.dtype.kind != "U":
        raise InputError(
            f"field 'meta/names': found {names.dtype} {names.shape}, expected text (n,)"
        )
    return Result(
        people=people,
        objects=_tracks(npz, OBJECT),
        scene=SceneRecord(document, str(path)) if scene is None else scene,
        names=tuple(str(name) for name in names),
        contacts=_table(npz, CONTACT, Contacts),
        clearance=_field(npz, "meta/clearance"),
        lost_time=_field(npz, "meta/lost_time"),
        settings=_settings(_parsed(npz, "meta/settings")),
        substeps=_substeps(npz, people),
        diagnostics={
            key.removeprefix(DIAGNOSTICS): _field(npz, key)
            for key in npz
            if key.startswith(DIAGNOSTICS)
        },
        joints={k.removeprefix(JOINT): _field(npz, k) for k in npz if k.startswith(JOINT)},
        inside=_rows(npz, INSIDE, Inside),
        breaches=_rows(npz, BREACHES, Breaches),
        soft_contacts=_soft_contacts(npz),
    )


def _soft_contacts(npz: Npz) -> SoftContacts | None:
    """Pressures; None in files without, such as old ones."""
    there = any(key.startswith(SOFT) for key in npz)
    return _table(npz, SOFT, SoftContacts) if there else None


def _rows(npz: Npz, prefix: str, of: type[T]) -> T:
    """A table that files without rows, such as old ones, do not have."""
    return _table(npz, prefix, of) if any(k.startswith(prefix) for k in npz) else of.none()


def _bodies(path: Path, people: list[Any]) -> list[BodyRecord]:
    keys = ("model", "gender", "betas", "stature", "source", "template_source")
    return [
        BodyRecord(
            checked_document(
                person.get("body") if isinstance(person, dict) else None,
                f"field 'meta/people', body of person {index}",
                keys,
            ),
            str(path),
        )
        for index, person in enumerate(people)
    ]


def _person(npz: Npz, index: int, data: Any, fps: float, body: Any) -> PersonResult:
    keys = ("name", "gender", "model", "betas", "axes")
    data = checked_document(data, f"field 'meta/people', person {index}", keys)
    prefix = person_prefix(index)
    common: dict[str, Any] = {
        "fps": fps,
        "betas": data["betas"],
        "gender": data["gender"],
        "model": data["model"],
        "axes": data["axes"],
    }
    motion = Motion(
        _field(npz, f"{prefix}translation"), _field(npz, f"{prefix}rotations"), **common
    )
    if f"{prefix}recorded_translation" in npz:
        recorded = Motion(
            _field(npz, f"{prefix}recorded_translation"),
            _field(npz, f"{prefix}recorded_rotations"),
            **common,
        )
    else:
        recorded = None
    scale = f"{prefix}stiffness_scale"
    reference = Motion(
        _field(npz, f"{prefix}reference_translation"),
        _field(npz, f"{prefix}reference_rotations"),
        **common,
        stiffness_scale=_field(npz, scale) if scale in npz else None,
        holds=_holds(npz, prefix, data.get("holds", []), index),
        recorded=recorded,
    )
    if index == 0:
        motion, reference = _with_metadata(npz.path, motion, reference)
    there: dict[str, Any] = {
        k: _field(npz, f"{prefix}{k}") for k in _OPTIONAL if f"{prefix}{k}" in npz
    }
    return PersonResult(
        name=str(data["name"]),
        motion=motion,
        reference=reference,
        body=body,
        **there,
    )


def _holds(npz: Npz, prefix: str, data: Any, index: int) -> tuple[AdaptedHold, ...]:
    """What a person was to hold; older files have none."""
    what = f"field 'meta/people', holds of person {index}"
    if not isinstance(data, list):
        raise InputError(f"{what}: found {shown(data)}, expected a list")
    keys = ("object", "parts", "first", "last", "force", "moved")
    holds = []
    for k, each in enumerate(data):
        hold = checked_document(each, what, keys)
        if not isinstance(hold["parts"], list) or not isinstance(hold["moved"], list):
            raise InputError(f"{what}: found {shown(hold)}, expected lists of parts and of moved")
        holds.append(
            AdaptedHold(
                **{key: hold[key] for key in keys},
                position=_field(npz, f"{prefix}{HOLD}{k}/position"),
                quaternion=_field(npz, f"{prefix}{HOLD}{k}/quaternion"),
            )
        )
    return tuple(holds)


#: Fields of a person that not every file has.
_OPTIONAL = ("torque", "clock", "corrected")


def _with_metadata(path: Path, motion: Motion, reference: Motion) -> tuple[Motion, Motion]:
    """The motions with the metadata of the top-level keys, which must hold the same motion."""
    first = first_person(Npz(path))
    top = load_motion(path, gender=motion.gender, model=motion.model, clip=first)
    same = len(top) == len(motion) and all(
        np.abs(a - b).max() < SAME
        for a, b in ((top.translation, motion.translation), (top.rotations, motion.rotations))
    )
    if not same:
        raise InputError(
            "the fields on top ('trans', 'poses') are not the motion under 'meta/': the file was "
            "changed after it was written. Motion.load reads the motion on top"
        )
    return tuple(  # type: ignore[return-value]
        dataclasses.replace(m, origin=top.origin) for m in (motion, reference)
    )


def _substeps(npz: Npz, people: tuple[PersonResult, ...]) -> Substeps | None:
    if f"{SUBSTEPS}fps" not in npz:
        return None
    fps = _scalar(npz, f"{SUBSTEPS}fps")
    motions = [
        at_substeps(
            person.motion,
            _field(npz, f"{SUBSTEPS}person/{index}/translation"),
            _field(npz, f"{SUBSTEPS}person/{index}/rotations"),
            fps,
        )
        for index, person in enumerate(people)
    ]
    return Substeps(motions=tuple(motions), objects=_tracks(npz, SUBSTEPS + OBJECT))


def _table(npz: Npz, prefix: str, kind: type[T]) -> T:
    return kind(**{name: _field(npz, f"{prefix}{name}") for name in kind.columns()})


def _tracks(npz: Npz, prefix: str) -> dict[str, ObjectTrack]:
    names = dict.fromkeys(k[len(prefix) :].rsplit("/", 1)[0] for k in npz if k.startswith(prefix))
    return {
        name: ObjectTrack(
            position=_field(npz, f"{prefix}{name}/position"),
            quaternion=_field(npz, f"{prefix}{name}/quaternion"),
        )
        for name in names
    }


def _field(npz: Npz, key: str) -> NDArray[Any]:
    if key not in npz:
        raise InputError(f"field '{key}' is missing; expected it in a result file")
    return npz[key]


def _scalar(npz: Npz, key: str) -> float:
    value = _field(npz, key)
    if value.size != 1 or value.dtype.kind not in "fiu":
        raise InputError(f"field '{key}': found {value.dtype} {value.shape}, expected a number")
    return float(value.flat[0])


def _parsed(npz: Npz, key: str) -> Any:
    value = _field(npz, key)
    if value.size != 1 or value.dtype.kind != "U":
        raise InputError(f"field '{key}': found {value.dtype} {value.shape}, expected JSON text")
    try:
        return json.loads(str(value.flat[0]))
    except (json.JSONDecodeError, RecursionError) as error:
        raise InputError(f"field '{key}': not valid JSON ({error})") from None


def _settings(data: Any) -> Settings:
    checked_document(data, "field 'meta/settings'", ())
    unknown = sorted(set(data) - set(OPTIONS))
    if unknown:
        raise InputError(
            f"field 'meta/settings': found unknown settings {unknown}, expected some of "
            f"{sorted(OPTIONS)}. A newer halfphysics may read it"
        )
    # Files from before a setting existed, or before it was the default, were made without it.
    return from_options({**AS_IT_IS, **data})
