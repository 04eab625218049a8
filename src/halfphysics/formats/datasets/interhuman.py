"""InterHuman (InterGen): two people in one pickle; SMPL-H without fingers, z-up, 59.94 fps.

`motions/ID.pkl` is a dict of `mocap_framerate`, `frames`, and `person1`, `person2`, each a dict of
`trans, root_orient (T, 3)`, `pose_body (T, 63)`, `betas (1, 10)`, `gender`.
"""

from __future__ import annotations

from collections.abc import Sequence as Listing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from halfphysics.base.stored_objects import write
from halfphysics.errors import InputError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.median_shape import median_shape
from halfphysics.formats.format import Format, Options, Source, alone
from halfphysics.formats.gender_names import said_gender
from halfphysics.formats.motion_builder import (
    lost_betas,
    lost_joints,
    lost_model,
    motion_of,
    rotations_of,
    same_length,
)
from halfphysics.formats.people import Track
from halfphysics.formats.rate_names import said_rate
from halfphysics.formats.written_people import written
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body

NAME = "interhuman"
#: Of the data set, where a file says no rate.
FPS = 59.94
PEOPLE = ("person1", "person2")
_KEYS = ("trans", "root_orient", "pose_body")


def _sniff(source: Source) -> bool:
    data = source.data
    return isinstance(data, dict) and any(
        isinstance(data.get(name), dict) and len(data[name].keys() & set(_KEYS)) > 1
        for name in PEOPLE
    )


def _person(source: Source, name: str) -> Record:
    fields = Record(source.path, source.data).raw(name, "(a dict of arrays)")
    if not isinstance(fields, dict):
        raise Record(source.path, source.data).error(
            name, f"found {type(fields).__name__}, expected a dict of arrays"
        )
    return Record(f"{source.path}, clip {name!r}", fields)


def _people(source: Source) -> list[Track]:
    return [
        Track(name, 0, len(_person(source, name).numbers("trans", None, 3)))
        for name in PEOPLE
        if name in source.data
    ]


def _load(source: Source, options: Options) -> Motion:
    record = _person(source, options.clip)
    whole = Record(source.path, source.data)
    translation = record.array("trans", None, 3, frames=options.frames)
    root = record.array("root_orient", None, 3, frames=options.frames)
    shape = (None, 21, 3) if len(record.shape("pose_body", "(T, 63)")) == 3 else (None, 63)
    body = record.array("pose_body", *shape, frames=options.frames)
    frames = same_length(record.where, {key: len(record.raw(key)) for key in _KEYS})
    return motion_of(
        record.where,
        options,
        format=NAME,
        translation=translation,
        rotations=rotations_of({(0,): root, skeleton.BODY_JOINTS: body}),
        fps=said_rate(whole) or FPS,
        up="z",
        model="smplh",
        gender=said_gender(record),
        betas=median_shape(record, frames),
        hands=None,
    )


def _save(motions: Listing[Motion], path: Path, bodies: Listing[Body | None]) -> None:
    if len(motions) > len(PEOPLE):
        raise InputError(f"format: '{NAME}' holds two people, found {len(motions)}")
    people = written(motions, NAME).values()
    content: dict[str, Any] = {"mocap_framerate": motions[0].fps, "frames": len(motions[0])}
    for name, person in zip(PEOPLE, people, strict=False):
        body = person.rotations[:, list(skeleton.BODY_JOINTS)]
        content[name] = {
            "trans": person.translation,
            "root_orient": person.rotations[:, 0],
            "pose_body": body.reshape(len(body), -1),
            "betas": person.betas()[None],
            "gender": person.motion.gender,
        }
    write(path, content)


def _loses(motion: Motion) -> tuple[str, ...]:
    held = (0, *skeleton.BODY_JOINTS)
    return (*lost_joints(motion, held), *lost_model(motion, "smplh"), *lost_betas(motion, 10))


FORMAT = Format(
    name=NAME,
    about="InterHuman (InterGen): two people",
    invents="fingers",
    expects=f"pkl with {' and '.join(PEOPLE)}: dicts of trans (T, 3), root_orient (T, 3), "
    "pose_body (T, 63), and mocap_framerate",
    sniff=_sniff,
    load=_load,
    people=_people,
    save=alone(_save),
    save_people=_save,
    suffixes=(".pkl",),
    loses=_loses,
)
