"""SLAHMR `*_world_results.npz`: people of a video, SMPL-H; a world of any direction, with a floor.

`trans` (B, T, 3), `root_orient` (B, T, 3), `pose_body` (B, T, 63), `betas` (B, 16) of B people,
and `floor_plane` (1 or B, 3), the floor's normal n times its offset d: n x = d. The normal has
y < 0, as up has in the first camera's frame; people who clearly stand the other way decide.
`track_info.json` beside the file, or above it, has `vis_mask` of each person: 1 where they are
seen; what is before and after that is invented and left out. 30 fps.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import foreign_json
from halfphysics.base import rotations as rot
from halfphysics.base.axes import axes_of, turned
from halfphysics.base.npz import write_npz
from halfphysics.errors import FileError, InputError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.estimates import CAMERA, FLOOR, FPS, Seen, estimated, tracked
from halfphysics.formats.format import Options, Source
from halfphysics.formats.mean_shape import mean_shape
from halfphysics.formats.motion_builder import (
    lost_betas,
    lost_gender,
    lost_joints,
    lost_model,
    lost_rate,
    rotations_of,
)
from halfphysics.formats.written_people import Written
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

NAME = "slahmr"
_PLANE, _INFO = "floor_plane", "track_info.json"
_BETAS = 16
#: Height of the file's origin over the floor [m], written: a plane through it has no normal.
_HEIGHT = 1.0
#: Folders above the file that may have the file with the tracks.
_ABOVE = 3
#: The mean component of the trunk along the floor's normal, below which the normal is turned over.
_UPSIDE_DOWN = -0.3


def _sniff(source: Source) -> bool:
    npz = source.npz
    if npz is None or not set(npz) >= {"root_orient", "pose_body", "trans"}:
        return False
    return len(npz.header("root_orient")[0]) == 3


def _people(source: Source) -> dict[str, Seen]:
    npz = source.npz
    whole = Record(source.path, {} if npz is None else npz)
    shape = whole.shape("trans")
    if len(shape) != 3 or shape[2] != 3 or 0 in shape:
        raise whole.error(
            "trans", f"found shape {shape}, expected (people, T, 3) of people and frames, T > 0"
        )
    people, frames = shape[:2]
    widths = {"trans": 3, "root_orient": 3, "pose_body": 63}
    rows = {key: whole.array(key, *shape[:2], width) for key, width in widths.items()}
    if "betas" in whole:
        rows["betas"] = whole.array("betas", people, *whole.shape("betas")[1:])
    plane = _plane(whole, rows["root_orient"]) if _PLANE in whole else None
    known = _tracks(source.path, people, frames)
    found = {}
    for number in range(people):
        name, first, last = known.get(number, (str(number), 0, frames))
        fields: dict[str, Any] = {
            key: value[number, first:last] if key in widths else value[number]
            for key, value in rows.items()
        }
        where = f"{source.path}, clip {name!r}" if people > 1 else str(source.path)
        own = {} if plane is None else {_PLANE: plane}
        found[name] = Seen(np.arange(first, last), Record(where, {**fields, **own}))
    return found


def _plane(whole: Record, roots: Array) -> Array:
    """Normal and offset (4,) of the floor, the normal up."""
    given = whole.array(_PLANE, None, 3)
    size = float(np.linalg.norm(given[0])) if len(given) else 0.0
    if size == 0.0:
        raise whole.error(
            _PLANE, f"found {given.tolist()}, expected the floor's normal times offset"
        )
    sign = -1.0 if given[0, 1] > 0.0 else 1.0
    trunk = rot.to_matrix(rot.exp(roots))[..., :, 1].mean(axis=(0, 1))
    if sign * float(given[0] @ trunk) / size < _UPSIDE_DOWN:
        sign = -sign
    return np.array([*(sign * given[0] / size), sign * size])


def _tracks(path: Path, people: int, frames: int) -> dict[int, tuple[str, int, int]]:
    """Row -> name, first frame and frame after the last in which a person is seen.

    Empty where there is no such file, or it is of another video: as many people and frames.
    """
    folders = path.resolve().parents[:_ABOVE]
    file = next((folder / _INFO for folder in folders if (folder / _INFO).is_file()), None)
    if file is None:
        return {}
    try:
        said = foreign_json.read(file)
        start, end = (int(n) for n in said.get("meta", {}).get("data_interval", (0, -1)))
        found = {}
        if len(said["tracks"]) != people:
            return {}
        for name, track in said["tracks"].items():
            mask = np.asarray(track["vis_mask"], dtype=np.float64)
            mask = mask if len(mask) == frames else mask[start : end if end > start else None]
            if len(mask) != frames:
                return {}
            there = np.flatnonzero(mask > 0)
            if len(there):
                found[int(track["index"])] = str(name), int(there[0]), int(there[-1]) + 1
        return found
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        raise FileError(
            f"{file}: expected tracks with index and vis_mask ({type(error).__name__}: {error}). "
            "Without the file all frames are read"
        ) from None


def _read(who: Seen, options: Options) -> Motion:
    record = who.record
    root, pose = record.array("root_orient", None, 3), record.array("pose_body", None, 63)
    plane = _PLANE in record and options.up is None
    motion = estimated(
        record.where,
        options,
        format=NAME,
        frames=who.frames,
        translation=record.array("trans", None, 3),
        rotations=rotations_of({(0,): root, skeleton.BODY_JOINTS: pose}),
        up="-y",
        model="smplh",
        betas=mean_shape(record, "betas", len(root)),
        fps=FPS,
        fields={"floor": plane},
        invented={} if plane else {**CAMERA, **FLOOR},
    )
    return _on_floor(motion, record.raw(_PLANE)) if plane else motion


def _on_floor(motion: Motion, plane: Array) -> Motion:
    """The motion turned so that the plane is z = 0."""
    axes = axes_of("-y")
    normal = axes @ plane[:3]
    axis = np.cross(normal, [0.0, 0.0, 1.0])
    sine = float(np.linalg.norm(axis))
    angle = float(np.arctan2(sine, normal[2]))
    turn = rot.rotvec_to_matrix(angle * (axis / sine if sine else np.array([1.0, 0.0, 0.0])))
    translation, rotations = turned(motion.translation, motion.rotations, turn)
    unit = 1.0 if motion.origin is None else motion.origin.fields.get("unit", 1.0)
    return dataclasses.replace(
        motion,
        translation=translation - [0.0, 0.0, unit * plane[3]],
        rotations=rotations,
        axes=turn @ motion.axes,
    )


def _write(people: Mapping[str, Written], path: Path) -> None:
    rows = list(people.values())
    frames = {len(person.frames) for person in rows}
    if len(frames) > 1:
        raise InputError(f"format: '{NAME}' has as many frames for everybody, found {frames}")
    # The floor of these people, z = 0, in the axes of the file; its normal points up. A file that
    # was read with another axis up had none.
    normal = rows[0].motion.axes.T @ [0.0, 0.0, 1.0]
    own = rows[0].motion.origin
    floor = own is None or own.format != NAME or own.fields.get("floor", True)
    height = _HEIGHT if floor else 0.0
    count = len(rows[0].frames)
    body = [person.rotations[:, list(skeleton.BODY_JOINTS)] for person in rows]
    fields = {
        "trans": np.stack([person.translation + height * normal for person in rows]),
        "root_orient": np.stack([person.rotations[:, 0] for person in rows]),
        "pose_body": np.stack([turns.reshape(count, -1) for turns in body]),
        "betas": np.stack([person.betas(_BETAS) for person in rows]),
        **({_PLANE: (height * normal)[None]} if floor else {}),
    }
    write_npz(path, {key: value.astype(np.float32) for key, value in fields.items()})


def _loses(motion: Motion) -> tuple[str, ...]:
    lines = [*lost_joints(motion, (0, *skeleton.BODY_JOINTS)), *lost_model(motion, "smplh")]
    return (*lines, *lost_gender(motion), *lost_betas(motion, _BETAS), *lost_rate(motion, FPS))


FORMAT = tracked(
    NAME,
    "npz with trans, root_orient (B, T, 3), pose_body (B, T, 63), betas (B, 16), floor_plane",
    about="SLAHMR: people of a video",
    invents="fingers",
    sniff=_sniff,
    people=_people,
    read=_read,
    write=_write,
    suffix=".npz",
    up="-y",
    loses=_loses,
)
