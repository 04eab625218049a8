"""The npz that the SMPL-X Blender add-on animates: AMASS's z up, flat hands, five keys.

`trans (T, 3), gender, betas (n,), poses (T, 165), mocap_frame_rate`. The add-on
rounds the rate to a whole number, refuses a rate below its target (30 by default) and plays at the
wrong speed if the rate is no multiple of the target: hence 30, 60 or 120. `amass-smplx` reads the
file back.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base.npz import write_npz
from halfphysics.base.reader_warnings import warn
from halfphysics.formats.amass import smplx as amass_smplx
from halfphysics.formats.format import Format
from halfphysics.formats.motion_builder import file_parameters
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body

NAME = "blender"
#: Frame rates that the add-on plays at the right speed.
RATES = (30.0, 60.0, 120.0)
#: Shape directions of the add-on's meshes: zeros are the model's mean shape.
_SHAPES = 10


def _rate(fps: float) -> float:
    """The lowest of `RATES` that is at least `fps`, else the highest."""
    return next((rate for rate in RATES if rate >= fps), RATES[-1])


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    rate = _rate(motion.fps)
    if rate != motion.fps:
        warn(
            f"{path}: the SMPL-X Blender add-on plays 30, 60 or 120 frames per second: resampled "
            f"from {motion.fps:g} to {rate:g}"
        )
        motion = motion.resample(rate)
    translation, rotations, _ = file_parameters(motion, NAME)
    known = motion.model == "smplx" and motion.betas is not None
    fields = {
        "trans": translation,
        "gender": np.array(motion.gender),
        "betas": motion.betas if known else np.zeros(_SHAPES),
        "poses": rotations.reshape(len(motion), -1),
        "mocap_frame_rate": np.array(rate),
    }
    write_npz(path, {key: np.asarray(value) for key, value in fields.items()})


def _loses(motion: Motion) -> tuple[str, ...]:
    lost = []
    if motion.model != "smplx" and motion.betas is not None:
        lost.append(f"the shape: betas of {motion.model!r} mean nothing to SMPL-X")
    if _rate(motion.fps) != motion.fps:
        lost.append(f"the frame rate {motion.fps:g}: written at {_rate(motion.fps):g}")
    return tuple(lost)


FORMAT = Format(
    name=NAME,
    about="for the SMPL-X Blender add-on, written only; read as amass-smplx",
    expects="npz with trans (T, 3), gender, betas (n,), poses (T, 165), mocap_frame_rate",
    sniff=None,
    load=amass_smplx.FORMAT.load,
    save=_save,
    loses=_loses,
)
