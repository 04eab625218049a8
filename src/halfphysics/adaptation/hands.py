"""The inner side of a hand: skin that touches what the hand holds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.body import skinning
from halfphysics.motion.skeleton import (
    JOINT_INDEX,
    JOINT_NAMES,
    LEFT_HAND_JOINTS,
    N_JOINTS,
    PARENTS,
    RIGHT_HAND_JOINTS,
)

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]
Indices = NDArray[np.int32]

SIDES = ("left", "right")
#: Joints of an arm that place its hand.
ARM = ("shoulder", "elbow", "wrist")
#: Skin whose rest normal faces down by at least this is the inner side: a T-pose's palms do.
_DOWN = 0.5
#: The palm presses with what lies between these parts of the way from the wrist to the knuckles.
_PRESSES = (0.3, 1.0)
#: Length of a palm against that of the forearm.
_HAND = 0.4
#: Skin that stands for a hand when distances are asked for, at most.
_SAMPLES = 120


@dataclass(frozen=True, eq=False)
class Hand:
    """One hand of a body, in the wrist's frame: at rest the palm faces -y.

    Attributes:
        side: "left" or "right".
        arm: Indices of shoulder, elbow and wrist.
        fingers: Indices of its 15 finger joints.
        inner: Vertices of the palm and of the inner side of the fingers.
        palm: Middle of the palm's skin, from the wrist (3,) [m].
        ahead: Direction of the fingers (3,).
    """

    side: str
    arm: tuple[int, int, int]
    fingers: tuple[int, ...]
    inner: Indices
    palm: Array
    ahead: Array

    @property
    def wrist(self) -> int:
        """Index of the wrist."""
        return self.arm[2]

    @property
    def name(self) -> str:
        """The joint that stands for it."""
        return f"{self.side}_wrist"

    @property
    def limb(self) -> tuple[int, int, int]:
        """The joints that place it: its arm."""
        return self.arm

    @property
    def beyond(self) -> tuple[int, ...]:
        """The joints beyond its wrist: its fingers."""
        return self.fingers

    @property
    def pressing(self) -> tuple[int, ...]:
        """Indices of the joints that give way as the hand presses: the collar and the arm."""
        return (int(PARENTS[self.arm[0]]), *self.arm)

    def skin(self, body: Body, fingers: Array, vertices: Indices) -> Array:
        """Skin of the hand about its wrist (n, 3) [m], in the wrist's frame.

        Args:
            body: Whose hand it is.
            fingers: Rotations of its 15 joints (15, 3).
            vertices: Which (n,).
        """
        rotations = np.zeros((1, N_JOINTS, 3))
        rotations[0, list(self.fingers)] = fingers
        rest = np.asarray(body.rest_joints)
        at, turns = skinning.kinematics(rotations, rest[:1], rest)
        posed = skinning.skin(body.skin, rotations, at, turns, indices=vertices)[0]
        result: Array = posed - rest[self.wrist]
        return result

    def flexed(self, *flexion: float) -> Array:
        """Rotations (15, 3) with the three joints of all fingers but the thumb flexed so [rad]."""
        out = np.zeros((len(self.fingers), 3))
        for row, joint in enumerate(self.fingers):
            if "thumb" not in JOINT_NAMES[joint]:
                bend = flexion[int(JOINT_NAMES[joint][-1]) - 1]
                out[row, 2] = bend if self.side == "right" else -bend
        return out

    @classmethod
    def of(cls, body: Body, side: str) -> Hand | None:
        """The `side` hand of a body; None: its skin has none."""
        shoulder, elbow, wrist = (JOINT_INDEX[f"{side}_{name}"] for name in ARM)
        fingers = LEFT_HAND_JOINTS if side == "left" else RIGHT_HAND_JOINTS
        part = np.argmax(body.weights, axis=1)
        vertices, joints = np.asarray(body.rest_vertices), np.asarray(body.rest_joints)
        down = _normals(vertices, np.asarray(body.faces))[:, 1] < -_DOWN
        inner = np.flatnonzero(down & np.isin(part, [wrist, *fingers]))
        way = joints[JOINT_INDEX[f"{side}_middle1"]] - joints[wrist]
        if not way.any():  # a model without fingers: on from the forearm, a palm's length
            way = _HAND * (joints[wrist] - joints[elbow])
        long = float(np.linalg.norm(way))
        share = (vertices - joints[wrist]) @ way / long**2
        presses = down & (part == wrist) & (share > _PRESSES[0]) & (share < _PRESSES[1])
        if not presses.any() or not len(inner):
            return None
        palm = vertices[presses].mean(axis=0) - joints[wrist]
        return cls(
            side=side,
            arm=(shoulder, elbow, wrist),
            fingers=tuple(fingers),
            inner=inner[:: max(1, len(inner) // _SAMPLES)].astype(np.int32),
            palm=palm,
            ahead=way / long,
        )


def _normals(vertices: Array, faces: NDArray[np.int32]) -> Array:
    """Unit normals of the vertices (V, 3), by the areas of their faces."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    out = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(out, faces[:, k], across)
    lengths = np.linalg.norm(out, axis=1, keepdims=True)
    result: Array = out / np.maximum(lengths, 1e-300)
    return result
