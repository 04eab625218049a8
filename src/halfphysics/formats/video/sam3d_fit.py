"""From MHR's joints and keypoints to rotations of SMPL-X, by inverse kinematics on a body.

1. One size. The estimator guesses a size for every frame; a person has one. Each frame is scaled
   about the camera to the person's median size: the picture of it stays the same.
2. A skeleton. The body has the person's own bones (medians over the frames, `positions.bones`),
   with MHR's spine at rest. A head and feet have their form from the frames, too: where nose, ears,
   eyes, heels and balls are to them, turned to lie as on the default body, with level soles.
3. Rotations that meet the joints and these points (`positions.inverse_kinematics`), fingers from
   their joints and tips.
4. The default body has the same rotations, and all places are scaled by the ratio of the legs, so
   that feet reach the same ground: its hips and spine are elsewhere, and meeting places there would
   turn it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import FileError
from halfphysics.formats.positions.bones import bones_of, facing, leg
from halfphysics.formats.positions.inverse_kinematics import Marks, Solved
from halfphysics.formats.positions.landmarks import SIDES, landmarks
from halfphysics.formats.positions.layouts import Places
from halfphysics.formats.positions.posed import BACK, UNITS, body_for, in_metres, solved_for
from halfphysics.formats.positions.similarity import turn_of
from halfphysics.formats.video.mhr_skeleton import (
    places_of_joints,
    places_of_points,
    rest_of_mhr,
    seen_landmarks,
)
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS, PARENTS

Array = NDArray[np.float64]

_FACE = ("nose", *(f"{side}_{name}" for side in SIDES for name in ("ear", "eye")))
#: Bones by which a person's size is measured: of arms and legs.
_SIZED = [
    JOINT_INDEX[f"{side}_{joint}"]
    for side in SIDES
    for joint in ("knee", "ankle", "elbow", "wrist")
]
#: Rounds in which a form is found: each turns the frames to the last mean.
_ROUNDS = 3


class Fitted(NamedTuple):
    """A person on a body with their bones.

    Attributes:
        body: That body.
        solved: Its motion, in the axes of the file.
        ratio: How much longer the legs of the default body are: the factor on places for it.
        sizes: Of every frame against the median (T,).
        said: What was put right, in words; "" for nothing.
    """

    body: Body
    solved: Solved
    ratio: float
    sizes: Array
    said: str


def fitted(where: str, joints: Array | None, points: Array | None) -> Fitted:
    """A person's body and motion.

    Args:
        where: Name in messages.
        joints: MHR's (T, 127, 3) [m] in the camera's frame, or None.
        points: MHR70's (T, 70, 3) [m], or None.

    Raises:
        FileError: These are no joints of a person.
    """
    if joints is not None:
        all = places_of_joints(joints)
    elif points is not None:
        all = places_of_points(points)
    else:
        raise FileError(
            f"{where}: neither joints nor keypoints in all frames, expected one of them"
        )
    seen = {} if points is None else seen_landmarks(points)
    sizes = _sizes(all)
    places, unit = in_metres(where, Places(all / sizes[:, None, None], True, True), "MHR")
    seen = {name: UNITS[unit] * place / sizes[:, None] for name, place in seen.items()}
    said = [] if unit == "m" else [f"unit {unit}"]
    if facing(places.all) < BACK:
        flip = np.array([-1.0, 1.0, 1.0])
        places = places._replace(all=places.all * flip)
        seen = {name: place * flip for name, place in seen.items()}
        said.append("toes point backwards: taken for a mirror image, x negated")
    bones = bones_of(places.all[:, :N_JOINTS], rest_of_mhr())
    marks = _marks(places.all, seen, bones, toes=joints is not None) if seen else None
    body, *_ = body_for(where, places, True, bones)
    rest = np.asarray(body.rest_joints)
    ratio = leg(np.asarray(Body.default().rest_joints)[None]) / leg(rest[None])
    return Fitted(body, solved_for(places, rest, marks), ratio, sizes, "; ".join(said))


def _sizes(places: Array) -> Array:
    """The size of every frame against the median (T,), by the bones of arms and legs."""
    bones = np.linalg.norm(places[:, _SIZED] - places[:, PARENTS[_SIZED]], axis=2).sum(axis=1)
    middle = float(np.median(bones))
    return np.asarray(bones / middle) if (bones > 0.0).all() else np.ones(len(bones))


def _marks(places: Array, seen: dict[str, Array], bones: Array, *, toes: bool) -> Marks:
    """Points of head and feet; the bone of each foot in `bones` becomes the one of its form."""
    joints: list[int] = []
    offsets: list[Array] = []
    where: list[Array] = []

    def add(joint: int, form: Array, names: list[str]) -> None:
        joints.extend([joint] * len(names))
        offsets.append(form)
        where.extend(seen[name] for name in names)

    head, face = JOINT_INDEX["head"], list(_FACE)
    form = _form(places[:, head], np.stack([seen[name] for name in face], axis=1))
    add(head, _laid(form, face), face)
    for side in SIDES:
        ankle, ball = JOINT_INDEX[f"{side}_ankle"], JOINT_INDEX[f"{side}_foot"]
        names = [f"{side}_{name}" for name in ("heel", "big_toe", "small_toe")]
        there = np.stack([seen[name] for name in names], axis=1)
        foot = np.stack([places[:, ankle], places[:, ball], there[:, 0]], axis=1)
        form = _form(places[:, ankle], foot, np.concatenate([foot, there[:, 1:]], axis=1))
        form = _laid(form, names, slice(2, None))
        bones[ball] = form[1]
        add(ankle, form[2:3], names[:1])
        if toes:
            add(ball, form[3:] - form[1], names[1:])
    return Marks(tuple(joints), np.concatenate(offsets), np.stack(where, axis=1))


def _form(origin: Array, rigid: Array, points: Array | None = None) -> Array:
    """Where points (T, n, 3) are from an origin (T, 3) in axes that turn along with `rigid` ones:
    means (n, 3) over the frames, in the axes of any of them."""
    points = rigid if points is None else points
    shape = rigid[len(rigid) // 2]
    for _ in range(_ROUNDS):
        back = rot.conjugate(turn_of(shape, rigid))
        shape = rot.rotate(back[:, None], rigid - origin[:, None]).mean(axis=0)
    back = rot.conjugate(turn_of(shape, rigid))
    return np.asarray(np.median(rot.rotate(back[:, None], points - origin[:, None]), axis=0))


def _laid(form: Array, names: list[str], rows: slice = slice(None)) -> Array:
    """A form turned so that its `rows` lie as the landmarks of these names on the default body."""
    ours = np.stack([landmarks()[name] for name in names])
    turn = rot.conjugate(turn_of(ours, form[None, rows]))
    return np.asarray(rot.rotate(turn, form))
