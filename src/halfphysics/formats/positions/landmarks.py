"""Points of the default body's skin that estimators see: nose, ears, heels, tips of the toes.

The body is made here and has no numbered landmarks, so each is found by what it is: the nose is the
skin of the head farthest ahead, ears are farthest to the sides, a heel is the hindmost of what is
close to the ground, tips of toes are the foremost of the inner and of the outer side of a foot.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from halfphysics.body.body import Body
from halfphysics.motion.skeleton import JOINT_INDEX

Array = NDArray[np.float64]

SIDES = ("left", "right")
#: A heel touches the ground: it is so low over the sole [m].
_LOW = 0.025
#: From the inner to the outer side of a foot, as parts of its width: the big toe ends before, the
#: small toe begins after.
_BIG, _SMALL = 0.5, 0.75


@cache
def landmarks() -> dict[str, Array]:
    """Places (3,) [m] on the default body at rest: nose, left_ear, left_heel, left_big_toe,
    left_small_toe, and those of the right."""
    body = Body.default()
    skin, owner = np.asarray(body.rest_vertices), np.argmax(body.weights, axis=1)
    head = skin[owner == JOINT_INDEX["head"]]
    found = {"nose": _farthest(head, 2)}
    for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
        found[f"{side}_ear"] = _farthest(head, 0, sign)
        found[f"{side}_eye"] = np.asarray(body.rest_joints)[JOINT_INDEX[f"{side}_eye_smplhf"]]
        foot = skin[np.isin(owner, [JOINT_INDEX[f"{side}_{j}"] for j in ("ankle", "foot")])]
        found[f"{side}_heel"] = _farthest(foot[foot[:, 1] < foot[:, 1].min() + _LOW], 2, -1.0)
        out = sign * foot[:, 0]
        part = (out - out.min()) / np.ptp(out)
        found[f"{side}_big_toe"] = _farthest(foot[part < _BIG], 2)
        found[f"{side}_small_toe"] = _farthest(foot[part > _SMALL], 2)
    return found


def _farthest(skin: Array, axis: int, sign: float = 1.0) -> Array:
    return np.asarray(skin[np.argmax(sign * skin[:, axis])], dtype=np.float64)
