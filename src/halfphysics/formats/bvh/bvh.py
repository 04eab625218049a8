"""BVH: joint rotations of any skeleton; files are written y-up, in centimetres.

The reader matches joints by name (`skeleton_maps`) and retargets the motion to the default body
(`retarget`); a skeleton with the 55 SMPL-X names is read unchanged. The writer writes a root with
the translation of the SMPL-X origin, and below it the 55 joints at their rest positions, so that a
mesh in the SMPL-X rest pose fits the skeleton.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.euler import smoothest
from halfphysics.errors import FileError, InputError
from halfphysics.formats.bvh.channels import animated
from halfphysics.formats.bvh.hierarchy import KEYWORD
from halfphysics.formats.bvh.text import Bvh, read_bvh, write_bvh
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.skeletons.skeleton_maps import names_of_smplx
from halfphysics.formats.skeletons.skeleton_motion import retargeted, smplx_motion
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

NAME = "bvh"
#: Units per metre in the files written: centimetres.
UNITS = 100.0
ROOT = "root"
_PLACES = ("Xposition", "Yposition", "Zposition")
_TURNS = ("Xrotation", "Yrotation", "Zrotation")
# Its gimbal lock, a right angle about the middle axis z, is out of reach of knees and elbows.
_ORDER = (1, 2, 0)


def _sniff(source: Source) -> bool:
    return source.head.removeprefix(b"\xef\xbb\xbf").lstrip()[: len(KEYWORD)].upper() == KEYWORD


def _load(source: Source, options: Options) -> Motion:
    bvh = read_bvh(source.path)
    where = str(source.path)
    count = len(bvh.values[options.frames])
    if count < 2:
        raise FileError(
            f"{where}: found {count} frame{'' if count == 1 else 's'} of {len(bvh.values)} to "
            "read, expected at least 2: velocities need a next frame"
        )
    if names_of_smplx(bvh.names):
        return _ours(where, bvh, options)
    return retargeted(where, options, animated(bvh, options.frames), bvh.fps, NAME)[0]


def _ours(where: str, bvh: Bvh, options: Options) -> Motion:
    """The motion of a skeleton with the joints and the rest pose of SMPL-X, in any axes."""
    pelvis = bvh.names.index(skeleton.JOINT_NAMES[0])
    # Below a root, the pelvis's offset is its rest position, J0.
    at_rest = bvh.offsets[pelvis] if bvh.parents[pelvis] >= 0 else None
    joints = animated(bvh, options.frames)
    return smplx_motion(where, options, joints, bvh.fps, NAME, pelvis=at_rest).motion


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    if body is None:
        raise InputError(
            f"format: '{NAME}' files hold the joints of a body at rest. Say whose motion it is "
            "with body="
        )
    translation, rotations = motion.rebased(body, "y").in_file_axes()
    orders, angles = smoothest(rot.exp(rotations), _ORDER)
    still = np.zeros((len(motion), 3))
    turns = np.degrees(angles).reshape(len(motion), -1)
    values = np.concatenate([UNITS * translation, still, turns], axis=1)
    named = [tuple(_TURNS[axis] for axis in order) for order in orders]
    rest = UNITS * body.rest_joints
    offsets = rest.copy()
    offsets[1:] -= rest[skeleton.PARENTS[1:]]
    write_bvh(
        path,
        Bvh(
            names=(ROOT, *skeleton.JOINT_NAMES),
            parents=(-1, *(int(parent) + 1 for parent in skeleton.PARENTS)),
            offsets=np.concatenate([np.zeros((1, 3)), offsets]),
            ends={joint + 1: UNITS * end for joint, end in _ends(body).items()},
            channels=(_PLACES + named[0], *named),
            values=values,
            fps=motion.fps,
        ),
    )


def _ends(body: Body) -> dict[int, Array]:
    """For joints without children: the vector to the farthest vertex of their skin [m]."""
    ends = {}
    owner = body.weights.argmax(axis=1)
    for joint in set(range(skeleton.N_JOINTS)) - set(skeleton.PARENTS.tolist()):
        ways = body.rest_vertices[owner == joint] - body.rest_joints[joint]
        far = int(np.argmax(np.linalg.norm(ways, axis=1))) if len(ways) else -1
        # A joint without skin (in SMPL-H and SMPL) is a point.
        ends[joint] = ways[far] if len(ways) else np.zeros(3)
    return ends


def _loses(motion: Motion) -> tuple[str, ...]:
    lost = []
    if motion.betas is not None and motion.betas.any():
        lost.append("the shape (betas): the joints of the body are written, its skin is not")
    if motion.gender != "neutral":
        lost.append(f"the gender {motion.gender!r}")
    if motion.model != "smplx":
        lost.append(f"the model {motion.model!r}: read back as smplx")
    return tuple(lost)


FORMAT = Format(
    name=NAME,
    about="motion capture of any human skeleton, retargeted by joint names",
    invents="the person's shape, gender and model",
    expects="BVH text that begins with HIERARCHY, of a person's skeleton",
    sniff=_sniff,
    load=_load,
    save=_save,
    suffixes=(".bvh",),
    up="y",
    needs_body=True,
    tells_bones=True,
    loses=_loses,
)
