"""People who hold still in balance: postures with the centre of mass over what they stand on."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX
from support.people import FACING_X

#: Arms hanging, from the T-pose: turns about the axes of the rest frame (left, up, ahead) [rad].
ARMS_DOWN = {"left_shoulder": (0.0, 0.0, -1.3), "right_shoulder": (0.0, 0.0, 1.3)}


def still(
    body: hp.Body,
    turns: Mapping[str, tuple[float, float, float]],
    root: tuple[float, float, float] = (0.0, 0.0, 0.0),
    *,
    frames: int = 20,
    fps: float = 60.0,
) -> hp.Motion:
    """Facing x, the lowest vertex at z = 0; turns of joints, and of the root after it faces x."""
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = rot.log(rot.multiply(rot.exp(FACING_X), rot.exp(root)))
    for name, turn in turns.items():
        rotations[:, JOINT_INDEX[name]] = turn
    motion = hp.Motion(np.zeros((frames, 3)), rotations, fps)
    lowest = body.vertices(motion[0])[:, 2].min()
    return hp.Motion(np.tile([0.0, 0.0, -lowest], (frames, 1)), rotations, fps)


def raised(motion: hp.Motion, height: float) -> hp.Motion:
    """The motion, so much higher [m]."""
    up = np.array([0.0, 0.0, height])
    return hp.Motion(motion.translation + up, motion.rotations, motion.fps)


def centre_of_mass(body: hp.Body, motion: hp.Motion) -> np.ndarray:
    """Centre of mass (3,) [m] in the first frame."""
    x, q = body.joint_frames(motion[0])
    mass = np.array([part.mass for part in body.variant.parts])
    com = np.array([part.com for part in body.variant.parts])
    return (mass[:, None] * (x + rot.rotate(q, com))).sum(axis=0) / mass.sum()


def balanced(body: hp.Body, posture, low: float, high: float, axis: int = 0, over=None):
    """The still posture(angle) whose centre of mass is over the middle of joints, by bisection.

    `over`: joints; None: ankles and balls of both feet.
    """
    names = over or ("left_ankle", "right_ankle", "left_foot", "right_foot")
    joints = [JOINT_INDEX[name] for name in names]

    def ahead(angle: float) -> float:
        motion = posture(angle)
        middle = body.joints(motion[0])[joints].mean(axis=0)
        return float((centre_of_mass(body, motion) - middle)[axis])

    sign = np.sign(ahead(high) - ahead(low))
    assert ahead(low) * ahead(high) < 0.0, "balance is not between the two angles"
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if sign * ahead(middle) > 0.0 else (middle, high)
    return posture(0.5 * (low + high))


def standing(body: hp.Body, arms=ARMS_DOWN, **options) -> hp.Motion:
    """Upright on flat feet; the ankles lean until it balances."""

    def posture(lean: float) -> hp.Motion:
        ankles = {"left_ankle": (-lean, 0.0, 0.0), "right_ankle": (-lean, 0.0, 0.0)}
        return still(body, {**arms, **ankles}, (lean, 0.0, 0.0), **options)

    return balanced(body, posture, -0.25, 0.25)


def squat(body: hp.Body, knee: float = 1.7, ankle: float = -0.5, **options) -> hp.Motion:
    """Knees bent, feet flat; the trunk leans until it balances."""

    def posture(trunk: float) -> hp.Motion:
        hip = -(trunk + knee + ankle)
        turns = {
            f"{side}_{joint}": (angle, 0.0, 0.0)
            for side in ("left", "right")
            for joint, angle in (("hip", hip), ("knee", knee), ("ankle", ankle))
        }
        return still(body, {**ARMS_DOWN, **turns}, (trunk, 0.0, 0.0), **options)

    return balanced(body, posture, -0.5, 1.5)


def one_leg(body: hp.Body, **options) -> hp.Motion:
    """On the left leg, upright, the right knee lifted; rolled until it balances."""
    lifted = {"right_hip": (-0.8, 0.0, 0.0), "right_knee": (1.4, 0.0, 0.0)}
    feet = ("left_ankle", "left_foot")

    def leaned(lean: float, roll: float) -> hp.Motion:
        back = rot.log(rot.conjugate(rot.multiply(rot.exp([lean, 0, 0]), rot.exp([0, 0, roll]))))
        root = rot.log(rot.multiply(rot.exp([lean, 0, 0]), rot.exp([0, 0, roll])))
        return still(
            body, {**ARMS_DOWN, **lifted, "left_ankle": tuple(back)}, tuple(root), **options
        )

    def posture(roll: float) -> hp.Motion:
        return balanced(body, lambda lean: leaned(lean, roll), -0.3, 0.3, over=feet)

    return balanced(body, posture, -0.3, 0.3, axis=1, over=feet)


def sitting(body: hp.Body, **options) -> tuple[hp.Motion, float]:
    """Thighs level, shanks and trunk upright; and the height of the seat [m]."""
    turns = {
        f"{side}_{joint}": (angle, 0.0, 0.0)
        for side in ("left", "right")
        for joint, angle in (("hip", -0.5 * np.pi), ("knee", 0.5 * np.pi))
    }
    motion = still(body, {**ARMS_DOWN, **turns}, **options)
    thigh = np.isin(body.weights.argmax(axis=1), [0, 1, 2])
    return motion, float(body.vertices(motion[0])[thigh, 2].min())


def lying(body: hp.Body, **options) -> hp.Motion:
    """On the back, arms spread."""
    return still(body, {}, (-0.5 * np.pi, 0.0, 0.0), **options)


def leaning(body: hp.Body, lean: float = 0.3, **options) -> tuple[hp.Motion, float]:
    """Leaning forward with both arms stretched ahead; and the place of the hands along x [m]."""
    back = (-lean, 0.0, 0.0)
    arms = {"left_shoulder": (0.0, -1.4, 0.0), "right_shoulder": (0.0, 1.4, 0.0)}
    motion = still(
        body, {**arms, "left_ankle": back, "right_ankle": back}, (lean, 0.0, 0.0), **options
    )
    return motion, float(body.vertices(motion[0])[:, 0].max())
