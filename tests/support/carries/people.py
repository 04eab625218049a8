"""The recorded people."""

from __future__ import annotations

import inspect
from functools import cache

import numpy as np

from halfphysics.body.body import Body
from halfphysics.motion.skeleton import JOINT_INDEX, PARENTS


def bones_work() -> bool:
    """Whether a body can be given its bones."""
    return "bones" in inspect.signature(Body.default).parameters


@cache
def person(stature: float, arms: float = 1.0) -> Body:
    """A person of a stature [m], arms longer by a factor where bodies can be given bones."""
    body = Body.default(stature=stature)
    if arms == 1.0 or not bones_work():
        return body
    offsets = offsets_of(body)
    for side in ("left", "right"):
        for name in ("elbow", "wrist"):
            offsets[JOINT_INDEX[f"{side}_{name}"]] *= arms
    return Body.default(bones=offsets)  # they say how tall the person is


def offsets_of(body) -> np.ndarray:
    """Joints from their parents at rest (55, 3) [m]; the pelvis from the origin."""
    joints = np.asarray(body.rest_joints)
    out = joints.copy()
    out[1:] -= joints[np.asarray(PARENTS)[1:]]
    return out
