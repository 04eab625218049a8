"""Poses and frames of live sessions, for tests of protocols."""

from __future__ import annotations

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.live.incoming import Outgoing
from halfphysics.motion.pose import Pose

BODY = Body.default()
PERSON = "ada"
#: Root rotation of an upright person who looks along -y.
UPRIGHT = np.array([np.pi / 2, 0.0, 0.0])


def t_pose(at=(0.0, 0.0)) -> Pose:
    """An upright person in a T-pose with the soles on the floor."""
    rotations = np.zeros((55, 3))
    rotations[0] = UPRIGHT
    height = BODY.rest_joints[0, 1] - BODY.rest_vertices[:, 1].min()
    return Pose(np.array([*at, height]) - BODY.rest_joints[0], rotations)


def any_pose(seed: int, *, joints=range(55), spread: float = 0.6) -> Pose:
    """A pose of random rotations of some joints, somewhere above the floor."""
    rng = np.random.default_rng(seed)
    rotations = np.zeros((55, 3))
    chosen = list(joints)
    rotations[chosen] = rng.normal(scale=spread, size=(len(chosen), 3))
    root = rot.multiply(rot.exp(rotations[0]), rot.exp(UPRIGHT))
    rotations[0] = rot.log(root)
    return Pose(rng.normal(size=3) + np.array([0.0, 0.0, 1.0]), rotations)


def outgoing(pose: Pose | None, frame: int = 0, person: str = PERSON) -> Outgoing:
    """A frame with one person and nothing else."""
    poses = {} if pose is None else {person: pose}
    return Outgoing(
        frame=frame,
        time=frame / 60,
        clock=frame / 60,
        poses=poses,
        objects={},
        contacts=None,
        names=(),
        dt=1 / 60,
        clearance=np.inf,
    )


def furthest(a: Pose, b: Pose, joints=range(55)) -> float:
    """The largest angle between the rotations of two poses [degrees]."""
    chosen = list(joints)
    return float(np.degrees(rot.angles(a.rotations[chosen], b.rotations[chosen]).max()))
