"""AIST++ pkl: `smpl_poses (T, 72)`, `smpl_trans (T, 3)`, `smpl_scaling (1,)`; y-up, 60 fps.

The SMPL body is scaled by `smpl_scaling` (about 94: centimetres of a template in metres), so the
translation in metres is `smpl_trans / smpl_scaling`. Files have no shape, gender or fingers: the
body is the mean male SMPL body, which they were fitted with (google/aistplusplus_api,
run_estimate_smpl.py).
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base.stored_objects import write
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import (
    file_parameters,
    lost_joints,
    lost_rate,
    motion_of,
    rotations_of,
)
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body

NAME = "aist"
FPS = 60.0
#: Scaling written for motions of other formats: metres.
SCALING = 1.0
_RIGID_HANDS = "_rigid_hands"
#: Of the SMPL body that all files were fitted with.
_GENDER = "male"


def _sniff(source: Source) -> bool:
    data = source.data
    if not isinstance(data, dict) or not {"smpl_poses", "smpl_trans"} & data.keys():
        return False
    return "smpl_scaling" in data or "full_pose" not in data  # else EDGE's


def _load(source: Source, options: Options) -> Motion:
    record = Record(source.path, source.data)
    poses = record.array("smpl_poses", None, 72, frames=options.frames).reshape(-1, 24, 3)
    scaling = record.number("smpl_scaling", above=0.0)
    translation = record.array("smpl_trans", None, 3, frames=options.frames) / scaling
    per_frame = {_RIGID_HANDS: poses[:, 22:]}
    if "smpl_loss" in record and math.prod(record.shape("smpl_loss")) == 1:
        loss = record.number("smpl_loss")
    else:
        loss = None
    return motion_of(
        str(source.path),
        options,
        format=NAME,
        translation=translation,
        rotations=rotations_of({skeleton.SMPL_JOINTS: poses[:, :22]}),
        fps=FPS,
        up="y",
        model="smpl",
        gender=_GENDER,
        hands=None,
        fields={"scaling": scaling, "loss": loss},
        per_frame=per_frame,
    )


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    translation, rotations, said = file_parameters(motion, NAME)
    frames, scaling = len(motion), float(said.get("scaling", SCALING))
    poses = np.zeros((frames, 24, 3))
    poses[:, :22] = rotations[:, list(skeleton.SMPL_JOINTS)]
    if said and motion.origin is not None and _RIGID_HANDS in motion.origin.per_frame:
        poses[:, 22:] = motion.origin.per_frame[_RIGID_HANDS]
    fields = {
        "smpl_loss": said.get("loss") or 0.0,
        "smpl_poses": poses.reshape(frames, 72),
        "smpl_scaling": np.array([scaling]),
        "smpl_trans": translation * scaling,
    }
    write(path, fields)


def _loses(motion: Motion) -> tuple[str, ...]:
    lost = list(lost_joints(motion, skeleton.SMPL_JOINTS))
    if motion.betas is not None and motion.betas.any():
        lost.append("the shape (betas)")
    if motion.gender != _GENDER:
        lost.append(f"the gender {motion.gender!r}: readers take {_GENDER}")
    lost += lost_rate(motion, FPS)
    return tuple(lost)


FORMAT = Format(
    name=NAME,
    about="AIST++: dances",
    invents="shape, gender, fingers, the frame rate (60)",
    expects="pkl with smpl_poses (T, 72), smpl_trans (T, 3), smpl_scaling",
    sniff=_sniff,
    load=_load,
    save=_save,
    suffixes=(".pkl",),
    up="y",
    loses=_loses,
)
