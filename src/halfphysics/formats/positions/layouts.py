"""The joint orders of files of positions, told by the number of joints.

- 22: the first 22 of SMPL, SMPL-H and SMPL-X (HumanML3D and what is trained on it).
- 24: SMPL's, which has two more for the hands, in the middle of the palms.
- 52, 55: SMPL-H's and SMPL-X's, with fingers.
- 21: KIT-ML's (the Master Motor Map, 12.5 fps): pelvis; two joints of the spine, neck, head;
  right shoulder, elbow, wrist; left ones; right hip, knee, ankle, middle foot, toes; left ones. It
  has no upper spine and no collars: these are where our body has them against neck and shoulders.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.formats.positions.similarity import carried
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS, SMPLH_JOINTS

Array = NDArray[np.float64]

BODY = tuple(range(22))
#: Frames per second of HumanML3D and KIT-ML, by the number of joints; 20 for all others.
KIT, KIT_FPS, FPS = 21, 12.5, 20.0


def _named(names: str) -> tuple[int, ...]:
    return tuple(JOINT_INDEX[name] for name in names.split())


#: Number of joints -> their SMPL-X joints in the order of the file; -1: not used.
LAYOUTS: dict[int, tuple[int, ...]] = {
    22: BODY,
    24: (*BODY, *_named("left_middle1 right_middle1")),
    52: SMPLH_JOINTS,
    55: tuple(range(N_JOINTS)),
    KIT: (
        *_named("pelvis spine1 spine2 neck head"),
        *_named("right_shoulder right_elbow right_wrist left_shoulder left_elbow left_wrist"),
        *_named("right_hip right_knee right_ankle"),
        -1,
        *_named("right_foot left_hip left_knee left_ankle"),
        -1,
        *_named("left_foot"),
    ),
}
#: What the file of a layout does not have, and from what it is placed.
_MISSING = _named("spine3 left_collar right_collar")
_ANCHORS = _named("spine2 neck left_shoulder right_shoulder")


class Places(NamedTuple):
    """Joint positions in SMPL-X's order.

    Attributes:
        all: (T, 55, 3) [unit of the file]; NaN where the file has no such joint.
        hands: Whether the palms are seen, and whether fingers are.
        fingers: See hands.
    """

    all: Array
    hands: bool
    fingers: bool


def fps_of(count: int) -> float:
    """The documented frame rate of files with this number of joints."""
    return KIT_FPS if count == KIT else FPS


def in_order(positions: Array, rest: Array) -> Places:
    """Positions (T, J, 3) of a known layout in SMPL-X's order; `rest` (55, 3) [m]: our joints."""
    count = positions.shape[1]
    out = np.full((len(positions), N_JOINTS, 3), np.nan)
    for column, joint in enumerate(LAYOUTS[count]):
        if joint >= 0:
            out[:, joint] = positions[:, column]
    if count == KIT:
        _fill(out, rest)
    return Places(out, count == 24, count >= 52)


def _fill(places: Array, rest: Array) -> None:
    """Place what is missing with the chest: the similarity that takes our anchors to the file's."""
    anchors = list(_ANCHORS)
    places[:, list(_MISSING)] = carried(rest[anchors], places[:, anchors], rest[list(_MISSING)])
