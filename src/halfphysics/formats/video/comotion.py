"""CoMotion `.pt`: people of a video, SMPL neutral; the camera's frame, y down.

A torch file of tensors with one row for each person in each frame: `id` (M,), `frame_idx` (M,),
`pose` (M, 72), `trans` (M, 3), `betas` (M, 10). The frame rate is the video's.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from halfphysics.base import torch_file
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.estimates import CAMERA, FLOOR, Seen, estimated, grouped, seen, tracked
from halfphysics.formats.format import Options, Source
from halfphysics.formats.mean_shape import mean_shape
from halfphysics.formats.motion_builder import same_length
from halfphysics.formats.video.smpl_pose import vectors_in
from halfphysics.formats.written_people import Written, lost_in, numbers_of
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

NAME = "comotion"


def _sniff(source: Source) -> bool:
    data = source.data
    return isinstance(data, dict) and data.keys() >= {"id", "frame_idx"}


def _people(source: Source) -> dict[str, Seen]:
    record = Record(source.path, source.data)
    ids = record.array("id", None)
    numbers = record.array("frame_idx", None)
    widths = {"pose": 72, "trans": 3}
    rows = {key: record.array(key, None, width) for key, width in widths.items()}
    if "betas" in record:
        rows["betas"] = record.array("betas", None, *record.shape("betas")[1:])
    lengths = {key: len(value) for key, value in rows.items()}
    same_length(record.where, {"id": len(ids), "frame_idx": len(numbers), **lengths})
    found = {
        name: (numbers[own], {key: value[own] for key, value in rows.items()})
        for name, own in grouped(ids).items()
    }
    return seen(source.path, found)


def _read(who: Seen, options: Options) -> Motion:
    record = who.record
    rotations = vectors_in(record, "pose")
    return estimated(
        record.where,
        options,
        format=NAME,
        frames=who.frames,
        translation=record.array("trans", None, 3),
        rotations=rotations,
        up="-y",
        model="smpl",
        betas=mean_shape(record, "betas", len(rotations)),
        invented={**CAMERA, **FLOOR},
    )


def _write(people: Mapping[str, Written], path: Path) -> None:
    ids = list(numbers_of(people).values())
    rows = list(people.values())
    content = {
        "id": np.repeat(ids, [len(person.frames) for person in rows]),
        "frame_idx": np.concatenate([person.frames for person in rows]),
        "pose": np.concatenate([person.smpl() for person in rows]),
        "trans": np.concatenate([person.translation for person in rows]),
        "betas": np.concatenate([np.tile(p.betas(), (len(p.frames), 1)) for p in rows]),
    }
    torch_file.write(path, content)


FORMAT = tracked(
    NAME,
    "pt with id, frame_idx (M,), pose (M, 72), trans (M, 3), betas (M, 10)",
    about="CoMotion: people of a video",
    invents="frame rate, fingers, floor, the world (it is the camera's frame)",
    sniff=_sniff,
    people=_people,
    read=_read,
    write=_write,
    suffix=".pt",
    up="-y",
    loses=lost_in(skeleton.SMPL_JOINTS, "smpl"),
)
