"""A glance at a motion: a few frames on the default body, for checks of what a file says.

Pairs of frames that are a thirtieth of a second apart, spread over the clip, so that the cost does
not grow with its length: where head, feet and skin are, and how fast the skin moves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.body.skinning import kinematics, skin
from halfphysics.motion.skeleton import JOINT_INDEX

Array = NDArray[np.float64]

#: Number of pairs of frames, and the time between the two of one pair [s].
_PAIRS, _STEP = 48, 1.0 / 30.0
#: One vertex of so many is looked at.
_VERTICES = 24
_ANKLES = [JOINT_INDEX["left_ankle"], JOINT_INDEX["right_ankle"]]
_HEAD = JOINT_INDEX["head"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Glance:
    """Some frames of a person on the default body, in the axes of the given motion.

    Attributes:
        duration: Of the whole clip [s].
        along: Unit vectors from between the ankles to the head (n, 3).
        length: Distance from there to the head, as a part of that at rest (n,).
        low: Height of the lowest skin above the root's translation (n,) [m], z up.
        skin: Points of the skin (n, P, 3) [m].
        speed: Of these points (n, P) [m/s].
        moved: How far the root went to the other frame of the pair (n, 3) [m].
        feet: How far the ankles went meanwhile, as seen from the root (n, 2, 3) [m].
        turned: How fast the feet turned meanwhile (n, 2) [rad/s].
    """

    duration: float
    along: Array
    length: Array
    low: Array
    skin: Array
    speed: Array
    moved: Array
    feet: Array
    turned: Array


def glance(translation: Array, rotations: Array, fps: float, axes: Array) -> Glance:
    """Look at a motion.

    Args:
        translation, rotations: (T, 3) [m] and axis-angle (T, 55, 3) [rad] in the world.
        fps: Frames per second.
        axes: World from file axes (3, 3), as `Motion.axes`.
    """
    body, count = Body.default(), len(translation)
    step = min(max(1, round(_STEP * fps)), count - 1)
    first = np.unique(np.linspace(0, count - 1 - step, _PAIRS).astype(np.intp))
    both = np.concatenate([first, first + step])
    turns = np.ascontiguousarray(rotations[both])
    pelvis = axes @ body.rest_joints[0] + translation[both]
    joints, quaternions = kinematics(turns, pelvis, body.rest_joints)
    points = skin(body.skin, turns, joints, quaternions, indices=_indices(body))
    seconds, n = step / fps, len(first)
    trunk = joints[:n, _HEAD] - joints[:n, _ANKLES].mean(axis=1)
    length = np.linalg.norm(trunk, axis=1)
    rest = body.rest_joints[_HEAD] - body.rest_joints[_ANKLES].mean(axis=0)
    feet = joints[:, _ANKLES] - joints[:, :1]
    own = quaternions[:, _ANKLES]
    spin = rot.log(rot.multiply(own[n:], rot.conjugate(own[:n])))
    return Glance(
        duration=(count - 1) / fps,
        along=trunk / np.maximum(length, 1e-9)[:, None],
        length=length / float(np.linalg.norm(rest)),
        low=points[:n, :, 2].min(axis=1) - translation[first, 2],
        skin=points[:n],
        speed=np.linalg.norm(points[n:] - points[:n], axis=2) / seconds,
        moved=joints[n:, 0] - joints[:n, 0],
        feet=feet[n:] - feet[:n],
        turned=np.linalg.norm(spin, axis=2) / seconds,
    )


def owners() -> NDArray[np.intp]:
    """The joint that each point of the skin in a `Glance` follows most (P,)."""
    body = Body.default()
    return np.asarray(body.weights[_indices(body)].argmax(axis=1))


def _indices(body: Body) -> NDArray[np.int32]:
    return np.arange(0, len(body.rest_vertices), _VERTICES, dtype=np.int32)
