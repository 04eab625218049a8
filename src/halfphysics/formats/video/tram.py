"""TRAM: people of a video, SMPL neutral; the camera's frame and a camera in a y-up world.

`results/SEQUENCE/hps/hps_track_K.npy` is a pickled dict of torch tensors: `pred_rotmat` (N, 24, 3,
3), `pred_trans` (N, 1, 3), `pred_shape` (N, 10), `frame` (N,), in the camera's frame (y down).
`camera.npy` in SEQUENCE has `world_cam_R` (F, 3, 3) and `world_cam_T` (F, 3): x_world = R x_camera
+ t. SEQUENCE, `hps` or one track is loaded. The floor is anywhere; the frame rate is the video's.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from halfphysics.base.stored_objects import read as read_stored
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.estimates import (
    CAMERA,
    FLOOR,
    PELVIS,
    Seen,
    by_camera,
    estimated,
    files_in,
    rest_joints,
    seen,
    tracked,
)
from halfphysics.formats.format import Options, Source
from halfphysics.formats.mean_shape import mean_shape
from halfphysics.formats.motion_builder import same_length
from halfphysics.formats.rotation_forms import checked_matrices
from halfphysics.formats.video.smpl_pose import matrices_in
from halfphysics.motion.motion import Motion

NAME = "tram"
_KEYS = {"pred_rotmat", "pred_trans"}
_TRACK = re.compile(r"hps_track_(\d{1,9})\.npy")
_FOLDER, _CAMERA = "hps", "camera.npy"
_ROTATION, _PLACE = "world_cam_R", "world_cam_T"


def _files(source: Source) -> list[Path]:
    """The tracks in a folder, by number."""
    folder = source.path / _FOLDER if (source.path / _FOLDER).is_dir() else source.path
    found = sorted(files_in(folder, _TRACK), key=lambda pair: int(pair[0][1]))
    return [path for _, path in found]


def _sniff(source: Source) -> bool:
    if source.is_folder:
        return bool(_files(source))
    data = source.data if source.npy is not None else None
    return isinstance(data, dict) and len(_KEYS & data.keys()) > 0


def _people(source: Source) -> dict[str, Seen]:
    files = _files(source) if source.is_folder else [source.path]
    found = {}
    for path in files:
        data = read_stored(path) if source.is_folder else source.data
        if not isinstance(data, dict):
            raise FileError(f"{path}: found a {type(data).__name__}, expected a dict of tensors")
        match = _TRACK.fullmatch(path.name)
        numbers = Record(path, data).flat("frame", "(N,)")
        found[match[1] if match else path.stem] = numbers, {**data, **_camera(path)}
    return seen(source.path, found)


def _camera(track: Path) -> dict[str, Any]:
    """The fields of the camera beside a track's folder; empty: there is none."""
    folder = track.resolve().parent
    for path in (folder.parent / _CAMERA, folder / _CAMERA):
        if path.is_file():
            data = read_stored(path)
            if not isinstance(data, Mapping) or not {_ROTATION, _PLACE} <= data.keys():
                raise FileError(f"{path}: expected fields {_ROTATION} (F, 3, 3) and {_PLACE}")
            return {key: data[key] for key in (_ROTATION, _PLACE)}
    return {}


def _read(who: Seen, options: Options) -> Motion:
    record = who.record
    rotations = matrices_in(record, "pred_rotmat")
    count = len(rotations)
    shape = record.shape("pred_trans", "(N, 1, 3)")
    middle = shape[1:-1] if shape[1:-1] in ((), (1,)) else (1,)
    translation = record.array("pred_trans", None, *middle, 3).reshape(-1, 3)
    same_length(record.where, {"pred_rotmat": count, "pred_trans": len(translation)})
    betas = mean_shape(record, "pred_shape", count)
    told = dict(CAMERA)
    world = _ROTATION in record
    if world:
        numbers = np.asarray(who.frames, dtype=np.int64)
        turns = checked_matrices(record, _ROTATION, record.array(_ROTATION, None, 3, 3))
        places = record.array(_PLACE, None, 3)
        if numbers.max(initial=-1) >= min(len(turns), len(places)) or len(numbers) != count:
            raise FileError(
                f"{record.where}: {count} poses of frames {numbers.min(initial=0)} to "
                f"{numbers.max(initial=0)}, expected as many frame numbers, within the "
                f"{min(len(turns), len(places))} frames of {_CAMERA}"
            )
        rest, own = rest_joints(options, "smpl", betas)
        translation, rotations = by_camera(
            turns[numbers], places[numbers], translation, rotations, rest[0]
        )
        told = {} if own else dict(PELVIS)
    return estimated(
        record.where,
        options,
        format=NAME,
        frames=who.frames,
        translation=translation,
        rotations=rotations,
        up="y" if world else "-y",
        model="smpl",
        betas=betas,
        invented={**told, **FLOOR},
    )


FORMAT = tracked(
    NAME,
    "a folder with hps/hps_track_0.npy (pred_rotmat (N, 24, 3, 3), pred_trans, frame), camera.npy",
    about="TRAM: people of a video",
    invents="frame rate, fingers, floor, the pelvis at rest",
    sniff=_sniff,
    people=_people,
    read=_read,
)
