"""Limbs whose hands or feet are moved: joint angles next to the recorded ones, by damped least
squares.

    minimise |J dq - e|^2 + mu^2 |W^-1/2 dq|^2,   dq = W J^T (J W J^T + mu^2)^-1 e

over the nine angles of shoulder, elbow and wrist, e the pose that the wrist still lacks (position
[m], rotation [rad]). W lets an elbow bend about its hinge rather than sideways. All frames at once,
from the recorded angles on.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import PARENTS

if TYPE_CHECKING:
    from halfphysics.adaptation.parts import Limb
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]

#: Rounds of the iteration, the most it corrects in one and its damping [m].
_ROUNDS, _STEP, _DAMPING = 20, 0.05, 0.01
#: Weight of rotations against positions [m/rad].
_ARM = 0.12
#: How willingly angles move: the elbow bends about y of its frame, twists with the forearm and is a
#: hinge else.
_WEIGHTS = np.array([1.0, 1.0, 1.0, 0.3, 1.0, 0.0, 0.6, 0.6, 0.6])


def moved(
    motion: Motion,
    body: Body,
    hand: Limb,
    frames: NDArray[np.int64],
    wrist: Array,
    turn: Array,
    willing: Array = _WEIGHTS,
) -> Array:
    """Rotations of an arm that put its hand somewhere else.

    Args:
        motion: The motion, T frames.
        body: The person's body.
        hand: Which hand, or foot.
        frames: Of which frames (n,).
        wrist: Positions of the wrist there (n, 3) [m], or of the ankle.
        turn: Rotations of the hand, world from wrist (n, 3, 3).
        willing: How willingly the nine angles change: W.

    Returns:
        Axis-angles (n, 3, 3) of shoulder, elbow and wrist. What is out of reach is approached.
    """
    positions, quaternions = (x[frames] for x in body.joint_frames(motion))
    collar = rot.to_matrix(quaternions[:, PARENTS[hand.limb[0]]])
    shoulder = positions[:, hand.limb[0]]
    rest = np.asarray(body.rest_joints)
    bones = [rest[b] - rest[a] for a, b in pairwise(hand.limb)]
    local = [rot.to_matrix(rot.exp(motion.rotations[frames][:, j])) for j in hand.limb]
    bends = [k for k in range(3) if k != int(np.abs(bones[1]).argmax())]
    for _ in range(_ROUNDS):
        turns, places = chain(collar, shoulder, local, bones)
        lacks = rot.matrix_to_rotvec(turn @ np.swapaxes(turns[2], 1, 2))
        error = np.concatenate([_capped(wrist - places[2]), _capped(_ARM * lacks)], axis=1)
        jacobian = jacobians(turns, places)
        # An elbow bends about axes of the upper arm and twists about its own, so it stays a hinge.
        for k in bends:
            axis = turns[0][:, :, k]
            moves = np.cross(axis, places[2] - places[1])
            jacobian[:, :, 3 + k] = np.concatenate([moves, axis], axis=1)
        jacobian[:, 3:] *= _ARM
        weighted = jacobian * willing
        square = weighted @ np.swapaxes(jacobian, 1, 2) + _DAMPING**2 * np.eye(6)
        step = np.einsum("nij,ni->nj", weighted, np.linalg.solve(square, error[..., None])[..., 0])
        bend = np.zeros((len(frames), 3))
        bend[:, bends], step[:, [3 + k for k in bends]] = step[:, [3 + k for k in bends]], 0.0
        local[1] = rot.rotvec_to_matrix(bend) @ local[1]
        for k in range(3):
            local[k] = local[k] @ rot.rotvec_to_matrix(step[:, 3 * k : 3 * k + 3])
    return np.stack([rot.matrix_to_rotvec(m) for m in local], axis=1)


def _capped(x: Array) -> Array:
    """Vectors (n, 3) no longer than a round may go: who is far from a target comes step by step."""
    result: Array = (
        x * np.minimum(1.0, _STEP / np.maximum(np.linalg.norm(x, axis=1), 1e-12))[:, None]
    )
    return result


def chain(
    base: Array, at: Array, local: list[Array], bones: list[Array]
) -> tuple[list[Array], list[Array]]:
    """World rotations (n, 3, 3) and positions (n, 3) of a chain of joints.

    Args:
        base: Rotation of the first joint's parent (n, 3, 3).
        at: Position of the first joint (n, 3) [m].
        local: Of every joint its rotation relative to the one before (n, 3, 3).
        bones: From every joint but the last to the next, at rest (3,) [m].
    """
    turns, places = [base @ local[0]], [at]
    for bone, turn in zip(bones, local[1:], strict=True):
        places.append(places[-1] + turns[-1] @ bone)
        turns.append(turns[-1] @ turn)
    return turns, places


def jacobians(turns: list[Array], places: list[Array], point: Array | None = None) -> Array:
    """How a point of the last body moves with the joints' own rotations (n, 6, 3 k).

    Rows: velocity of the point (None: the last joint), angular velocity, in the world.
    """
    end = places[-1] if point is None else point
    columns = []
    for turn, place in zip(turns, places, strict=True):
        arm = (end - place)[:, :, None]
        moves = np.cross(np.swapaxes(turn, 1, 2), np.swapaxes(arm, 1, 2))
        columns.append(np.concatenate([np.swapaxes(moves, 1, 2), turn], axis=1))
    return np.concatenate(columns, axis=2)
