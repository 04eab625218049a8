"""WHAM `wham_output.pkl`: people of a video, SMPL neutral; y-up.

A joblib dump: track id -> {`pose_world` (T, 72), `trans_world` (T, 3), `betas` (T, 10), `frame_ids`
(T,)}, and `pose`, `trans`, `verts` in the camera's frame. `trans_world` is the point midway between
the hips, by a regressor of WHAM's own, for which SMPL's hip joints are taken here: a constant of a
few centimetres in the frame of the pelvis. The floor is anywhere; the frame rate is the video's.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from halfphysics.base import stored_objects
from halfphysics.formats.estimates import (
    FLOOR,
    HIPS,
    PELVIS,
    Seen,
    estimated,
    from_hips,
    hips_of,
    rest_joints,
    seen,
    tracked,
)
from halfphysics.formats.format import Options, Source
from halfphysics.formats.mean_shape import mean_shape
from halfphysics.formats.motion_builder import same_length
from halfphysics.formats.video.smpl_pose import vectors_in
from halfphysics.formats.written_people import Written, lost_in, numbers_of
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

NAME = "wham"
_KEYS = {"pose_world", "trans_world"}


def _sniff(source: Source) -> bool:
    data = source.data
    if not isinstance(data, dict) or not data:
        return False
    first = next(iter(data.values()))
    return isinstance(first, Mapping) and bool(_KEYS & first.keys())


def _people(source: Source) -> dict[str, Seen]:
    found = {}
    for key, fields in source.data.items():
        if isinstance(fields, Mapping):
            numbers = fields.get("frame_ids", np.arange(len(fields.get("trans_world", ()))))
            found[str(key)] = numbers, fields
    return seen(source.path, found)


def _read(who: Seen, options: Options) -> Motion:
    record = who.record
    rotations = vectors_in(record, "pose_world")
    places = record.array("trans_world", None, 3)
    same_length(record.where, {"pose_world": len(rotations), "trans_world": len(places)})
    betas = mean_shape(record, "betas", len(places))
    rest, own = rest_joints(options, "smpl", betas)
    return estimated(
        record.where,
        options,
        format=NAME,
        frames=who.frames,
        translation=from_hips(places, rotations[:, 0], rest),
        rotations=rotations,
        up="y",
        model="smpl",
        betas=betas,
        fields={"rest": rest},
        invented={**HIPS, **({} if own else PELVIS), **FLOOR},
    )


def _write(people: Mapping[str, Written], path: Path) -> None:
    numbers = numbers_of(people)
    content = {
        numbers[name]: {
            "pose_world": person.smpl(),
            "trans_world": hips_of(person.translation, person.rotations[:, 0], person.rest),
            "betas": np.tile(person.betas(), (len(person.frames), 1)),
            "frame_ids": person.frames,
        }
        for name, person in people.items()
    }
    stored_objects.write(path, content)


FORMAT = tracked(
    NAME,
    "pkl of tracks with pose_world (T, 72), trans_world (T, 3), betas (T, 10), frame_ids (T,)",
    about="WHAM: people of a video",
    invents="frame rate, fingers, floor, the hips",
    sniff=_sniff,
    people=_people,
    read=_read,
    write=_write,
    loses=lost_in(skeleton.SMPL_JOINTS, "smpl"),
)
