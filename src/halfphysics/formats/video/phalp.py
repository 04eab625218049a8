"""PHALP and 4D-Humans (HMR2): people of a video, SMPL neutral; the camera's frame, y down.

A joblib dump: path of a frame -> {`tid` [N], `smpl` [N] of {`betas` (10,), `body_pose` (23, 3, 3),
`global_orient` (1, 3, 3)}, `camera` [N] of (x, y, z), `time`, ...}. There is no world, and distance
from the camera is as good as its focal length was guessed. The frame rate is the video's.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.base import stored_objects
from halfphysics.base.natural_order import natural
from halfphysics.errors import FileError
from halfphysics.formats.estimates import CAMERA, FLOOR, Seen, estimated, seen, tracked
from halfphysics.formats.format import Options, Source
from halfphysics.formats.mean_shape import mean_shape
from halfphysics.formats.video.smpl_pose import JOINTS, matrices_in
from halfphysics.formats.written_people import Written, lost_in, numbers_of
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

NAME = "phalp"
_KEYS = {"smpl", "camera"}
_TURNS = ("global_orient", "body_pose")


def _sniff(source: Source) -> bool:
    data = source.data
    if not isinstance(data, dict) or not data:
        return False
    first = next(iter(data.values()))
    return isinstance(first, Mapping) and first.keys() >= {"tid", *_KEYS}


def _people(source: Source) -> dict[str, Seen]:
    rows: dict[str, list[tuple[int, Any, Any]]] = {}
    frames = sorted(source.data.items(), key=lambda item: natural(str(item[0])))
    timed = all(isinstance(_of(f, "time"), int | np.integer) for _, f in frames)
    for number, (name, frame) in enumerate(frames):
        where = f"{source.path}: frame {name!r}"
        if not isinstance(frame, Mapping) or not frame.keys() >= {"tid", *_KEYS}:
            raise FileError(f"{where}: expected fields tid, smpl and camera")
        ids, poses, places = (list(frame[key]) for key in ("tid", "smpl", "camera"))
        if not len(ids) == len(poses) == len(places):
            raise FileError(
                f"{where}: found {len(ids)} people, {len(poses)} poses and {len(places)} cameras, "
                "expected the same number"
            )
        at = int(frame["time"]) if timed else number
        for who, pose, place in zip(ids, poses, places, strict=True):
            rows.setdefault(str(who), []).append((at, pose, place))
    return seen(source.path, {who: _columns(source, who, own) for who, own in rows.items()})


def _of(frame: Any, key: str) -> Any:
    return frame.get(key) if isinstance(frame, Mapping) else None


def _columns(
    source: Source, who: str, rows: list[tuple[int, Any, Any]]
) -> tuple[np.ndarray, dict[str, Any]]:
    """Numbers of the frames of a person, and arrays with a row for each."""
    try:
        turns = [
            np.concatenate([np.reshape(pose[key], (-1, 3, 3)) for key in _TURNS])
            for _, pose, _ in rows
        ]
        fields = {
            "pose": np.stack(turns),
            "betas": np.stack([np.reshape(pose["betas"], -1) for _, pose, _ in rows]),
            "camera": np.stack([np.reshape(place, -1) for _, _, place in rows]),
        }
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise FileError(
            f"{source.path}: person {who!r}: field 'smpl': {type(error).__name__}: {error}; "
            "expected betas (10,), body_pose (23, 3, 3) and global_orient (1, 3, 3) in every frame"
        ) from None
    return np.array([number for number, _, _ in rows]), fields


def _read(who: Seen, options: Options) -> Motion:
    record = who.record
    rotations = matrices_in(record, "pose")
    return estimated(
        record.where,
        options,
        format=NAME,
        frames=who.frames,
        translation=record.array("camera", None, 3),
        rotations=rotations,
        up="-y",
        model="smpl",
        betas=mean_shape(record, "betas", len(rotations)),
        invented={**CAMERA, **FLOOR},
    )


def _write(people: Mapping[str, Written], path: Path) -> None:
    turns = {
        name: rot.rotvec_to_matrix(person.smpl().reshape(len(person.frames), JOINTS, 3))
        for name, person in people.items()
    }
    numbers = sorted({int(number) for person in people.values() for number in person.frames})
    content: dict[str, dict[str, Any]] = {
        f"img/{number:06d}.jpg": {"time": number, "tid": [], "smpl": [], "camera": []}
        for number in numbers
    }
    names = numbers_of(people)
    for name, person in people.items():
        for row, number in enumerate(person.frames):
            frame = content[f"img/{number:06d}.jpg"]
            frame["tid"].append(names[name])
            frame["camera"].append(person.translation[row])
            own = turns[name][row]
            pose = {"global_orient": own[:1], "body_pose": own[1:], "betas": person.betas()}
            frame["smpl"].append(pose)
    stored_objects.write(path, content)


FORMAT = tracked(
    NAME,
    "pkl of frames with tid, camera and smpl: body_pose (23, 3, 3), global_orient, betas",
    about="PHALP and 4D-Humans: people of a video",
    invents="frame rate, fingers, floor, the world (it is the camera's frame)",
    sniff=_sniff,
    people=_people,
    read=_read,
    write=_write,
    up="-y",
    loses=lost_in(skeleton.SMPL_JOINTS, "smpl"),
)
