"""Legs: position of a foot, its rolling over heel and toes, and inverse kinematics of the leg."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

#: World (z up, heading x) from the body's rest frame (x left, y up, z forward).
WORLD_FROM_REST = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
#: Largest extension of a leg as a fraction of its length: a straight knee snaps.
REACH = 0.995
# The sole is the skin within this height above the lowest point of a foot [m].
_SOLE = 0.008


def about(axis: int, angle: Array | float) -> Array:
    """Rotation matrices (..., 3, 3) by `angle` [rad] about coordinate axis 0, 1 or 2."""
    rotvec = np.zeros((*np.shape(angle), 3))
    rotvec[..., axis] = angle
    return rot.rotvec_to_matrix(rotvec)


@dataclass(frozen=True)
class Leg:
    """One leg of a body at rest: lengths [m] and points of the foot, rest frame.

    Attributes:
        joints: Indices of hip, knee, ankle and toe joint.
        hip: Hip joint from the pelvis joint, (3,).
        thigh: Knee from hip, (3,).
        shank: Ankle from knee, (3,).
        toe: Toe joint from ankle, (3,): the pivot when the heel rises.
        heel: Rear end of the sole from ankle, (3,): the pivot when the toes rise.
        height: Ankle above the sole [m].
    """

    joints: tuple[int, int, int, int]
    hip: Array
    thigh: Array
    shank: Array
    toe: Array
    heel: Array
    height: float

    @property
    def length(self) -> float:
        """Largest distance from hip to ankle in use [m]."""
        return REACH * float(np.linalg.norm(self.thigh) + np.linalg.norm(self.shank))


def leg_of(body: Body, side: str) -> Leg:
    """The `side` ("left" or "right") leg of a body."""
    hip, knee, ankle, toe = (JOINT_INDEX[f"{side}_{n}"] for n in ("hip", "knee", "ankle", "foot"))
    joints = np.asarray(body.rest_joints)
    part = body.main_joint
    foot = np.asarray(body.rest_vertices)[(part == ankle) | (part == toe)] - joints[ankle]
    low = foot[:, 1].min()
    sole = foot[foot[:, 1] < low + _SOLE]
    heel = np.array([0.0, low, sole[:, 2].min()])
    return Leg(
        (hip, knee, ankle, toe),
        joints[hip] - joints[0],
        joints[knee] - joints[hip],
        joints[ankle] - joints[knee],
        joints[toe] - joints[ankle],
        heel,
        float(-low),
    )


def planted(leg: Leg, mark: Array, yaw: Array | float, pitch: Array) -> Array:
    """Ankle positions (T, 3) of a foot that rolls over a fixed point of the ground at z = 0.

    Args:
        leg: The leg of the foot.
        mark: Ground point below the ankle of the flat foot, (2,) or (T, 2) [m].
        yaw: Heading of the foot [rad], () or (T,).
        pitch: (T,) [rad]; positive: toes up, pivot at the heel; negative: heel up, pivot at
            the toe joint, whose position is then fixed.
    """
    frame = about(2, np.broadcast_to(yaw, pitch.shape)) @ WORLD_FROM_REST
    pivot = np.where(pitch[:, None] > 0.0, leg.heel, leg.toe)
    flat = np.empty((len(pitch), 3))
    flat[:, :2] = mark
    flat[:, 2] = leg.height
    turned = np.einsum("tij,tj->ti", about(0, -pitch), pivot)
    result: Array = flat + np.einsum("tij,tj->ti", frame, pivot - turned)
    return result


def solve(
    leg: Leg, root: Array, hip: Array, ankle: Array, foot: Array, toe_pitch: Array
) -> dict[int, Array]:
    """Rotations of one leg for a target of its ankle and foot.

    Both bones lie in the plane of hip, ankle and the toes' direction, with the knee on the side of
    the toes; a target out of reach is approached along the line to it.

    Args:
        leg: The leg at rest.
        root: World rotation of the pelvis, (T, 3, 3).
        hip: World position of the hip joint [m], (T, 3).
        ankle: Target position of the ankle [m], (T, 3).
        foot: Target world rotation of the foot, (T, 3, 3).
        toe_pitch: Upward bend of the toes relative to the foot [rad], (T,).

    Returns:
        Joint index -> axis-angle (T, 3) in the parent's frame.
    """
    a, b = np.linalg.norm(leg.thigh), np.linalg.norm(leg.shank)
    line = ankle - hip
    distance = np.clip(np.linalg.norm(line, axis=1), abs(a - b) + 1e-6, leg.length)
    line /= np.linalg.norm(line, axis=1, keepdims=True)
    # The knee points halfway between pelvis and foot.
    pole = foot[:, :, 2] + root[:, :, 2]
    pole[:, 2] = 0.0
    # The plane of a raised leg is upright, too.
    side = np.cross(pole, line)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    front = np.cross(line, side)
    cosine = (a * a + distance**2 - b * b) / (2.0 * a * distance)
    sine = np.sqrt(np.clip(1.0 - cosine**2, 0.0, None))
    knee = (a * cosine)[:, None] * line + (a * sine)[:, None] * front
    end = distance[:, None] * line
    thigh = _bone(leg.thigh, knee, side)
    shank = _bone(leg.shank, end - knee, side)
    locals_ = (
        np.swapaxes(root, 1, 2) @ thigh,
        np.swapaxes(thigh, 1, 2) @ shank,
        np.swapaxes(shank, 1, 2) @ foot,
        about(0, -toe_pitch),
    )
    return {j: rot.matrix_to_rotvec(m) for j, m in zip(leg.joints, locals_, strict=True)}


def _bone(rest: Array, actual: Array, left: Array) -> Array:
    """Rotations (T, 3, 3) from a rest vector (3,) to `actual` (T, 3), with x toward `left`."""

    def frame(along: Array, across: Array) -> Array:
        along = along / np.linalg.norm(along, axis=-1, keepdims=True)
        across = across - np.sum(across * along, axis=-1, keepdims=True) * along
        across = across / np.linalg.norm(across, axis=-1, keepdims=True)
        return np.stack([along, across, np.cross(along, across)], axis=-1)

    return frame(actual, left) @ frame(rest, np.array([1.0, 0.0, 0.0])).T
