"""The four foot measures of Kimodo, by its own rules.

Feet are joints (T, J, 3) [m], z up, in SMPL's order: left ankle 7 and toe 10, right ankle 8 and
toe 11. Speeds are of all three axes, between a frame and the next. Source of all: Kimodo (NVIDIA
2026), nv-tlabs/kimodo kimodo/metrics/foot_skate.py.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.metrics.argument_checks import Array, finite_of, positions_of
from halfphysics.metrics.foot_sliding import FEWEST, TOES

#: Left ankle, left toe, right ankle, right toe: the columns of contact labels.
FEET = (7, 10, 8, 11)
#: A toe under this is on the ground [m], and skates over this speed [m/s].
HEIGHT, SPEED = 0.05, 0.2
#: Contacts are told where a joint is lower [m] and slower [m/s] than these.
CONTACT_HEIGHT, CONTACT_SPEED = 0.10, 0.15
#: Added to counts by which is divided, as there.
EPSILON = 1e-6

Labels = NDArray[np.bool_]


def foot_skate_from_height(joints: ArrayLike, fps: float, *, ground: float = 0.0) -> float:
    """FootSkateFromHeight: mean speed [m/s] of toes that are under 5 cm when the step begins.

    Args:
        joints: Positions (T, J, 3) [m], T >= 2.
        fps: Frames per second.
        ground: Height of the ground [m].

    Raises:
        InputError: Fewer frames or joints, or numbers that are not finite.
    """
    joints = positions_of("joints", joints, frames=2, joints=FEWEST)
    down = joints[:-1, TOES, 2] - ground < HEIGHT
    return _mean(_speeds(joints[:, TOES], fps), down)


def foot_skate_ratio(joints: ArrayLike, fps: float, *, ground: float = 0.0) -> float:
    """FootSkateRatio: of the steps of a toe that is under 5 cm at both ends, the share (0 to 1)
    with a speed over 0.2 m/s.

    Args:
        joints: Positions (T, J, 3) [m], T >= 2.
        fps: Frames per second.
        ground: Height of the ground [m].

    Raises:
        InputError: Fewer frames or joints, or numbers that are not finite.
    """
    joints = positions_of("joints", joints, frames=2, joints=FEWEST)
    low = joints[:, TOES, 2] - ground < HEIGHT
    down = low[:-1] & low[1:]
    skates = down & (_speeds(joints[:, TOES], fps) > SPEED)
    return float(skates.sum() / (down.sum() + EPSILON))


def foot_skate_from_contacts(joints: ArrayLike, fps: float, contacts: ArrayLike) -> float:
    """FootSkateFromContacts: mean speed [m/s] of ankles and toes where labels say contact.

    Args:
        joints: Positions (T, J, 3) [m], T >= 2.
        fps: Frames per second.
        contacts: ArrayLike (T, 4): left ankle, left toe, right ankle, right toe.

    Raises:
        InputError: As `foot_skate_ratio`; labels of another shape, or not finite.
    """
    joints, labels = _labelled(joints, contacts)
    return _mean(_speeds(joints[:, FEET], fps), labels[:-1])


def foot_contact_consistency(
    joints: ArrayLike, fps: float, contacts: ArrayLike, *, ground: float = 0.0
) -> float:
    """FootContactConsistency: share (0 to 1) of labels that agree with `foot_contacts` of the
    motion, over the first T - 1 frames and four joints.

    Args:
        joints: Positions (T, J, 3) [m], T >= 2.
        fps: Frames per second.
        contacts: ArrayLike (T, 4), as of `foot_skate_from_contacts`.
        ground: Height of the ground [m].

    Raises:
        InputError: As `foot_skate_from_contacts`.
    """
    joints, labels = _labelled(joints, contacts)
    told = foot_contacts(joints, fps, ground=ground)
    wrong = told[:-1] != labels[:-1]
    return float(1.0 - wrong.mean())


def foot_contacts(joints: ArrayLike, fps: float, *, ground: float = 0.0) -> Labels:
    """Contact labels (T, 4) told from the motion: lower than 10 cm and slower than 0.15 m/s.

    The last frame takes the speed of the step before it.

    Raises:
        InputError: As `foot_skate_ratio`.
    """
    joints = positions_of("joints", joints, frames=2, joints=FEWEST)
    speeds = _speeds(joints[:, FEET], fps)
    slow = np.concatenate([speeds, speeds[-1:]]) < CONTACT_SPEED
    labels: Labels = slow & (joints[:, FEET, 2] - ground < CONTACT_HEIGHT)
    return labels


def _labelled(joints: ArrayLike, contacts: ArrayLike) -> tuple[Array, Labels]:
    """Joints (T, J, 3) and contact labels (T, 4), checked.

    Raises:
        InputError: As `foot_skate_ratio`; labels of another shape, or not finite.
    """
    joints = positions_of("joints", joints, frames=2, joints=FEWEST)
    labels = finite_of(
        "contacts", contacts, (len(joints), len(FEET)), "frames and feet of 'joints'"
    )
    return joints, labels != 0.0


def _speeds(points: Array, fps: float) -> Array:
    speeds: Array = fps * np.linalg.norm(np.diff(points, axis=0), axis=-1)
    return speeds


def _mean(values: Array, where: Labels) -> float:
    return float(values[where].sum() / (where.sum() + EPSILON))
