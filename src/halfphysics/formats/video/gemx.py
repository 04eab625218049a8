"""GEM-X `hpe_results.pt`: one person of a video, on the SOMA skeleton; and GEM `smpl_params.pt`.

A torch file of `body_params_global` {`global_orient` (L, 3), `body_pose` (L, 228), `transl` (L, 3),
`identity_coeffs`, `scale_params`}, y up, of `body_params_incam` with the same keys in the frame of
the camera (y down), of `K_fullimg` and more. Poses are axis-angle of the 77 SOMA joints,
the hips first, relative to the T-pose (`skeletons.soma`); `transl` is where the hips are [m]. The
person's bones are those of the model MHR at `identity_coeffs`, which is not here: the mean person's
are taken. A `body_pose` of 63 is SMPL-X's, as GEM's SMPL-X models write it, and read as GVHMR's.
The floor is anywhere; the frame rate is the video's.

Source: NVlabs/GEM-X scripts/demo/demo_soma.py, scripts/demo/retarget_utils.py,
gem/utils/soma_utils/soma_layer.py.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.estimates import CAMERA, FLOOR, FPS, RATE, estimated_smplx, held, once
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import same_length
from halfphysics.formats.rotation_forms import numbers_of
from halfphysics.formats.skeletons.skeleton_motion import retargeted_known
from halfphysics.formats.skeletons.soma import SOMA, animated, places_of, world_turns
from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

NAME = "gem-x"
_WORLD = ("body_params_global", "pred_body_params_global")
_CAMERA = ("body_params_incam", "pred_body_params_incam")
_SOMA = SOMA[77]
#: Numbers of a pose without the hips: SOMA's and, in the models for SMPL-X, SMPL-X's.
_WIDTH, _SMPLX = 3 * (len(_SOMA.names) - 1), 63
_SIZE = {"betas": "the person's size and shape: SOMA's mean person (theirs is of the model MHR)"}


@once
def _data(source: Source) -> dict[str, Any]:
    data = source.data
    return data if isinstance(data, dict) else {}


def _sniff(source: Source) -> bool:
    return not source.is_folder and bool({*_WORLD, *_CAMERA} & _data(source).keys())


def _load(source: Source, options: Options) -> Motion:
    data = _data(source)
    key = next(key for key in (*_WORLD, *_CAMERA) if key in data)
    fields = data[key]
    if not isinstance(fields, dict):
        found = type(fields).__name__
        raise Record(source.path, data).error(key, f"found {found}, expected a dict of tensors")
    record = Record(f"{source.path}: {key}", fields)
    shape = numbers_of(record, "body_pose").shape
    width = int(np.prod(shape[1:])) if len(shape) in (2, 3) else 0
    if width not in (_WIDTH, _SMPLX):
        raise record.error(
            "body_pose",
            f"found shape {shape}, expected (T, {_WIDTH}) of SOMA or (T, {_SMPLX}) of SMPL-X",
        )
    where, world = str(source.path), key in _WORLD
    if width == _SMPLX:
        return estimated_smplx(where, record, options, format=NAME, world=world)
    return _soma(where, record, options, world=world)


def _soma(where: str, record: Record, options: Options, *, world: bool) -> Motion:
    shape = record.shape("body_pose")
    pose = record.array("body_pose", None, *shape[1:])
    root = record.array("global_orient", None, 3)
    hips = record.array("transl", None, 3)
    same_length(
        record.where, {"body_pose": len(pose), "global_orient": len(root), "transl": len(hips)}
    )
    if not len(pose):
        raise record.error("body_pose", "found no frames, expected at least one")
    turns = np.concatenate([root[:, None], pose.reshape(len(pose), -1, 3)], axis=1)
    hips, turns = held(where, hips, turns)
    hips, turns = hips[options.frames], turns[options.frames]
    turned = world_turns(_SOMA, rot.exp(turns))
    said = {**(RATE if options.fps is None else {}), **({} if world else CAMERA), **FLOOR, **_SIZE}
    motion, scale = retargeted_known(
        where,
        options,
        animated(_SOMA, _SOMA.offsets, places_of(_SOMA, hips, turned), turned),
        FPS,
        NAME,
        up="y" if world else "-y",
        invented=said,
    )
    warn(
        f"{where}: the SOMA skeleton put on the default body by joint names, places scaled by "
        f"{scale:.3f}; not in the file, and taken as: {'; '.join(said.values())}"
    )
    return motion


FORMAT = Format(
    name=NAME,
    about="GEM-X and GEM: a person of a video on the SOMA skeleton, or on SMPL-X's",
    invents="frame rate, floor, the person's size, hands of SMPL-X",
    expects="pt with body_params_global: body_pose (T, 228) of SOMA or (T, 63), global_orient, "
    "transl",
    sniff=_sniff,
    load=_load,
)
