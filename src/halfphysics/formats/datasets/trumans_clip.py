"""TRUMANS per-clip pkl: the parameters of the `smplx` package over T frames; y-up, 30 fps.

`global_orient (T, 3) body_pose (T, 63) left_hand_pose, right_hand_pose (T, 45) jaw_pose, leye_pose,
reye_pose (T, 3) expression (T, 10) transl (T, 3)`, and `betas`, which may be empty. Files of other
programs with these names have other shapes or further fields (`plain`). The files do not state what
zero fingers mean.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.base.stored_objects import write
from halfphysics.formats.checked_fields import Record, shape_of
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.gender_names import said_gender
from halfphysics.formats.motion_builder import (
    file_parameters,
    kept_rows,
    lost_model,
    motion_of,
    rotations_of,
    same_length,
)
from halfphysics.formats.rate_names import said_rate
from halfphysics.motion.motion import Motion
from halfphysics.motion.smplx_names import PARTS

if TYPE_CHECKING:
    from halfphysics.body.body import Body

NAME = "trumans-clip"
FPS = 30.0
_HANDS = ("left_hand_pose", "right_hand_pose")
_EXPRESSION = "expression"
_NEEDED = {"global_orient", "body_pose", *_HANDS, "jaw_pose"}
_NAMES = {*PARTS, _EXPRESSION, "transl", "betas", "fps", "gender"}


def _sniff(source: Source) -> bool:
    """All of the names, no others, and one row per frame in each."""
    data = source.data
    if not isinstance(data, dict) or not data.keys() >= _NEEDED or data.keys() - _NAMES:
        return False
    shapes = {key: shape_of(data[key]) or () for key in _NEEDED}
    return all(shapes[key][1:] == (3 * len(PARTS[key]),) for key in _NEEDED)


def _load(source: Source, options: Options) -> Motion:
    record = Record(source.path, source.data)
    parts = {
        key: record.array(key, None, 3 * len(joints), frames=options.frames)
        for key, joints in PARTS.items()
        if key in record or key in ("global_orient", "body_pose")
    }
    translation = record.array("transl", None, 3, frames=options.frames)
    lengths = {key: len(part) for key, part in parts.items()}
    same_length(str(source.path), {**lengths, "transl": len(translation)})
    fingers = any(key in parts and parts[key].any() for key in _HANDS)
    has_hands = any(key in parts for key in _HANDS)
    return motion_of(
        str(source.path),
        options,
        format=NAME,
        translation=translation,
        rotations=rotations_of({PARTS[key]: part for key, part in parts.items()}),
        fps=said_rate(record) or FPS,
        up="y",
        model="smplx",
        gender=said_gender(record) or "neutral",
        betas=record.raw("betas") if "betas" in record else None,
        hands="unsaid" if fingers else "flat" if has_hands else None,
        fields={"keys": tuple(record.fields)},
        per_frame=kept_rows(record, _EXPRESSION, record.shape("transl")[0], options.frames),
    )


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    translation, rotations, said = file_parameters(motion, NAME)
    frames = len(motion)
    fields: dict[str, Any] = {
        key: rotations[:, list(joints)].reshape(frames, -1) for key, joints in PARTS.items()
    }
    fields["transl"] = translation
    fields["betas"] = np.zeros(0) if motion.betas is None else motion.betas[None]
    if said and motion.origin is not None and _EXPRESSION in motion.origin.per_frame:
        fields[_EXPRESSION] = motion.origin.per_frame[_EXPRESSION]
    if motion.fps != FPS or "fps" in said.get("keys", ()):
        fields["fps"] = motion.fps
    if motion.gender != "neutral" or "gender" in said.get("keys", ()):
        fields["gender"] = motion.gender
    write(path, fields)


FORMAT = Format(
    name=NAME,
    about="TRUMANS: one clip",
    invents="the frame rate (30)",
    expects="pkl with global_orient (T, 3), body_pose (T, 63), transl (T, 3)",
    sniff=_sniff,
    load=_load,
    save=_save,
    suffixes=(".pkl",),
    up="y",
    loses=lost_model,
)
