"""Kimodo's own npz of the SMPL-X skeleton: rotations and positions of 22 joints; y up, 30 fps.

`posed_joints` (T, J, 3) [m], `local_rot_mats`, `global_rot_mats` (T, J, 3, 3), `foot_contacts`
(T, 4), `smooth_root_pos`, `root_positions` (T, 3), `global_root_heading` (T, 2). J = 22 is SMPL-X's
first joints: rotations are read as they are, and the body has the bones of `posed_joints`. J = 77
and 30 are the SOMA skeleton and J = 34 a robot (Unitree G1): Kimodo exports these as BVH, SMPL-X
motions as AMASS npz, too, and both are read.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.body.body import Body
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.shape_from_joints import bones_of, default_like
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import motion_of, rotations_of, same_length
from halfphysics.formats.positions.bones import leg
from halfphysics.formats.positions.layouts import BODY
from halfphysics.formats.positions.posed import scale_for
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

Array = NDArray[np.float64]

NAME = "kimodo"
FPS = 30.0
_KEYS = {"posed_joints", "local_rot_mats"}
_OTHERS = {77: "SOMA", 30: "SOMA", 34: "the robot Unitree G1"}
#: Joints and rotations in single precision agree to this [m].
_AGREE = 0.02
#: Entries of R' R differ from the identity by less than this.
_ORTHOGONAL = 1e-2


def _sniff(source: Source) -> bool:
    return source.npz is not None and set(source.npz) >= _KEYS


def _read(source: Source, options: Options) -> tuple[str, Array, Array]:
    """Name in messages, positions (T, 55, 3) and rotations (T, 55, 3)."""
    record = Record(source.path, source.npz or {})
    shape = np.shape(record.raw("posed_joints"))
    count = shape[1] if len(shape) == 3 else 0
    if count != len(BODY):
        other = f", the skeleton of {_OTHERS[count]}" if count in _OTHERS else ""
        way = (
            "A robot's motion is none of a person's"
            if count == 34
            else "Export it from Kimodo as BVH, or generate with its SMPL-X model"
        )
        raise record.error(
            "posed_joints", f"found shape {shape}{other}, expected (T, 22, 3) of SMPL-X. {way}"
        )
    joints = record.array("posed_joints", None, 22, 3, frames=options.frames)
    matrices = record.array("local_rot_mats", None, 22, 3, 3, frames=options.frames)
    same_length(record.where, {"posed_joints": len(joints), "local_rot_mats": len(matrices)})
    off = np.swapaxes(matrices, -1, -2) @ matrices - np.eye(3)
    if np.abs(off).max(initial=0.0) > _ORTHOGONAL or (np.linalg.det(matrices) < 0.0).any():
        raise record.error("local_rot_mats", "found matrices that are no rotations")
    places = np.full((len(joints), skeleton.N_JOINTS, 3), np.nan)
    places[:, : len(BODY)] = joints
    return record.where, places, rotations_of({BODY: rot.matrix_to_rotvec(matrices)})


def _motion(
    where: str, options: Options, places: Array, rotations: Array, body: Body, scale: float
) -> Motion:
    invented = {"hands": "hands", "betas": "the shape"}
    if options.fps is None:
        invented["fps"] = f"the rate ({FPS:g} fps)"
    size = "" if scale == 1.0 else f"; places scaled by {scale:.3f} to the default body"
    warn(f"{where}: not in the file: {', '.join(invented.values())}{size}")
    return motion_of(
        where,
        options,
        format=NAME,
        translation=scale * places[:, 0] - np.asarray(body.rest_joints)[0],
        rotations=rotations,
        fps=FPS,
        up="y",
        model="smplx",
        gender="neutral",
        hands=None,
        fields={"invented": invented},
    )


def _load(source: Source, options: Options) -> Motion:
    where, places, rotations = _read(source, options)
    return _motion(where, options, places, rotations, Body.default(), scale_for(leg(places)))


def _load_sequence(source: Source, options: Options) -> Sequence:
    where, places, rotations = _read(source, options)
    bones = bones_of(places, rotations)
    if bones.spread > _AGREE:
        raise FileError(
            f"{where}: field 'posed_joints': positions and rotations disagree by "
            f"{bones.spread:.2g} m, expected those of one skeleton"
        )
    body = default_like(where, bones)
    return Sequence(_motion(where, options, places, rotations, body, 1.0), Scene(), body)


FORMAT = Format(
    name=NAME,
    about="Kimodo's own npz of the SMPL-X skeleton",
    expects=".npz with posed_joints (T, 22, 3) and local_rot_mats (T, 22, 3, 3)",
    invents="hands, shape, frame rate (30)",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
    up="y",
)
