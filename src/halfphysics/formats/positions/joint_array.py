"""Joint positions in `.npy`: (T, J, 3), or several clips (N, T, J, 3); y up, metres.

What HumanML3D's `new_joints/*.npy`, MoMask (`joints/<k>/sample*_repeat*_len*.npy`), T2M-GPT,
MotionGPT, FlowMDM, MLD and others write. J = 22: SMPL's first joints; 24: SMPL's; 21: KIT-ML's;
52, 55: SMPL-H's and SMPL-X's (`layouts`). The files have no rate: 20 fps, KIT-ML 12.5. A leading
axis is of people or clips (`clip_array`); a folder of such files is a library of clips.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.formats.checked_fields import Record
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.positions.clip_array import clip_names, clip_of
from halfphysics.formats.positions.layouts import LAYOUTS
from halfphysics.formats.positions.posed import Found, loaders
from halfphysics.formats.positions.written_joints import (
    lost_without_twist,
    places_of,
    write_array,
)
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body

NAME = "joints"
_FIELD = "array"


def _sniff(source: Source) -> bool:
    npy = source.npy
    if npy is None or npy.dtype.kind not in "fiu" or len(npy.shape) not in (3, 4):
        return False
    return npy.shape[-1] == 3 and npy.shape[-2] in LAYOUTS


def _clips(source: Source) -> list[str]:
    return clip_names(source, 3)


def _found(source: Source, options: Options) -> Found:
    where, array = clip_of(source, options, 3)
    record = Record(where, {_FIELD: array})
    return Found(where, record.array(_FIELD, None, array.shape[1], 3, frames=options.frames))


_load, _load_sequence = loaders(NAME, _found)


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    write_array(path, places_of(motion, body, NAME).astype(np.float32))


FORMAT = Format(
    name=NAME,
    about="joint positions, as HumanML3D, MoMask and other generators of motion write them",
    expects=".npy of joint positions (T, 22, 3), or of 21, 24, 52 or 55 joints, or (N, T, J, 3)",
    invents="turns of bones about themselves, hands, shape, frame rate (20; KIT 12.5)",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
    clips=_clips,
    save=_save,
    tells_bones=True,
    suffixes=(".npy",),
    loses=lost_without_twist,
    up="y",
)
