"""Rotations of fingers from where their joints are, in the `joints` of SMPL-X.

The `smplx` package gives 127 positions: the 55 joints, then landmarks of the skin, of which 66 to
70 are the tips of thumb, index, middle, ring and little finger of the left hand, and 71 to 75 those
of the right. Every joint turns by the smallest rotation that takes the free body's bone to the next
joint, or to the tip; a turn about the bone itself is not in positions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.motion import skeleton
from halfphysics.motion.skeleton import JOINT_INDEX

Array = NDArray[np.float64]

#: Finger -> its tip in `joints` of the left hand; those of the right hand are five later.
_TIPS = {"thumb": 66, "index": 67, "middle": 68, "ring": 69, "pinky": 70}
#: Fingers that are bent by less than this in the whole clip are flat [rad].
_FLAT = 0.005


def fingers_from_joints(side: str, places: Array, wrist: Array) -> Array:
    """Rotations of a hand's 15 joints (T, 15, 3).

    Args:
        side: "left" or "right".
        places: Positions (T, J, 3) [m] in the order above, J at least 55; with J > 75 the tips are
            among them, else the last joint of a finger turns as the one before it.
        wrist: Its rotation in the same axes (T, 4).

    A hand that is flat but for what rounding and the place of the tips make of it has no rotations.
    """
    free = Body.default()
    rest = np.asarray(free.rest_joints)
    first = (skeleton.LEFT_HAND_JOINTS if side == "left" else skeleton.RIGHT_HAND_JOINTS)[0]
    out = np.zeros((len(places), 15, 3))
    for finger, tip in _TIPS.items():
        chain = [JOINT_INDEX[f"{side}_{finger}{k}"] for k in (1, 2, 3)]
        tip += 0 if side == "left" else len(_TIPS)
        ends = [*chain[1:], tip]
        turn = wrist
        for k, (joint, end) in enumerate(zip(chain, ends, strict=True)):
            bone = rest[end] - rest[joint] if k < 2 else _tip(free, joint) - rest[joint]
            if end < places.shape[1]:
                seen = rot.rotate(rot.conjugate(turn), places[:, end] - places[:, joint])
                local = _smallest(bone, seen)
            turn = rot.multiply(turn, local)
            out[:, joint - first] = rot.log(local)
    bent = [joint - first for f in _TIPS for joint in (JOINT_INDEX[f"{side}_{f}{k}"] for k in "12")]
    return out if np.abs(out[:, bent]).max(initial=0.0) > _FLAT else np.zeros_like(out)


def _tip(body: Body, last: int) -> Array:
    """The tip of a finger at rest (3,) [m]: of its last joint, the skin that is farthest along."""
    own = np.flatnonzero(np.argmax(body.weights, axis=1) == last)
    skin = body.rest_vertices[own]
    along = body.rest_joints[last] - body.rest_joints[last - 1]
    return np.asarray(skin[np.argmax(skin @ along)])


def _smallest(bone: Array, seen: Array) -> Array:
    """The smallest rotations (T, 4) that take a direction (3,) to others (T, 3)."""
    unit = bone / np.linalg.norm(bone)
    lengths = np.linalg.norm(seen, axis=1, keepdims=True)
    others = np.where(lengths > 0.0, seen / np.maximum(lengths, 1e-300), unit)
    halves = np.concatenate([1.0 + (others @ unit)[:, None], np.cross(unit, others)], axis=1)
    flat = np.linalg.norm(halves, axis=1) < 1e-9  # half a turn: about any axis across
    across = np.cross(unit, np.eye(3)[np.argmin(np.abs(unit))])
    halves[flat] = np.r_[0.0, across]
    return rot.normalize(halves)
