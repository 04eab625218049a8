"""Files with the parameter names of the `smplx` package: npz, pickle, JSON or torch file.

What most scripts dump: `global_orient`, `body_pose`, `transl` and what else there is, in any shape
(`smplx_params`); one person, a dict of people, or a list with a dict for each frame. Such files say
neither frame rate nor up axis: 30, and the axis along which the person stands. Files written here
say both, as `fps` and `up`.
"""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Sequence as Listing
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import json_files, stored_objects, torch_file
from halfphysics.base import rotations as rot
from halfphysics.base.axes import AXES, axes_of
from halfphysics.base.npz_objects import NpzObjects
from halfphysics.body.body import Body
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.estimates import FLOOR, estimated, once
from halfphysics.formats.format import Format, Options, Source, alone
from halfphysics.formats.people import Track
from halfphysics.formats.rate_names import is_rate, said_rate
from halfphysics.formats.rotation_forms import numbers_of
from halfphysics.formats.smplx_params import TRANSLATION, gender_of, is_params, parts_of, stacked
from halfphysics.formats.written_people import Written, written
from halfphysics.motion.motion import Motion
from halfphysics.motion.smplx_names import PARTS

Up = Literal["y", "z", "-y"]

NAME = "smplx-params"
#: The rate that is taken first, where a file has several.
_RATE = ("fps",)
_UP = "up"
#: What may be said beside people, once for all of them.
_COMMON = (_UP, "gender", "model", "model_type", "surface_model_type")
#: Name of the only person of a file.
_ALONE = "person"
#: The mean component of the trunk along an axis, above which the person stands along it.
_STANDS = 0.7


def _content(source: Source) -> Any:
    """What a file holds: a mapping of fields or of people, a list of frames, or None."""
    npz = source.npz
    if npz is not None:
        # A dict that numpy pickled into a field is a person, too.
        return NpzObjects(source.path) if is_params(npz) or _has_objects(source) else None
    return source.document if source.document is not None else source.data


def _has_objects(source: Source) -> bool:
    npz = source.npz
    return npz is not None and len(npz) <= 4 and any(npz.header(key)[1].hasobject for key in npz)


@once
def _people(source: Source) -> dict[str, Mapping[str, Any]]:
    """Name -> fields of each person; empty: it is no such file."""
    return _found(_content(source))


def _found(content: Any) -> dict[str, Mapping[str, Any]]:
    if is_params(content):
        return {_ALONE: content}
    if isinstance(content, list) and content and all(is_params(item) for item in content):
        return {_ALONE: stacked(content)}
    if not isinstance(content, Mapping):
        return {}
    people = {str(key): content[key] for key in list(content) if is_params(_entry(content, key))}
    common = {k: content[k] for k in list(content) if people and (k in _COMMON or is_rate(k))}
    return {name: _with(common, fields) for name, fields in people.items()}


