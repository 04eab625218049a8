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
from halfphysics.base.reader_warnings import warn
from halfphysics.errors import FileError, InputError
from halfphysics.formats.bvh.hierarchy import KEYWORD
from halfphysics.formats.bvh.retarget import names_of, retarget
from halfphysics.formats.bvh.skeleton_maps import names_of_smplx
from halfphysics.formats.bvh.source_skeleton import SourceSkeleton
from halfphysics.formats.bvh.text import Bvh, read_bvh, write_bvh
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import motion_of
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

NAME = "bvh"
#: Units per metre in the files written: centimetres.
UNITS = 100.0
ROOT = "root"
#: Key in `FileMetadata.fields`: the motion was retargeted to the default body.
DEFAULT_BODY = "default_body"
_PLACES = ("Xposition", "Yposition", "Zposition")
_TURNS = ("Xrotation", "Yrotation", "Zrotation")
# Its gimbal lock, a right angle about the middle axis z, is out of reach of knees and elbows.
_ORDER = (1, 2, 0)
# Legs longer than this [unit of the file] are not in metres.
_METRES = 4.0


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
    from halfphysics.body.body import Body

    body = Body.default()
    found = retarget(where, bvh, body.rest_joints, options.frames)
    up = options.up or found.up
    lines = [
        f"{where}: put on the default body by joint names; unit {found.unit} (a leg is "
        f"{found.scale:.4g} m per unit), {up} up"
    ]
    if missing := names_of(found.matched):
        lines.append(f"at rest, without a match in the file: {missing}")
    if found.unmatched:
        lines.append(f"not used of the file: {', '.join(found.unmatched)}")
    warn("; ".join(lines))
    hands = any(joint in found.matched for joint in skeleton.LEFT_HAND_JOINTS)
    hands |= any(joint in found.matched for joint in skeleton.RIGHT_HAND_JOINTS)
    return motion_of(
        where,
        options,
        format=NAME,
        translation=found.pelvis - body.rest_joints[0],
        rotations=found.rotations,
        fps=bvh.fps,
        up="z" if up == "z" else "y",
        model="smplx",
        gender="neutral",
        hands="flat" if hands else None,
        fields={DEFAULT_BODY: True},
    )


def _ours(where: str, bvh: Bvh, options: Options) -> Motion:
    """The motion of a skeleton with the joints and the rest pose of SMPL-X."""
    source = SourceSkeleton.of(where, bvh)
    positions, quaternions = source.frames(options.frames)
    index = [bvh.names.index(name) for name in skeleton.JOINT_NAMES]
    for joint, parent in enumerate(skeleton.PARENTS):
        if parent >= 0 and bvh.parents[index[joint]] != index[parent]:
            raise FileError(
                f"{where}: joint {skeleton.JOINT_NAMES[joint]!r} hangs on "
                f"{bvh.names[bvh.parents[index[joint]]]!r}, expected "
                f"{skeleton.JOINT_NAMES[parent]!r}, as in SMPL-X"
            )
    scale = 1.0 / UNITS if source.leg > _METRES else 1.0
    world = quaternions[:, index]
    local = world.copy()
    parents = skeleton.PARENTS[1:]
    local[:, 1:] = rot.multiply(rot.conjugate(world[:, parents]), world[:, 1:])
    if bvh.parents[index[0]] >= 0:
        # The pelvis is below a root: its offset is its rest position, J0.
        at_rest = scale * bvh.offsets[index[0]]
    else:
        from halfphysics.body.body import Body

        at_rest = Body.default().rest_joints[0]
    return motion_of(
        where,
        options,
        format=NAME,
        translation=scale * positions[:, index[0]] - at_rest,
        rotations=rot.log(local),
        fps=bvh.fps,
        up="y",
        model="smplx",
        gender="neutral",
    )


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
    loses=_loses,
)
