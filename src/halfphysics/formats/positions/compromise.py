"""How much every joint pulls, on a body whose bones are not those of the skeleton.

Such a body cannot be where all joints are: hips and collars are 7 cm from where models that regress
joints from the skin have them. By least squares alone all give way, and a leg that is too long
pushes its heel 4 cm into the floor. So

- joints that cannot be met pull less: one over their mean error over the clip, as in the least sum
  of distances (Weiszfeld 1937). The weights are the same in all frames, so nothing jumps;
- ankles and toes pull more: soles are where the skeleton's are, and hips and knees give way.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from halfphysics.formats.positions.inverse_kinematics import solve
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS

Array = NDArray[np.float64]

#: How many times more joints of the feet pull. Toes are met to 3 mm so. Ankles pull less, since a
#: foot of another length cannot have both, and it is the toes that the sole is under.
_FEET = {"ankle": 4.0, "foot": 10.0}
#: Joints nearer than this [m] pull fully.
_NEAR = 0.01
#: Frames that are looked at, spread over the clip, and how often the weights are renewed: more
#: change no mean error by 0.1 mm (ten real clips).
_FRAMES, _ROUNDS = 64, 2


def pulls(positions: Array, joints: Sequence[int], rest: Array) -> Array:
    """Factors on the joints' weights (55,) for `solve`, whose arguments these are."""
    feet = np.ones(N_JOINTS)
    for joint, factor in _FEET.items():
        feet[[JOINT_INDEX[f"{side}_{joint}"] for side in ("left", "right")]] = factor
    some = np.unique(np.linspace(0, len(positions) - 1, _FRAMES).round().astype(int))
    found, columns = feet, list(joints)
    for _ in range(_ROUNDS):
        off = solve(positions[some], joints, rest, found).errors.mean(axis=0)
        found = feet.copy()
        found[columns] *= _NEAR / (_NEAR + off)
    return found
