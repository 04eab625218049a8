"""Contact of hands with things against a truth: precision, recall, F1 and C%, as CHOIS has them.

Source: CHOIS (Li et al. 2024), lijiaman/chois_release evaluation_metrics.py, `compute_metrics`;
InterAct uses the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.errors import InputError
from halfphysics.metrics.argument_checks import beside, numbers_of
from halfphysics.motion.skeleton import JOINT_INDEX

#: A hand nearer than this to a thing touches it [m].
NEAR = 0.05
#: Hands are the roots of the middle fingers, where SMPL has its joints 22 and 23.
HANDS = (JOINT_INDEX["left_middle1"], JOINT_INDEX["right_middle1"])


@dataclass(frozen=True, kw_only=True)
class ContactScores:
    """How contact of some frames agrees with the true one.

    Attributes:
        precision: Of the frames in contact, the share (0 to 1) that are truly; 0 if there are none.
        recall: Of the frames truly in contact, the share found; 0 if there are none.
        f1: Harmonic mean of the two; 0 where both are.
        percent: C%, share of all frames in contact [%].
    """

    precision: float
    recall: float
    f1: float
    percent: float


def contact_scores(contact: ArrayLike, truth: ArrayLike) -> ContactScores:
    """Precision, recall, F1 and C% of contact labels.

    With TP, FP and FN the counts of true and false positives and of false negatives: precision
    TP / (TP + FP), recall TP / (TP + FN), F1 = 2 P R / (P + R).

    Args:
        contact: Whether there is contact (T,).
        truth: Whether there truly is (T,).

    Raises:
        InputError: Labels of different lengths, not of numbers, or none.
    """
    said, true = (labels != 0.0 for labels in beside("contact", contact, truth))
    if not said.size:
        raise InputError("contact: found no labels, expected those of at least one frame")
    hits = int((said & true).sum())
    precision = hits / int(said.sum()) if said.any() else 0.0
    recall = hits / int(true.sum()) if true.any() else 0.0
    both = precision + recall
    return ContactScores(
        precision=precision,
        recall=recall,
        f1=2.0 * precision * recall / both if both else 0.0,
        percent=float(100.0 * said.mean()),
    )


def hand_contact(distance: ArrayLike, *, near: float = NEAR) -> NDArray[np.bool_]:
    """Frames (T,) in which a hand touches: either is nearer than 5 cm to a thing, or inside it.

    Args:
        distance: Signed distance (T, 2) [m] of the hands from the nearest thing.
        near: Distance [m].
    """
    near_by: NDArray[np.bool_] = np.any(numbers_of("distance", distance) < near, axis=1)
    return near_by
