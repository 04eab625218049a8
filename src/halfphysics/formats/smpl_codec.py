"""`.smpl` files (smplcodec, version 2.3): an npz of one person, SMPL-X, y-up.

`codecVersion, smplVersion (2: SMPL-X), gender (0 neutral, 1 male, 2 female), shapeParameters (n,),
frameCount, frameRate, bodyTranslation (T, 3), bodyPose (T, 22, 3), headPose (T, 3, 3),
leftHandPose, rightHandPose (T, 15, 3), expressionParameters`.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.npz import Npz, pack_npz, write_npz
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import (
    file_parameters,
    kept_rows,
    lost_model,
    motion_of,
    rotations_of,
    same_length,
)
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body

NAME = "smpl-codec"
CODEC, SMPLX = 1, 2
_GENDERS = ("neutral", "male", "female")
#: Field -> its joints, in the order of the field.
_PARTS = {
    "bodyPose": (0, *skeleton.BODY_JOINTS),
    "headPose": skeleton.FACE_JOINTS,
    "leftHandPose": skeleton.LEFT_HAND_JOINTS,
    "rightHandPose": skeleton.RIGHT_HAND_JOINTS,
}
_EXPRESSION = "expressionParameters"


def _sniff(source: Source) -> bool:
    npz = source.npz
    return npz is not None and "smplVersion" in npz


def _load(source: Source, options: Options) -> Motion:
    if source.npz is None:
        raise FileError(f"{source.path}: not a file of the SMPL codec")
    return motion_in(str(source.path), source.npz, options)


def motion_in(where: str, npz: Npz, options: Options) -> Motion:
    """The motion of a file's arrays; messages call it `where`."""
    record = Record(where, npz)
    if "bodyPose" not in record:
        raise FileError(
            f"{where}: holds a shape and no motion, found {record.describe()}; expected "
            "bodyPose (T, 22, 3) and bodyTranslation (T, 3)"
        )
    version = record.number("smplVersion")
    if version != SMPLX:
        raise FileError(
            f"{where}: field 'smplVersion': found {version:g}, expected {SMPLX} (SMPL-X)"
        )
    parts = {
        key: record.array(key, None, len(joints), 3, frames=options.frames)
        for key, joints in _PARTS.items()
        if key in record
    }
    translation = record.array("bodyTranslation", None, 3, frames=options.frames)
    lengths = {key: len(part) for key, part in parts.items()}
    same_length(where, {**lengths, "bodyTranslation": len(translation)})
    number = record.number("gender") if "gender" in record else -1.0
    if "gender" in record and number not in range(len(_GENDERS)):
        raise record.error("gender", f"found {number:g}, expected 0 neutral, 1 male or 2 female")
    per_frame = {}
    if _EXPRESSION in record and len(record.shape(_EXPRESSION)) == 2:
        total = record.shape("bodyTranslation")[0]
        per_frame = kept_rows(record, _EXPRESSION, total, options.frames)
    return motion_of(
        where,
        options,
        format=NAME,
        translation=translation,
        rotations=rotations_of({_PARTS[key]: part for key, part in parts.items()}),
        fps=_shortest(record.number("frameRate", above=0.0)) if "frameRate" in record else None,
        up="y",
        model="smplx",
        gender=_GENDERS[int(number)] if "gender" in record else None,
        betas=record.raw("shapeParameters") if "shapeParameters" in record else None,
        hands="flat" if "leftHandPose" in record else None,
        fields={"codec": record.number("codecVersion") if "codecVersion" in record else CODEC},
        per_frame=per_frame,
    )


def _shortest(rate: float) -> float:
    """A rate that is kept in single precision: the number of fewest digits that it stands for."""
    single = np.float32(rate)
    return float(str(single)) if float(single) == rate else rate


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    write_npz(path, _arrays(motion, NAME))


def content_of(motion: Motion, format: str) -> bytes:
    """The bytes of such a file, for a file of another format that has it inside."""
    stream = io.BytesIO()
    pack_npz(stream, _arrays(motion, format))
    return stream.getvalue()


def _arrays(motion: Motion, format: str) -> dict[str, NDArray[Any]]:
    translation, rotations, said = file_parameters(motion, format)
    fields = {
        "codecVersion": np.array(int(said.get("codec", CODEC))),
        "smplVersion": np.array(SMPLX),
        "gender": np.array(_GENDERS.index(motion.gender)),
        "frameCount": np.array(len(motion)),
        "frameRate": np.array(motion.fps),
        "bodyTranslation": translation,
        **{key: rotations[:, list(joints)] for key, joints in _PARTS.items()},
    }
    if motion.betas is not None:
        fields["shapeParameters"] = motion.betas
    if said and motion.origin is not None and _EXPRESSION in motion.origin.per_frame:
        fields[_EXPRESSION] = motion.origin.per_frame[_EXPRESSION]
    # The format has these two types only, for readers in any language.
    types = {"f": np.float32, "i": np.int32}
    return {key: value.astype(types[value.dtype.kind]) for key, value in fields.items()}


FORMAT = Format(
    name=NAME,
    about="the SMPL consortium's .smpl codec",
    expects="npz with codecVersion, bodyPose (T, 22, 3), bodyTranslation (T, 3), frameRate",
    sniff=_sniff,
    load=_load,
    save=_save,
    suffixes=(".smpl",),
    up="y",
    loses=lost_model,
)
