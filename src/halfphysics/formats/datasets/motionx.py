"""Motion-X npy: one array (T, 322), 30 fps.

Columns: root 0:3, body 3:66, hands 66:156, jaw 156:159, expression 159:209, face shape 209:309,
translation 309:312, betas 312:322. All rows of a clip have the same betas.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base.atomic import atomic_write
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import (
    file_parameters,
    lost_joints,
    lost_model,
    lost_rate,
    motion_of,
    rotations_of,
)
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body

NAME = "motionx"
FPS = 30.0
WIDTH = 322
_BETAS = 10
_JOINTS = (0, *skeleton.BODY_JOINTS, *skeleton.LEFT_HAND_JOINTS, *skeleton.RIGHT_HAND_JOINTS, 22)
_FACE, _TRANSLATION, _SHAPE = slice(159, 309), slice(309, 312), slice(312, 322)


def _sniff(source: Source) -> bool:
    npy = source.npy
    return npy is not None and len(npy.shape) == 2 and npy.shape[1] == WIDTH


def _load(source: Source, options: Options) -> Motion:
    npy = source.npy
    if npy is None:
        raise FileError(f"{source.path}: not a Motion-X file")
    record = Record(source.path, {"array": npy.array})
    rows = record.array("array", None, WIDTH, frames=options.frames)
    return motion_of(
        str(source.path),
        options,
        format=NAME,
        translation=rows[:, _TRANSLATION],
        rotations=rotations_of({_JOINTS: rows[:, : 3 * len(_JOINTS)]}),
        fps=FPS,
        up="y",
        model="smplx",
        gender="neutral",
        betas=rows[:, _SHAPE],
        fields={"dtype": npy.dtype},
        per_frame={"face": rows[:, _FACE]},
    )


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    translation, rotations, said = file_parameters(motion, NAME)
    frames = len(motion)
    rows = np.zeros((frames, WIDTH))
    rows[:, : 3 * len(_JOINTS)] = rotations[:, list(_JOINTS)].reshape(frames, -1)
    rows[:, _TRANSLATION] = translation
    if motion.betas is not None:
        count = min(len(motion.betas), _BETAS)
        rows[:, _SHAPE.start : _SHAPE.start + count] = motion.betas[:count]
    if said and motion.origin is not None and "face" in motion.origin.per_frame:
        rows[:, _FACE] = motion.origin.per_frame["face"]
    with atomic_write(path) as handle:
        np.lib.format.write_array(handle, rows, allow_pickle=False)


def _loses(motion: Motion) -> tuple[str, ...]:
    lost = [*lost_joints(motion, _JOINTS), *lost_model(motion)]
    if motion.betas is not None and motion.betas[_BETAS:].any():
        lost.append(f"betas after the first {_BETAS}")
    lost += lost_rate(motion, FPS)
    if motion.gender != "neutral":
        lost.append(f"the gender {motion.gender!r}: readers take neutral")
    return tuple(lost)


FORMAT = Format(
    name=NAME,
    about="Motion-X",
    invents="gender, eyes, the frame rate (30)",
    expects=f"npy with an array (T, {WIDTH})",
    sniff=_sniff,
    load=_load,
    save=_save,
    suffixes=(".npy",),
    up="y",
    loses=_loses,
)
