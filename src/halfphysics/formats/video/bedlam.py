"""BEDLAM's npz of images: people of many videos, SMPL-X or SMPL; y down, frames of 30 fps.

One row for each person in each image: `imgname` ("seq_000001/seq_000001_0005.png"), `sub` (who),
`pose_world` (M, 165 or 72), `trans_world` (M, 3), `shape` (M, 10 or more), `gender`, and the same
in the camera's frame. Images are numbered at 30 fps; of a set at 6 fps, every fifth is there. Each
person's place is about their own origin, not about the others'.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from halfphysics.base.npz_objects import NpzObjects
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.estimates import FLOOR, FPS, Seen, estimated, seen, tracked
from halfphysics.formats.format import Options, Source
from halfphysics.formats.mean_shape import mean_shape
from halfphysics.formats.motion_builder import rotations_of, same_length
from halfphysics.formats.video.smpl_pose import JOINTS, vectors_in
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import N_JOINTS

NAME = "bedlam-images"
_KEYS = {"pose_world", "trans_world", "pose_cam", "imgname"}
_IMAGE = re.compile(r"(?:(.*)[/\\])?[^/\\]*?(\d{1,9})\.\w+")


def _sniff(source: Source) -> bool:
    npz = source.npz
    return npz is not None and len(_KEYS & set(npz)) >= 3


def _people(source: Source) -> dict[str, Seen]:
    record = Record(source.path, NpzObjects(source.path))
    images = [str(name) for name in record.flat("imgname")]
    width = record.shape("pose_world")[1:]
    rows: dict[str, Any] = {
        "pose_world": record.array("pose_world", None, *width[:1]),
        "trans_world": record.array("trans_world", None, 3),
    }
    if "shape" in record:
        rows["shape"] = record.array("shape", None, *record.shape("shape")[1:])
    if "gender" in record:
        rows["gender"] = record.flat("gender")
    subjects = record.flat("sub") if "sub" in record else [""] * len(images)
    lengths = {"imgname": len(images), "sub": len(subjects)}
    same_length(record.where, {**lengths, **{key: len(value) for key, value in rows.items()}})
    found: dict[str, list[tuple[int, int]]] = {}
    for row, (image, who) in enumerate(zip(images, subjects, strict=True)):
        match = _IMAGE.fullmatch(image)
        if match is None:
            raise record.error("imgname", f"found {image!r} in row {row}, expected NAME_0005.png")
        name = "/".join(part for part in (match[1], str(who)) if part) or "person"
        found.setdefault(name, []).append((int(match[2]), row))
    people = {}
    for name, own in found.items():
        numbers, taken = np.array(sorted(own)).T
        people[name] = numbers, {key: value[taken] for key, value in rows.items()}
    return seen(source.path, people)


def _word(raw: Any) -> str:
    """Text that numpy may keep as bytes."""
    return raw.decode("utf-8", "replace") if isinstance(raw, bytes) else str(raw)


def _read(who: Seen, options: Options) -> Motion:
    record = who.record
    smpl = record.shape("pose_world")[1:] == (3 * JOINTS,)
    if smpl:
        rotations = vectors_in(record, "pose_world")
    else:
        poses = record.array("pose_world", None, 3 * N_JOINTS)
        rotations = rotations_of({tuple(range(N_JOINTS)): poses})
    said = [_word(word) for word in record.raw("gender")] if "gender" in record else ["neutral"]
    return estimated(
        record.where,
        options,
        format=NAME,
        frames=who.frames,
        translation=record.array("trans_world", None, 3),
        rotations=rotations,
        up="-y",
        model="smpl" if smpl else "smplx",
        gender=said[0],
        betas=mean_shape(record, "shape", len(rotations)),
        hands=None if smpl else "flat",
        fps=FPS,
        invented={"places": "where people are: each about their own origin", **FLOOR},
    )


FORMAT = tracked(
    NAME,
    "npz of images with imgname, sub, pose_world (M, 165), trans_world (M, 3), shape",
    about="BEDLAM's images and their people",
    invents="floor, where people are to each other",
    sniff=_sniff,
    people=_people,
    read=_read,
)
