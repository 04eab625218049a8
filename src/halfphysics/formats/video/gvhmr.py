"""GVHMR `hmr4d_results.pt`: one person of a video, SMPL-X neutral; y-up, gravity aligned.

A torch file of `smpl_params_global` {`body_pose` (L, 63), `global_orient` (L, 3), `transl` (L, 3),
`betas` (L, 10)}, of `smpl_params_incam` with the same keys in the camera's frame (y down), of
`K_fullimg` and `net_outputs`. Hands are SMPL-X's relaxed ones and not stored; the floor is
anywhere; the frame rate is the video's.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.base import torch_file
from halfphysics.base.axes import axes_of
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.estimates import estimated_smplx, once
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.written_people import lost_in, written
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body

NAME = "gvhmr"
_WORLD, _CAMERA = "smpl_params_global", "smpl_params_incam"


@once
def _data(source: Source) -> dict[str, Any]:
    data = source.data
    return data if isinstance(data, dict) else {}


def _sniff(source: Source) -> bool:
    return not source.is_folder and bool({_WORLD, _CAMERA} & _data(source).keys())


def _load(source: Source, options: Options) -> Motion:
    whole = Record(source.path, _data(source))
    world = _WORLD in whole
    key = _WORLD if world else _CAMERA
    fields = whole.raw(key)
    if not isinstance(fields, dict):
        raise whole.error(key, f"found {type(fields).__name__}, expected a dict of tensors")
    record = Record(f"{source.path}: {key}", fields)
    return estimated_smplx(str(source.path), record, options, format=NAME, world=world)


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    person = next(iter(written([motion], NAME).values()))
    frames = len(motion)
    # A file that had the camera's frame only comes back in it.
    key = _CAMERA if (motion.axes == axes_of("-y")).all() else _WORLD
    fields = {
        "body_pose": person.rotations[:, list(skeleton.BODY_JOINTS)].reshape(frames, -1),
        "betas": np.tile(person.betas(), (frames, 1)),
        "global_orient": person.rotations[:, 0],
        "transl": person.translation,
    }
    torch_file.write(path, {key: fields})


FORMAT = Format(
    name=NAME,
    about="GVHMR: a person of a video",
    invents="frame rate, hands, floor",
    expects="pt with smpl_params_global: body_pose (T, 63), global_orient, transl, betas",
    sniff=_sniff,
    load=_load,
    save=_save,
    suffixes=(".pt",),
    up="y",
    loses=lost_in((0, *skeleton.BODY_JOINTS), "smplx"),
)
