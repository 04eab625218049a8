"""3DPW: people outdoors, several in one pickle; SMPL, 30 fps, bodies at 60.

`sequenceFiles/train/NAME.pkl`, written by Python 2, is a dict of lists with one entry for each
person: `poses (N, 72)`, `trans (N, 3)`, `poses_60Hz (2 N, 72)`, `trans_60Hz (2 N, 3)`, `betas
(10,)`, `genders` ("m", "f"), `campose_valid (N,)`; and `cam_poses (N, 4, 4)`, `img_frame_ids`.
The 60 Hz poses are read where they are there: those at 30 are of the images. The world is y-up;
copies with another axis up are recognised by how the people stand.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from halfphysics.base.reader_warnings import warn
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.median_shape import median_shape
from halfphysics.formats.datasets.standing_axis import standing_axis
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.gender_names import said_gender
from halfphysics.formats.motion_builder import motion_of, rotations_of, same_length
from halfphysics.formats.people import Track
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

NAME = "3dpw"
FPS = 30.0
_ENDING = "_60Hz"


def _sniff(source: Source) -> bool:
    data = source.data
    if not isinstance(data, dict) or not {"poses", "trans"} <= data.keys():
        return False
    kin = {"cam_poses", "campose_valid", "img_frame_ids", "poses_60Hz", "jointPositions", "genders"}
    return bool(data.keys() & kin)


def _of_person(record: Record, key: str, index: int) -> Any:
    people = _list(record, key)
    if index >= len(people):
        raise record.error(key, f"found {len(people)} people, expected an array for person {index}")
    return people[index]


def _list(record: Record, key: str) -> Any:
    """A list, or an array of at least one dimension, with one entry for each person."""
    people = record.raw(key, "(a list with one array for each person)")
    fits = isinstance(people, list | tuple) or (isinstance(people, np.ndarray) and people.ndim > 0)
    if not fits:
        raise record.error(
            key, f"found {type(people).__name__}, expected a list with one array for each person"
        )
    return people


def _person(source: Source, index: int) -> tuple[Record, float]:
    """The fields of one person, and their rate: 60 Hz where these are there."""
    record = Record(source.path, source.data)
    ending = _ENDING if {f"poses{_ENDING}", f"trans{_ENDING}"} <= record.fields.keys() else ""
    fields = {key: _of_person(record, f"{key}{ending}", index) for key in ("poses", "trans")}
    for key in ("betas", "genders", "campose_valid"):
        if key in record:
            fields[key] = _of_person(record, key, index)
    return Record(f"{source.path}, clip '{index}'", fields), 2.0 * FPS if ending else FPS


def _people(source: Source) -> list[Track]:
    tracks = []
    for index in range(len(_list(Record(source.path, source.data), "poses"))):
        record, _ = _person(source, index)
        tracks.append(Track(str(index), 0, len(record.numbers("poses", None, 72))))
    return tracks


def _load(source: Source, options: Options) -> Motion:
    record, fps = _person(source, int(options.clip))
    poses = record.array("poses", None, 72, frames=options.frames).reshape(-1, 24, 3)
    translation = record.array("trans", None, 3, frames=options.frames)
    lengths = {key: len(record.raw(key)) for key in ("poses", "trans")}
    frames = same_length(record.where, lengths)
    if "campose_valid" in record:
        bad = int((~record.flat("campose_valid").astype(bool)).sum())
        if bad:
            warn(
                f"{record.where}: the camera is not known in {bad} images (campose_valid), so the "
                "person's place in the world is a guess there"
            )
    return motion_of(
        record.where,
        options,
        format=NAME,
        translation=translation,
        rotations=rotations_of({skeleton.SMPL_JOINTS: poses[:, : len(skeleton.SMPL_JOINTS)]}),
        fps=fps,
        up=standing_axis(
            record.where, poses[:, 0], options, rule="y", others=("z", "-y"), of="3DPW"
        ),
        model="smpl",
        gender=said_gender(record, "genders"),
        betas=median_shape(record, frames),
        hands=None,
    )


FORMAT = Format(
    name=NAME,
    about="3DPW: people outdoors",
    invents="fingers, the frame rate (60 or 30)",
    expects="pkl with lists poses, trans (one (T, 72), (T, 3) for each person), genders, cam_poses",
    sniff=_sniff,
    load=_load,
    people=_people,
)
