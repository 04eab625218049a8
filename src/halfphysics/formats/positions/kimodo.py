"""Kimodo's own npz: rotations and positions of the SMPL-X or of the SOMA skeleton; y up, 30 fps.

`posed_joints` (T, J, 3) [m], `local_rot_mats`, `global_rot_mats` (T, J, 3, 3), `foot_contacts`
(T, 4), `smooth_root_pos`, `root_positions` (T, 3), `global_root_heading` (T, 2). J = 22 is SMPL-X's
first joints: rotations are read as they are, and the body has the bones of `posed_joints`. J = 77
and 30 are the SOMA skeleton (`skeletons.soma`), put on the default body by its joints' names as BVH
files are: what Kimodo writes as BVH with its standard T-pose gives the same motion. J = 34 is a
robot (Unitree G1) and none of a person's. Source: nv-tlabs/kimodo
docs/source/user_guide/output_formats.md.
"""

from __future__ import annotations

from collections.abc import Sequence as Listing
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.body.body import Body
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.shape_from_joints import bones_of as bones_of_smplx
from halfphysics.formats.datasets.shape_from_joints import default_like
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import motion_of, rotations_of, same_length
from halfphysics.formats.positions.bones import leg
from halfphysics.formats.positions.layouts import BODY
from halfphysics.formats.positions.posed import scale_for
from halfphysics.formats.skeletons.skeleton_motion import retargeted_known
from halfphysics.formats.skeletons.soma import (
    SOMA,
    Soma,
    animated,
    bones_of,
    is_mirror_image,
    mirrored,
    world_turns,
)
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.simulation.sequence import Sequence

Array = NDArray[np.float64]

NAME = "kimodo"
FPS = 30.0
_PLACES = "posed_joints"
_LOCAL, _GLOBAL = "local_rot_mats", "global_rot_mats"
#: Forks of Kimodo write the rate, too.
_RATE = "fps"
_ROBOT = 34
#: Joints and rotations in single precision agree to this [m].
_AGREE = 0.02
#: Entries of R' R differ from the identity by less than this.
_ORTHOGONAL = 1e-2


def _sniff(source: Source) -> bool:
    keys = set(source.npz or ())
    return _PLACES in keys and bool(keys & {_LOCAL, _GLOBAL})


def _record(source: Source) -> tuple[Record, int]:
    """The fields, and the number of joints, which is that of a person's skeleton.

    Raises:
        FileError: It is another.
    """
    record = Record(source.path, source.npz or {})
    shape = record.shape(_PLACES)
    count = shape[1] if len(shape) == 3 else 0
    if count == _ROBOT:
        raise record.error(
            _PLACES,
            f"found shape {shape}, the skeleton of the robot Unitree G1, expected that of a person "
            "(22, 77 or 30 joints). Generate the motion with Kimodo's SOMA or SMPL-X model",
        )
    if count != len(BODY) and count not in SOMA:
        raise record.error(
            _PLACES,
            f"found shape {shape}, expected (T, 22, 3) of SMPL-X, (T, 77, 3) or (T, 30, 3) of SOMA",
        )
    return record, count


def _read(record: Record, parents: Listing[int], options: Options) -> tuple[Array, Array]:
    """Positions (T, J, 3) [m] and local rotations (T, J, 3, 3)."""
    count = len(parents)
    joints = record.array(_PLACES, None, count, 3, frames=options.frames)
    key = _LOCAL if _LOCAL in record else _GLOBAL
    matrices = record.array(key, None, count, 3, 3, frames=options.frames)
    same_length(record.where, {_PLACES: len(joints), key: len(matrices)})
    if len(joints) < 2:
        raise record.error(
            _PLACES,
            f"found {len(joints)} frames to read, expected at least 2: velocities need a next "
            "frame",
        )
    off = np.swapaxes(matrices, -1, -2) @ matrices - np.eye(3)
    if np.abs(off).max(initial=0.0) > _ORTHOGONAL or (np.linalg.det(matrices) < 0.0).any():
        raise record.error(key, "found matrices that are no rotations")
    if key == _GLOBAL:
        above = np.swapaxes(matrices[:, list(parents[1:])], -1, -2)
        matrices = np.concatenate([matrices[:, :1], above @ matrices[:, 1:]], axis=1)
    return joints, matrices


