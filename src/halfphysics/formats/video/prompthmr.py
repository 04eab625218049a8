"""PromptHMR `results.pkl`: people of a video, SMPL-X neutral; y-up, floor at y = 0.

A joblib dump: `people` id -> {`frames` (N,), `track_id`, `smplx_world` {`pose` (N, 165) of the 55
joints, `shape` (N, 10), `trans` (N, 3)}, `smplx_cam` {`rotmat` (N, 55, 3, 3), `shape`, `trans`} in
the camera's frame}, and `camera`, `camera_world`. Fingers are on a flat hand; the frame rate is the
video's.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.base import stored_objects
from halfphysics.base.axes import axes_of
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.estimates import CAMERA, FLOOR, Seen, estimated, seen, tracked
from halfphysics.formats.format import Options, Source
from halfphysics.formats.mean_shape import mean_shape
from halfphysics.formats.motion_builder import rotations_of
from halfphysics.formats.rotation_forms import checked_matrices
from halfphysics.formats.written_people import Written, lost_in, numbers_of
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import N_JOINTS

NAME = "prompthmr"
_PEOPLE, _WORLD, _CAMERA = "people", "smplx_world", "smplx_cam"
_ALL = tuple(range(N_JOINTS))


def _sniff(source: Source) -> bool:
    data = source.data
    if not isinstance(data, dict) or not isinstance(data.get(_PEOPLE), Mapping):
        return False
    first = next(iter(data[_PEOPLE].values()), None)
    own = first is None and "camera_world" in data
    return own or (isinstance(first, Mapping) and bool({_WORLD, _CAMERA} & first.keys()))


def _people(source: Source) -> dict[str, Seen]:
    found: dict[str, tuple[Any, Mapping[str, Any]]] = {}
    for key, person in source.data[_PEOPLE].items():
        if not isinstance(person, Mapping) or "frames" not in person:
            raise FileError(
                f"{source.path}: person {key!r}: field 'frames' is missing, expected the numbers "
                "of the frames"
            )
        found[str(key)] = np.asarray(person["frames"]).reshape(-1), person
    return seen(source.path, found)


def _read(who: Seen, options: Options) -> Motion:
    world = _WORLD in who.record
    fields = who.record.raw(_WORLD if world else _CAMERA)
    if not isinstance(fields, Mapping):
        raise who.record.error(_WORLD, f"found {type(fields).__name__}, expected a dict of arrays")
    record = Record(who.record.where, fields)
    if world or "rotmat" not in record:
        rotations = rotations_of({_ALL: record.array("pose", None, 3 * N_JOINTS)})
    else:
        matrices = record.array("rotmat", None, N_JOINTS, 3, 3)
        rotations = rot.matrix_to_rotvec(checked_matrices(record, "rotmat", matrices))
    translation = record.array("trans", None, 3)
    return estimated(
        record.where,
        options,
        format=NAME,
        frames=who.frames,
        translation=translation,
        rotations=rotations,
        up="y" if world else "-y",
        model="smplx",
        betas=mean_shape(record, "shape", len(translation)),
        hands="flat",
        invented={} if world else {**CAMERA, **FLOOR},
    )


def _write(people: Mapping[str, Written], path: Path) -> None:
    content = {}
    for name, number in numbers_of(people).items():
        person = people[name]
        common = {"shape": np.tile(person.betas(), (len(person.frames), 1))}
        common["trans"] = person.translation
        own: dict[str, Any] = {"frames": person.frames, "track_id": number}
        # A file that had the camera's frame only comes back in it.
        if (person.motion.axes == axes_of("-y")).all():
            own[_CAMERA] = {"rotmat": rot.rotvec_to_matrix(person.rotations), **common}
        else:
            rows = person.rotations.reshape(len(person.frames), -1)
            own[_WORLD] = {"pose": rows, **common}
        content[number] = own
    stored_objects.write(path, {_PEOPLE: content})


FORMAT = tracked(
    NAME,
    "pkl with people: frames (N,), smplx_world with pose (N, 165), shape, trans",
    about="PromptHMR: people of a video",
    invents="frame rate",
    sniff=_sniff,
    people=_people,
    read=_read,
    write=_write,
    loses=lost_in(_ALL, "smplx"),
)
