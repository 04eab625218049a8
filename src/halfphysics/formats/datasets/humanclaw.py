"""HumanCLAW: motions before and after a simulation; SMPL-X, y-up, 30 fps.

`trajectory_before.npz` has `xb_world_75 (T, 75)`: translation 3, root rotation 3, body 69 (21
joints and two rigid hands), or (T, 168) with the 54 joints of SMPL-X; `fps`; `meta_json`.
`trajectory_after.npz` has `transl, global_orient (T, 3)`, `body_pose (T, 54, 3)` as simulated, and
poses of its scene's objects, whose meshes are in another data set: only the person is read. The
body is the neutral one with betas 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import motion_of, rotations_of, same_length
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

NAME = "humanclaw"
FPS = 30.0
BEFORE = "xb_world_75"
_AFTER = {"transl", "global_orient", "body_pose", "step_starts"}
_JOINTS = tuple(range(1, skeleton.N_JOINTS))
#: Columns of `xb_world_75` -> the joints after the root; the two rigid hands are left out.
_WIDTHS = {75: skeleton.BODY_JOINTS, 168: _JOINTS}
_BETAS = 10


def _sniff(source: Source) -> bool:
    return source.npz is not None and (BEFORE in source.npz or set(source.npz) >= _AFTER)


def _load(source: Source, options: Options) -> Motion:
    if source.npz is None:
        raise FileError(f"{source.path}: not a file of HumanCLAW")
    record = Record(source.path, source.npz)
    translation, rotations, fingers = (_before if BEFORE in record else _after)(record, options)
    return motion_of(
        record.where,
        options,
        format=NAME,
        translation=translation,
        rotations=rotations,
        fps=record.number("fps", above=0.0) if "fps" in record else FPS,
        up="y",
        model="smplx",
        gender="neutral",
        betas=np.zeros(_BETAS),
        hands="flat" if fingers else None,
    )


def _before(record: Record, options: Options) -> tuple[Array, Array, bool]:
    """Translation, rotations, and whether there are fingers."""
    shape = record.shape(BEFORE)
    width = shape[1] if len(shape) == 2 else 0
    if width not in _WIDTHS:
        raise record.error(BEFORE, f"found shape {shape}, expected (T, 75) or (T, 168)")
    rows = record.array(BEFORE, None, width, frames=options.frames)
    joints = _WIDTHS[width]
    parts = {(0,): rows[:, 3:6], joints: rows[:, 6 : 6 + 3 * len(joints)]}
    return rows[:, :3], rotations_of(parts), width == 168


def _after(record: Record, options: Options) -> tuple[Array, Array, bool]:
    translation = record.array("transl", None, 3, frames=options.frames)
    root = record.array("global_orient", None, 3, frames=options.frames)
    pose = record.array("body_pose", None, len(_JOINTS), 3, frames=options.frames)
    keys = ("transl", "global_orient", "body_pose")
    same_length(record.where, {key: len(record.raw(key)) for key in keys})
    return translation, rotations_of({(0,): root, _JOINTS: pose}), True


FORMAT = Format(
    name=NAME,
    about="HumanCLAW: motions before and after a simulation",
    invents="fingers of (T, 75), the scene",
    expects=f"npz with {BEFORE} (T, 75), fps",
    sniff=_sniff,
    load=_load,
)
