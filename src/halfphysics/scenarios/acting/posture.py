"""Posture of a walker above the legs: pelvis, trunk, arms and hands as functions of the phase."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.motion import skeleton
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scenarios.acting.legs import Leg, about

if TYPE_CHECKING:
    from halfphysics.scenarios.acting.walk_plan import Walk

Array = NDArray[np.float64]

#: Amplitudes at 1.2 m/s [rad], within the ranges that gait laboratories report for adults.
PELVIS_YAW, PELVIS_LIST, LEAN = np.radians([4.5, 3.0, 3.0])
CHEST_YAW = np.radians(5.0)
ARM_SWING, ELBOW, ELBOW_SWING, PRONATION = np.radians([19.0, 18.0, 8.0, 30.0])
#: Angle of hanging arms below the horizontal, and the part of it in the collars.
ARM_DOWN, COLLAR_DOWN = np.radians([77.0, 4.0])
CURL = np.radians(18.0)
SWAY = 0.022  # [m]
USUAL = 1.2  # [m/s]


def envelope(plan: Walk, phase: Array) -> Array:
    """Amplitude of the walk, (T,): 0 standing, 1 walking, scaled with speed."""
    n = plan.steps
    on = np.clip(phase / 0.9, 0.0, 1.0) * np.clip((n - phase) / 0.9, 0.0, 1.0)
    return on * on * (3.0 - 2.0 * on) * min(plan.speed / USUAL, 1.5)


def _left_ahead(plan: Walk, phase: Array) -> Array:
    """1 with the left foot in front, -1 with the right foot in front, (T,)."""
    sign = 1.0 if plan.first == "right" else -1.0
    return sign * np.cos(np.pi * phase)


def _left_swings(plan: Walk, phase: Array) -> Array:
    """1 in the middle of a left step, -1 in the middle of a right step, (T,)."""
    sign = -1.0 if plan.first == "right" else 1.0
    return sign * np.sin(np.pi * phase)


def sway(plan: Walk, phase: Array, going: Array) -> Array:
    """Displacement of the pelvis toward the standing foot, positive to the left [m], (T,)."""
    return -SWAY * np.minimum(going, 1.0) * _left_swings(plan, phase)


def forward(leg: Leg) -> float:
    """Distance of the pelvis ahead of the ankles that puts it over the middle of the feet [m]."""
    middle = 0.35 * leg.heel[2] + 0.65 * leg.toe[2]
    rest = leg.hip[2] + leg.thigh[2] + leg.shank[2]
    return float(0.5 * (middle - rest))


def pelvis(plan: Walk, phase: Array, going: Array) -> Array:
    """Rotation of the pelvis in path coordinates (x ahead, y left, z up), (T, 3, 3)."""
    yaw = about(2, -PELVIS_YAW * going * _left_ahead(plan, phase))
    # The pelvis sinks on the side of the swinging foot.
    roll = about(0, -PELVIS_LIST * going * _left_swings(plan, phase))
    return yaw @ roll @ about(1, LEAN * going)


def _kicking(plan: Walk, phase: Array) -> Array:
    """0 away from the kick, 1 around its impact, (T,)."""
    if plan.kick is None:
        return np.zeros_like(phase)
    return np.exp(-(((phase - plan.kick.step - 0.6) / 0.33) ** 2))


def upper_body(plan: Walk, phase: Array, going: Array) -> Array:
    """Rotations (T, 55, 3) of trunk, head, arms and hands; legs and root are zero."""
    rotations = np.zeros((len(phase), skeleton.N_JOINTS, 3))
    ahead = _left_ahead(plan, phase)
    swings = _left_swings(plan, phase)
    kick = _kicking(plan, phase)

    def put(name: str, *matrices: Array) -> None:
        product = matrices[0]
        for matrix in matrices[1:]:
            product = product @ matrix
        rotations[:, JOINT_INDEX[name]] = rot.matrix_to_rotvec(product)

    # Rest frame: x left, y up, z forward. The chest turns against the pelvis, the head does not.
    yaw = (CHEST_YAW + PELVIS_YAW) * going * ahead
    roll = 0.9 * PELVIS_LIST * going * swings
    lean = np.radians(-7.0) * kick
    for name in ("spine1", "spine2", "spine3"):
        put(name, about(1, yaw / 3.0), about(2, roll / 3.0), about(0, lean / 3.0))
    nod = 0.5 * (-LEAN * going - lean)
    for name in ("neck", "head"):
        put(name, about(1, -0.5 * CHEST_YAW * going * ahead), about(0, nod))
    for side, left in (("left", 1.0), ("right", -1.0)):
        # An arm is behind while the foot of its side is in front. Forward is negative about x.
        swing = ARM_SWING * (left * ahead * going + 0.12)
        reach = np.zeros_like(phase)
        if plan.kick is not None:
            kicks = plan.swinging(plan.kick.step) == side
            reach = kick * np.radians(18.0 if kicks else -38.0)
        wide = kick * np.radians(22.0)
        down = -left * (ARM_DOWN - COLLAR_DOWN - wide)
        put(f"{side}_collar", about(2, np.full_like(phase, -left * COLLAR_DOWN)))
        put(f"{side}_shoulder", about(0, swing + reach), about(2, down))
        bend = ELBOW * (0.6 + 0.4 * np.minimum(going, 1.0))
        bend = bend - ELBOW_SWING * left * ahead * going + np.radians(12.0) * kick
        # Thumbs point forward and inward: half by the forearm, half by the wrist.
        twist = about(0, np.full_like(phase, 0.5 * PRONATION))
        put(f"{side}_elbow", about(1, -left * np.maximum(bend, 0.05)), twist)
        put(f"{side}_wrist", twist)
        curl = np.full_like(phase, -left * CURL)
        for finger in ("index", "middle", "pinky", "ring"):
            for knuckle in (1, 2, 3):
                put(f"{side}_{finger}{knuckle}", about(2, curl))
    return rotations
