"""Parts of a person that can hold, push or sit on a thing: hands, feet and the seat.

A part is known by the joint that stands for it and by the skin that touches. What recorded_holds.py
finds of a part needs no more; limbs (hands and feet) can be moved and can press.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import JOINT_INDEX, LEFT_HAND_JOINTS, RIGHT_HAND_JOINTS

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

#: Skin that stands for a part when distances are asked for, at most.
SAMPLES = 120
#: The joint that stands for a seat.
SEAT = "pelvis"
_JOINTS = {
    "left_wrist": (JOINT_INDEX["left_wrist"], *LEFT_HAND_JOINTS),
    "right_wrist": (JOINT_INDEX["right_wrist"], *RIGHT_HAND_JOINTS),
    "left_ankle": (JOINT_INDEX["left_ankle"], JOINT_INDEX["left_foot"]),
    "right_ankle": (JOINT_INDEX["right_ankle"], JOINT_INDEX["right_foot"]),
    SEAT: (JOINT_INDEX[SEAT], JOINT_INDEX["left_hip"], JOINT_INDEX["right_hip"]),
}


class Part(Protocol):
    """A part that can be at a thing."""

    @property
    def name(self) -> str:
        """The joint that stands for it: "left_wrist", "right_ankle", "pelvis"."""

    @property
    def inner(self) -> NDArray[np.int32]:
        """Vertices that touch what it holds."""


class Limb(Part, Protocol):
    """A part at the end of a limb, which can be moved and can press."""

    @property
    def limb(self) -> tuple[int, int, int]:
        """Indices of the joints that place it: shoulder, elbow and wrist; hip, knee and ankle."""

    @property
    def pressing(self) -> tuple[int, ...]:
        """Indices of the joints that give way as it presses; the last one is where it does."""

    @property
    def beyond(self) -> tuple[int, ...]:
        """Indices of the joints beyond that."""

    @property
    def ahead(self) -> Array:
        """Direction in which it ends (3,), in the frame of the last joint; zeros: never turned."""


class Seat:
    """What a person sits on a thing with: the skin of pelvis and thighs."""

    name = SEAT

    def __init__(self, body: Body) -> None:
        part = np.argmax(body.weights, axis=1)
        own = np.flatnonzero(np.isin(part, _JOINTS[SEAT]))
        self.inner: NDArray[np.int32] = own[:: max(1, len(own) // SAMPLES)].astype(np.int32)


def joints_of(name: str) -> tuple[int, ...]:
    """Indices of the joints whose skin belongs to the part of a name."""
    return _JOINTS[name]


def told(names: tuple[str, ...]) -> str:
    """Parts of one hold in words: "in the left and right hand", "with the right foot"."""
    if names == (SEAT,):
        return "under the seat"
    sides = " and ".join(name.split("_")[0] for name in names)
    return f"in the {sides} hand" if names[0].endswith("wrist") else f"with the {sides} foot"