def _rate(record: Record, options: Options) -> tuple[float, dict[str, str]]:
    """The frame rate, and what is told if it is not in the file."""
    if _RATE in record:
        return record.number(_RATE, above=0.0), {}
    return FPS, {} if options.fps is not None else {"fps": f"the rate ({FPS:g} fps)"}


def _disagree(where: str, spread: float) -> FileError:
    return FileError(
        f"{where}: field '{_PLACES}': positions and rotations disagree by {spread:.2g} m, expected "
        "those of one skeleton"
    )


def _soma(record: Record, soma: Soma, options: Options) -> Motion:
    """The motion of a SOMA skeleton on the default body."""
    where = record.where
    places, matrices = _read(record, soma.parents, options)
    world = world_turns(soma, rot.from_matrix(matrices))
    offsets, spread = bones_of(soma, places, world)
    if spread > _AGREE:
        raise _disagree(where, spread)
    mirror = is_mirror_image(soma, offsets)
    if mirror:
        offsets, places, world = mirrored(offsets, places, world)
    fps, told = _rate(record, options)
    invented = {"betas": "the shape", **told}
    if len(soma.names) == min(SOMA):
        invented["hands"] = "fingers"
    motion, scale = retargeted_known(
        where,
        options,
        animated(soma, offsets, places, world),
        fps,
        NAME,
        up="y",
        invented=invented,
    )
    said = "toes point backwards: taken for a mirror image, x negated; " if mirror else ""
    warn(
        f"{where}: {said}the SOMA skeleton put on the default body by joint names, places scaled "
        f"by {scale:.3f} so that feet reach the floor; not in the file: "
        f"{', '.join(invented.values())}"
    )
    return motion


class _Smplx(NamedTuple):
    """Positions (T, 55, 3) and rotations (T, 55, 3) of the SMPL-X skeleton, and its rate."""

    where: str
    places: Array
    rotations: Array
    fps: float
    told: dict[str, str]


def _smplx(record: Record, options: Options) -> _Smplx:
    joints, matrices = _read(record, skeleton.PARENTS[: len(BODY)].tolist(), options)
    places = np.full((len(joints), skeleton.N_JOINTS, 3), np.nan)
    places[:, : len(BODY)] = joints
    rotations = rotations_of({BODY: rot.matrix_to_rotvec(matrices)})
    return _Smplx(record.where, places, rotations, *_rate(record, options))


def _motion(read: _Smplx, options: Options, body: Body, scale: float) -> Motion:
    invented = {"hands": "hands", "betas": "the shape", **read.told}
    size = "" if scale == 1.0 else f"; places scaled by {scale:.3f} to the default body"
    warn(f"{read.where}: not in the file: {', '.join(invented.values())}{size}")
    return motion_of(
        read.where,
        options,
        format=NAME,
        translation=scale * read.places[:, 0] - np.asarray(body.rest_joints)[0],
        rotations=read.rotations,
        fps=read.fps,
        up="y",
        model="smplx",
        gender="neutral",
        hands=None,
        fields={"invented": invented},
    )


def _load(source: Source, options: Options) -> Motion:
    record, count = _record(source)
    if count in SOMA:
        return _soma(record, SOMA[count], options)
    read = _smplx(record, options)
    return _motion(read, options, Body.default(), scale_for(leg(read.places)))


def _load_sequence(source: Source, options: Options) -> Sequence:
    record, count = _record(source)
    if count in SOMA:
        return Sequence(_soma(record, SOMA[count], options), Scene())
    read = _smplx(record, options)
    bones = bones_of_smplx(read.places, read.rotations)
    if bones.spread > _AGREE:
        raise _disagree(read.where, bones.spread)
    body = default_like(read.where, bones)
    return Sequence(_motion(read, options, body, 1.0), Scene(), body)


FORMAT = Format(
    name=NAME,
    about="Kimodo's own npz of the SMPL-X or SOMA skeleton",
    expects=".npz with posed_joints (T, 22 | 77 | 30, 3) and local_rot_mats (T, J, 3, 3)",
    invents="shape, frame rate (30), hands of 22 and 30 joints",
    sniff=_sniff,
    load=_load,
    load_sequence=_load_sequence,
    up="y",
)
