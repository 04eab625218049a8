"""Contact labels in the definitions and layouts of BEHAVE, OMOMO, CHOIS and ARCTIC.

They use the same distances as the labels, with the thresholds of those data sets. docs/labels.md
lists the differences.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.arrays import as_array
from halfphysics.base.validation import number, shown
from halfphysics.errors import InputError
from halfphysics.labels.tables import LEFT_FOOT, LEFT_HAND, RIGHT_FOOT, RIGHT_HAND, ContactLabels
from halfphysics.motion.skeleton import JOINT_INDEX

Array = NDArray[np.float64]

#: Contact threshold of each data set [m].
BEHAVE, OMOMO, CHOIS, ARCTIC = 0.02, 0.05, 0.05, 0.003
#: Largest distance in ARCTIC's layout [m]: well beyond its contact threshold, and quick.
FIELD = 0.02


def behave(
    labels: ContactLabels, *, person: int = 0, item: int = 0, threshold: float = BEHAVE
) -> dict[str, NDArray[Any]]:
    """Labels as in BEHAVE's contact files, all frames in one: points on the object near a person.

    Args:
        labels: Made by `contact_labels`.
        person, item: Indices of the person and the object.
        threshold: Largest distance of a contact [m].

    Returns:
        "object_points" (T, N, 3) float32, the object's vertices in the world [m]; "contact_label"
        (T, N) bool; "contact_vertices" (T, N, 3) float32, the nearest point of the skin [m], nan
        where there is no contact; "threshold_m".

    Raises:
        InputError: No such person or object, or a threshold beyond `ContactLabels.reach`.
    """
    _check(labels)
    rows = labels.object_near(threshold, person, item)
    points = _in_world(labels, item)
    label = np.zeros(points.shape[:2], dtype=bool)
    label[rows.frame, rows.vertex] = True
    nearest = np.full(points.shape, np.nan, dtype=np.float32)
    nearest[rows.frame, rows.vertex] = rows.point
    return {
        "object_points": points.astype(np.float32),
        "contact_label": label,
        "contact_vertices": nearest,
        "threshold_m": np.array(threshold),
    }


def omomo(
    labels: ContactLabels, *, person: int = 0, item: int = 0, threshold: float = OMOMO
) -> NDArray[np.bool_]:
    """Labels as in OMOMO: whether (T, 2) left and right hand are in contact with an object.

    A hand is its joint at the root of the middle finger, joints 22 and 23 of OMOMO's 24; it is in
    contact where that is at most `threshold` from the nearest of the object's vertices.

    Args:
        labels, person, item, threshold: As of `behave`.

    Raises:
        InputError: No such person or object.
    """
    from scipy.spatial import cKDTree

    _check(labels)
    labels.check(person, item)
    owner = labels.result.people[person]
    hands = [JOINT_INDEX["left_middle1"], JOINT_INDEX["right_middle1"]]
    joints = owner.body.joints(owner.motion)[:, hands]
    position, turn = _frames(labels, item)
    local = np.einsum("tij,thi->thj", turn, joints - position[:, None])
    within = number(threshold, "threshold", least=0.0, unit="m")
    distance, _ = cKDTree(labels.objects[item].vertices).query(local)
    return np.asarray(distance <= within)


def chois(
    labels: ContactLabels, *, person: int = 0, item: int = 0, threshold: float = CHOIS
) -> NDArray[np.float32]:
    """Labels as in CHOIS (contact_labels_w_semantics): (T, 4) of 0 and 1, hands and feet.

    The order is left hand, right hand, left foot, right foot, each a part of the skin.

    Args:
        labels, person, item, threshold: As of `behave`.

    Raises:
        InputError: No such person or object, or a threshold beyond `ContactLabels.reach`.
    """
    _check(labels)
    rows = labels.skin_near(threshold, person, item)
    part = labels.people[person].vertex_part[rows.vertex]
    found = np.zeros((len(labels), 4), dtype=np.float32)
    for column, parts in enumerate((LEFT_HAND, RIGHT_HAND, LEFT_FOOT, RIGHT_FOOT)):
        found[rows.frame[np.isin(part, parts)], column] = 1.0
    return found


def arctic(
    labels: ContactLabels,
    *,
    person: int = 0,
    item: int = 0,
    threshold: float = ARCTIC,
    most: float = FIELD,
    hands: Mapping[str, ArrayLike] | None = None,
) -> dict[str, NDArray[Any]]:
    """Labels as in ARCTIC (interaction field): distances of each hand and the object, and contact.

    Args:
        labels, person, item, threshold: As of `behave`.
        most: Largest distance [m]; larger ones are set to it.
        hands: "left" and "right": vertices of the skin in the order of the hand model, such as
            SMPL-X's MANO correspondence; None: the vertices of wrist and fingers, ascending.

    Returns:
        Of r, the right hand, l, the left, and o, the object: "dist.ro", "dist.lo" (T, Vh) from
        every vertex of a hand to the object and "dist.or", "dist.ol" (T, Vo) back [m], float32,
        at most `most`; "contact.ro" and so on, 1 where that is under `threshold`;
        "vertices.r", "vertices.l" (Vh,), which vertices of the skin those are; "threshold_m".

    Raises:
        InputError: No such person or object, vertices that the skin does not have, a threshold
            beyond `most`, or that beyond `ContactLabels.reach`.
    """
    _check(labels)
    most = number(most, "most", least=0.0, unit="m")
    threshold = number(threshold, "threshold", least=0.0, most=most, unit="m")
    surface = labels.object_near(most, person, item)
    skin = labels.skin_near(most, person, item)
    part = labels.people[person].vertex_part
    found: dict[str, NDArray[Any]] = {"threshold_m": np.array(threshold)}
    for letter, side, parts in (("r", "right", RIGHT_HAND), ("l", "left", LEFT_HAND)):
        vertices = np.flatnonzero(np.isin(part, parts))
        if hands is not None:
            vertices = _hand(hands, side, len(part))
        to = np.full((len(labels), len(part)), most)
        to[skin.frame, skin.vertex] = skin.distance
        back = np.full((len(labels), len(labels.objects[item].vertices)), most)
        mine = np.isin(part[surface.nearest], parts)
        back[surface.frame[mine], surface.vertex[mine]] = surface.distance[mine]
        for key, distance in ((f"{letter}o", to[:, vertices]), (f"o{letter}", back)):
            found[f"dist.{key}"] = distance.astype(np.float32)
            found[f"contact.{key}"] = (distance < threshold).astype(np.int64)
        found[f"vertices.{letter}"] = vertices
    return found


def _check(labels: object) -> None:
    if not isinstance(labels, ContactLabels):
        raise InputError(f"labels: found {shown(labels)}, expected those of contact_labels(result)")


def _hand(hands: Mapping[str, ArrayLike], side: str, count: int) -> NDArray[np.intp]:
    if not isinstance(hands, Mapping) or side not in hands:
        found = shown(sorted(map(str, hands)) if isinstance(hands, Mapping) else hands)
        raise InputError(f"hands: found {found}, expected 'left' and 'right'")
    try:
        vertices = as_array(hands[side])
    except (TypeError, ValueError):
        raise InputError(
            f"hands: {side}: found {shown(hands[side])}, expected vertices (n,)"
        ) from None
    ok = vertices.ndim == 1 and vertices.dtype.kind in "iu" and len(vertices) > 0
    if not ok or vertices.min() < 0 or vertices.max() >= count:
        raise InputError(
            f"hands: {side}: found {vertices.dtype} of shape {vertices.shape}, expected vertices "
            f"(n,) from 0 to {count - 1}"
        )
    return vertices.astype(np.intp)


def _frames(labels: ContactLabels, item: int) -> tuple[Array, Array]:
    """Position (T, 3) [m] and turn (T, 3, 3) of an object's frame in the world."""
    track = labels.result.objects[labels.objects[item].name]
    return track.position, rot.to_matrix(rot.normalize(track.quaternion))


def _in_world(labels: ContactLabels, item: int) -> Array:
    position, turn = _frames(labels, item)
    vertices = labels.objects[item].vertices
    result: Array = np.einsum("tij,vj->tvi", turn, vertices) + position[:, None]
    return result
