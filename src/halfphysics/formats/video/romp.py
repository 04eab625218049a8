"""ROMP, BEV and TRACE npz: people of an image or a video, SMPL; y down.

- an image: `results` {`smpl_thetas` (N, 72), `smpl_betas` (N, 10 or 11), `cam_trans` (N, 3), ...};
- a video, `video_results.npz`: `results` name of a frame -> as of an image, and `sequence_results`
  track id -> the same as lists over its frames, with `frame_id`;
- TRACE: `outputs` with one row for each person in each frame, `track_ids` and `reorganize_idx` (the
  frame), and `world_trans`, `world_global_rots` in the frame of the first camera.

Places are of the point midway between the hips, by a regressor, for which SMPL's hip joints are
taken. BEV's 11th beta is the share of a child's body, which is left out. Frames have no rate.
"""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.atomic import atomic_write
from halfphysics.base.natural_order import natural
from halfphysics.base.npz_objects import NpzObjects
from halfphysics.base.reader_warnings import warn
from halfphysics.base.stored_objects import write_object_array
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.estimates import (
    CAMERA,
    FLOOR,
    HIPS,
    PELVIS,
    Seen,
    estimated,
    from_hips,
    grouped,
    hips_of,
    once,
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

NAME = "romp"
_RESULTS, _SEQUENCES, _OUTPUTS = "results", "sequence_results", "outputs"
_POSE, _SHAPE, _PLACE = "smpl_thetas", "smpl_betas", "cam_trans"
_WORLD = ("world_trans", "world_global_rots")
_BETAS = 10


@once
def _fields(source: Source) -> dict[str, Mapping[Any, Any]]:
    """The dicts in the file, by field."""
    npz = source.npz
    if npz is None or not {_RESULTS, _OUTPUTS} & set(npz):
        return {}
    objects = NpzObjects(source.path)
    return {
        key: value
        for key in (_RESULTS, _SEQUENCES, _OUTPUTS)
        if key in objects and isinstance(value := objects[key], Mapping)
    }


def _sniff(source: Source) -> bool:
    fields = _fields(source)
    if _OUTPUTS in fields:
        return _POSE in fields[_OUTPUTS]
    results = fields.get(_RESULTS, {})
    first = next(iter(results.values()), None)
    return _POSE in results or (isinstance(first, Mapping) and _POSE in first)


def _people(source: Source) -> dict[str, Seen]:
    fields = _fields(source)
    if _OUTPUTS in fields:
        return _by_row(source, fields[_OUTPUTS])
    if fields.get(_SEQUENCES):
        return _by_track(source, fields[_SEQUENCES])
    return _by_order(source, fields[_RESULTS])


def _by_row(source: Source, outputs: Mapping[Any, Any]) -> dict[str, Seen]:
    record = Record(source.path, outputs)
    ids = record.array("track_ids", None)
    numbers = record.array("reorganize_idx", None)
    keys = [key for key in (_POSE, _SHAPE, _PLACE, *_WORLD) if key in record]
    rows = {key: record.array(key, None, *record.shape(key)[1:]) for key in keys}
    lengths = {key: len(value) for key, value in rows.items()}
    if {len(ids), len(numbers), *lengths.values()} != {len(ids)}:
        raise FileError(
            f"{source.path}: fields of different length: found track_ids {len(ids)}, "
            f"reorganize_idx {len(numbers)}, {lengths}; expected one row for each person and frame"
        )
    found = {
        name: (numbers[own], {key: value[own] for key, value in rows.items()})
        for name, own in grouped(ids).items()
    }
    return seen(source.path, found)


def _by_track(source: Source, tracks: Mapping[Any, Any]) -> dict[str, Seen]:
    found = {}
    for who, track in tracks.items():
        if not isinstance(track, Mapping) or "frame_id" not in track:
            raise FileError(f"{source.path}: person {who!r}: field 'frame_id' is missing")
        found[str(who)] = (
            np.asarray(track["frame_id"]),
            {key: _stacked(source, track, key) for key in (_POSE, _SHAPE, _PLACE) if key in track},
        )
    return seen(source.path, found)


def _stacked(source: Source, track: Mapping[Any, Any], key: str) -> Any:
    try:
        return np.stack([np.asarray(value) for value in track[key]])
    except (TypeError, ValueError) as error:
        raise FileError(
            f"{source.path}: field '{key}': {error}; expected the same shape in every frame"
        ) from None


def _by_order(source: Source, results: Mapping[Any, Any]) -> dict[str, Seen]:
    """People of files without tracks: by their order in each frame."""
    named = sorted(results, key=lambda name: natural(str(name)))
    frames = [results] if _POSE in results else [results[name] for name in named]
    rows: dict[str, list[tuple[int, dict[str, Any]]]] = {}
    for number, frame in enumerate(frames):
        if not isinstance(frame, Mapping) or not frame:
            continue  # nobody was seen
        record = Record(f"{source.path}, frame {number}", frame)
        keys = [key for key in (_POSE, _SHAPE, _PLACE) if key in record or key != _SHAPE]
        arrays = {k: record.array(k, None, *record.shape(k)[1:]) for k in keys}
        for row in range(len(arrays[_POSE])):
            if any(row >= len(value) for value in arrays.values()):
                raise record.error(_PLACE, "fewer rows than people, expected one for each")
            own = {key: value[row] for key, value in arrays.items()}
            rows.setdefault(str(row), []).append((number, own))
    if len(rows) > 1 and len(frames) > 1:
        warn(
            f"{source.path}: people are numbered by their order in each frame: the file has no "
            "tracks (ROMP's --temporal_optimize makes them)"
        )
    found: dict[str, tuple[Any, dict[str, Any]]] = {}
    for who, seen_in in rows.items():
        tracks = {key: [own[key] for _, own in seen_in] for key in seen_in[0][1]}
        numbers = np.array([number for number, _ in seen_in])
        found[who] = numbers, {key: _stacked(source, tracks, key) for key in tracks}
    return seen(source.path, found)


def _read(who: Seen, options: Options) -> Motion:
    record = who.record
    rotations = vectors_in(record, _POSE)
    world = all(key in record for key in _WORLD)
    places = record.array(_WORLD[0] if world else _PLACE, None, 3)
    if world:
        rotations[:, 0] = record.array(_WORLD[1], None, 3)
    same_length(record.where, {_POSE: len(rotations), _PLACE: len(places)})
    betas = mean_shape(record, _SHAPE, len(rotations))
    betas = None if betas is None else betas[:_BETAS]
    rest, own = rest_joints(options, "smpl", betas)
    return estimated(
        record.where,
        options,
        format=NAME,
        frames=who.frames,
        translation=from_hips(places, rotations[:, 0], rest),
        rotations=rotations,
        up="-y",
        model="smpl",
        betas=betas,
        fields={"rest": rest},
        invented={**CAMERA, **HIPS, **({} if own else PELVIS), **FLOOR},
    )


def _write(people: Mapping[str, Written], path: Path) -> None:
    """As `video_results.npz`, in one frame for all of a video."""
    tracks: dict[int, dict[str, list[Any]]] = {}
    results: dict[str, dict[str, NDArray[np.float64]]] = {}
    for name, number in numbers_of(people).items():
        person = people[name]
        places = hips_of(person.translation, person.rotations[:, 0], person.rest)
        betas = np.tile(person.betas(_BETAS), (len(places), 1))
        rows = {_POSE: person.smpl(), _SHAPE: betas, _PLACE: places}
        track = {"frame_id": person.frames.tolist(), **{key: list(rows[key]) for key in rows}}
        tracks[number] = track
        for row, at in enumerate(person.frames):
            frame = results.setdefault(f"{at:08d}.png", {})
            for key, values in rows.items():
                before = frame.get(key, np.zeros((0, values.shape[1])))
                frame[key] = np.concatenate([before, values[row : row + 1]])
    with atomic_write(path) as handle, zipfile.ZipFile(handle, "w") as archive:
        for key, content in ((_RESULTS, results), (_SEQUENCES, tracks)):
            with archive.open(zipfile.ZipInfo(f"{key}.npy"), "w") as stream:
                write_object_array(stream, content)


FORMAT = tracked(
    NAME,
    "npz with results or outputs: smpl_thetas (N, 72), smpl_betas, cam_trans (N, 3)",
    about="ROMP, BEV and TRACE: people of an image or a video",
    invents="frame rate, fingers, floor, the world (it is the camera's frame), the hips",
    sniff=_sniff,
    people=_people,
    read=_read,
    write=_write,
    suffix=".npz",
    up="-y",
    loses=lost_in(skeleton.SMPL_JOINTS, "smpl"),
)
