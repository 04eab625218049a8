"""GVHMR `hmr4d_results.pt`: one person of a video, SMPL-X neutral; y-up, gravity aligned.

A torch file of `smpl_params_global` {`body_pose` (L, 63), `global_orient` (L, 3), `transl` (L, 3),
`betas` (L, 10)}, of `smpl_params_incam` with the same keys in the camera's frame (y down), of
`K_fullimg` and `net_outputs`. Hands are SMPL-X's relaxed ones and not stored; the floor is
anywhere; the frame rate is the video's.
"""

from __future__ import annotations

from typing import Any

from halfphysics.formats.checked_fields import Record
from halfphysics.formats.estimates import CAMERA, FLOOR, estimated, once, relaxed
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.smplx_params import parts_of
from halfphysics.motion.motion import Motion

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
    parts = parts_of(Record(f"{source.path}: {key}", fields), options)
    hands, told = relaxed(options)
    return estimated(
        str(source.path),
        options,
        format=NAME,
        translation=parts.translation,
        rotations=parts.rotations,
        up="y" if world else "-y",
        model="smplx",
        betas=parts.betas,
        hands=hands,
        invented={**({} if world else CAMERA), **told, **FLOOR},
    )


FORMAT = Format(
    name=NAME,
    about="GVHMR: a person of a video",
    invents="frame rate, hands, floor",
    expects="pt with smpl_params_global: body_pose (T, 63), global_orient, transl, betas",
    sniff=_sniff,
    load=_load,
)