def _with(common: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of a person, and those beside all people; a rate of its own counts alone."""
    rated = any(is_rate(key) and own[key] is not None for key in own)
    return {**{k: v for k, v in common.items() if not (rated and is_rate(k))}, **own}


def _entry(content: Mapping[str, Any], key: str) -> Any:
    if isinstance(content, NpzObjects) and not content.header(key)[1].hasobject:
        return None
    return content[key]


def _sniff(source: Source) -> bool:
    return not source.is_folder and bool(_people(source))


def _tracks(source: Source) -> Listing[Track]:
    return [
        Track(name, 0, _length(Record(_where(source, name), fields)))
        for name, fields in _people(source).items()
    ]


def _length(record: Record) -> int:
    key = next((key for key in TRANSLATION if key in record), TRANSLATION[0])
    return max(numbers_of(record, key).size // 3, 2)  # a single one is held for two


def _where(source: Source, name: str) -> str:
    return str(source.path) if name == _ALONE else f"{source.path}, clip {name!r}"


def _load(source: Source, options: Options) -> Motion:
    people = _people(source)
    name = options.clip or next(iter(people), "")
    if name not in people:
        raise FileError(f"{source.path}: found nobody in it, expected at least one person")
    record = Record(_where(source, name), people[name])
    parts = parts_of(record, options)
    up, told = _up(record, parts.rotations, options)
    motion = estimated(
        record.where,
        options,
        format=NAME,
        translation=parts.translation,
        rotations=parts.rotations,
        up=up,
        model=parts.model,
        gender=gender_of(record, options),
        betas=parts.betas,
        hands=parts.hands,
        fps=said_rate(record, _RATE),
        invented={**told, **FLOOR},
        fields={} if name == _ALONE else {"track": name},
    )
    return _on_flat_hand(motion) if parts.hands == "mean" and options.hands is None else motion


def _on_flat_hand(motion: Motion) -> Motion:
    """The motion, whose fingers are written as on a flat hand: principal components are about the
    relaxed one, rotations, as which they are written, are not."""
    own = motion.origin
    if own is None:
        return motion
    return replace(motion, origin=replace(own, fields={**own.fields, "hands_mean": None}))


def _up(
    record: Record, rotations: NDArray[np.float64], options: Options
) -> tuple[Up, dict[str, str]]:
    """The axis of the file, else that along which the trunk is on average, else y; how to tell."""
    if options.up is not None:
        return "y", {}
    if _UP in record and (said := record.text(_UP)) in AXES:
        return cast(Up, said), {}
    trunk = rot.to_matrix(rot.exp(rotations[:, 0]))[:, :, 1].mean(axis=0)
    along: dict[Up, float] = {
        up: float(axes_of(up)[2] @ trunk) for up in ("y", "z", "-y") if up in AXES
    }
    best = max(along, key=lambda up: along[up])
    if along[best] < _STANDS:
        return "y", {"up": "the up axis: y, though nobody stands along it (up= says another)"}
    words = "y down" if best == "-y" else f"{best} up"
    return best, {"up": f"the up axis: {words}, as the person stands (up= says another)"}


def _save(motions: Listing[Motion], path: Path, bodies: Listing[Body | None]) -> None:
    known = [
        m if _axis(m) is not None else m.rebased(body or Body.default(), "z")
        for m, body in zip(motions, bodies, strict=True)
    ]
    people = written(known, NAME)
    content: dict[str, Any] = {name: _fields(person) for name, person in people.items()}
    if len(content) == 1:
        content = next(iter(content.values()))
    suffix = path.suffix.lower()
    if suffix == ".pt":
        torch_file.write(path, content)
    elif suffix == ".json":
        json_files.write(path, _listed(content))
    else:
        stored_objects.write(path, content)


def _fields(person: Written) -> dict[str, Any]:
    motion = person.motion
    frames = len(motion)
    fields: dict[str, Any] = {
        part: person.rotations[:, list(joints)].reshape(frames, -1)
        for part, joints in PARTS.items()
    }
    fields["transl"] = person.translation
    fields["betas"] = np.zeros(10) if motion.betas is None else motion.betas
    said = {"gender": motion.gender, "model": motion.model, "fps": motion.fps}
    return {**fields, **said, _UP: _axis(motion)}


def _axis(motion: Motion) -> str | None:
    """The axis of the motion's file that is up; None: between them, as a floor of SLAHMR."""
    return next((up for up in AXES if (axes_of(up) == motion.axes).all()), None)


def _listed(value: Any) -> Any:
    """Lists in place of arrays."""
    if isinstance(value, Mapping):
        return {key: _listed(own) for key, own in value.items()}
    return value.tolist() if isinstance(value, np.ndarray) else value


FORMAT = Format(
    name=NAME,
    about="the parameter names of the smplx package, as most scripts dump them",
    invents="frame rate, up axis, floor, flat or relaxed hands",
    expects="npz, pkl, json or pt with global_orient (T, 3), body_pose (T, 63 or 69), transl",
    sniff=_sniff,
    load=_load,
    people=_tracks,
    save=alone(_save),
    save_people=_save,
    suffixes=(".pkl", ".pt", ".json"),
    up=None,
)
