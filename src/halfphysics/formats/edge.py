"""EDGE pkl: `smpl_poses (T, 72)`, `smpl_trans (T, 3)`, `full_pose (T, 24, 3)`; z-up, 30 fps.

What EDGE (Tseng et al. 2023, "EDGE: Editable Dance Generation From Music") and generators of its
family write of a dance. The names are AIST++'s, whose axes, rate and unit they do not share:
`smpl_trans` is the POSITION of the pelvis [m], as EDGE's own skeleton takes it, and `full_pose` are
its joints, the pelvis first. The floor is not at 0: `floor="lowest"` puts the dance on it.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base.stored_objects import write
from halfphysics.body.body import Body
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.datasets.standing_axis import standing_axis
from halfphysics.formats.format import Format, Options, Source
from halfphysics.formats.motion_builder import same_length
from halfphysics.formats.pelvis_place import lost_by_pelvis, motion_by_pelvis
from halfphysics.formats.written_people import written
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from numpy.typing import NDArray

NAME = "edge"
FPS = 30.0
_KEYS = {"smpl_poses", "smpl_trans", "full_pose"}
#: SMPL's hands are where the middle fingers begin.
_HANDS = [skeleton.JOINT_INDEX[name] for name in ("left_middle1", "right_middle1")]
#: The pelvis is in the file twice; this far apart one of them means something else [m].
_APART = 0.01


def _sniff(source: Source) -> bool:
    data = source.data
    return isinstance(data, dict) and data.keys() >= _KEYS and "smpl_scaling" not in data


def _load(source: Source, options: Options) -> Motion:
    record = Record(source.path, source.data)
    poses = record.array("smpl_poses", None, 72, frames=options.frames).reshape(-1, 24, 3)
    pelvis = record.array("smpl_trans", None, 3, frames=options.frames)
    _check_pelvis(record, pelvis, record.array("full_pose", None, 24, 3, frames=options.frames))
    up = standing_axis(record.where, poses, options, rule="z", others=("y",), of="EDGE")
    return motion_by_pelvis(
        record.where, options, poses[:, :22], pelvis, format=NAME, up=up, fps=FPS, fields={}
    )


def _check_pelvis(record: Record, pelvis: NDArray[np.float64], joints: NDArray[np.float64]) -> None:
    same_length(record.where, {"smpl_trans": len(pelvis), "full_pose": len(joints)})
    apart = np.linalg.norm(joints[:, 0] - pelvis, axis=-1)
    if len(apart) and apart.max() > _APART:
        t = int(apart.argmax())
        raise record.error(
            "full_pose",
            f"found its first joint {apart[t]:.3g} m beside smpl_trans in frame {t}, expected both "
            "to be the pelvis [m]. Is the file another's than EDGE's?",
        )


def _save(motion: Motion, path: Path, body: Body | None) -> None:
    person = written([motion], NAME, [body])["0"]
    own = Body.default() if body is None else body
    pelvis = person.translation + person.rest[0]
    placed = Motion(pelvis - own.rest_joints[0], person.rotations, motion.fps)
    joints = own.joints(placed)[:, [*skeleton.SMPL_JOINTS, *_HANDS]]
    write(
        path,
        {
            "smpl_poses": person.smpl().astype(np.float32),
            "smpl_trans": pelvis.astype(np.float32),
            "full_pose": joints.astype(np.float32),
        },
    )


def _loses(motion: Motion) -> tuple[str, ...]:
    return lost_by_pelvis(motion, FPS)


FORMAT = Format(
    name=NAME,
    about="EDGE: generated dances",
    invents="hands, the frame rate (30), the pelvis of SMPL at rest without model=",
    expects="pkl with smpl_poses (T, 72), smpl_trans (T, 3), full_pose (T, 24, 3)",
    sniff=_sniff,
    load=_load,
    save=_save,
    suffixes=(".pkl",),
    up="z",
    loses=_loses,
)
