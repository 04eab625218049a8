"""SOMA: the skeleton of Kimodo, GEM-X and SOMA-X; 77 joints, or 30 without fingers and ends.

Rotations are relative to the zero pose, a T-pose in which all joint frames are parallel to the
world's: y up, z ahead, the left arm along +x. So the world rotation of a joint is the product of
the local ones down to it, and bones are offsets in the frames of their parents. Metres.

Names, order and parents: nv-tlabs/kimodo kimodo/skeleton/definitions.py; poses relative to the
T-pose: NVlabs/SOMA-X soma/body/soma.py; the mean person: Kimodo's somaskel77 (see NOTICE).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.formats.skeletons.animated_skeleton import AnimatedSkeleton

Array = NDArray[np.float64]

#: Name, parent and place in the T-pose of SOMA's mean person [mm]. "@" is a side; its places are
#: those of the left. The trunk, an arm with its hand, a leg.
_TRUNK = (
    ("Hips", "", (0, 0, 0)),
    ("Spine1", "Hips", (0, 50, -1)),
    ("Spine2", "Spine1", (0, 121, -1)),
    ("Chest", "Spine2", (0, 197, -9)),
    ("Neck1", "Chest", (0, 460, -15)),
    ("Neck2", "Neck1", (0, 537, 8)),
    ("Head", "Neck2", (0, 598, 28)),
    ("HeadEnd", "Head", (0, 759, 10)),
    ("Jaw", "Head", (0, 603, 59)),
    ("LeftEye", "Head", (32, 652, 104)),
    ("RightEye", "Head", (-32, 652, 104)),
)
_ARM = (
    ("@Shoulder", "Chest", (15, 429, 43)),
    ("@Arm", "@Shoulder", (165, 429, -13)),
    ("@ForeArm", "@Arm", (452, 429, -13)),
    ("@Hand", "@ForeArm", (723, 429, -13)),
)
#: Places of the joints of each finger: 1, 2, ... and its end. The first of all but the thumb is
#: the wrist's end of the palm's bone.
_FINGERS = {
    "Thumb": ((746, 415, 19), (786, 397, 36), (814, 397, 36), (846, 397, 36)),
    "Index": ((756, 424, 10), (819, 424, 12), (856, 424, 12), (879, 424, 12), (907, 422, 11)),
    "Middle": ((755, 431, -3), (817, 429, -13), (860, 429, -13), (890, 429, -13), (913, 426, -13)),
    "Ring": ((752, 428, -16), (811, 423, -30), (854, 423, -30), (881, 423, -30), (900, 424, -30)),
    "Pinky": ((752, 426, -29), (803, 412, -46), (834, 412, -46), (849, 412, -46), (868, 411, -46)),
}
_LEG = (
    ("@Leg", "Hips", (100, -84, 26)),
    ("@Shin", "@Leg", (100, -517, 18)),
    ("@Foot", "@Shin", (100, -938, -17)),
    ("@ToeBase", "@Foot", (100, -989, 116)),
    ("@ToeEnd", "@ToeBase", (100, -1005, 181)),
)
_SIDES = {"Left": 1.0, "Right": -1.0}
#: What the skeleton of 30 joints has not, besides fingers: of hands, it has two ends.
_LEFT_OUT = {"HeadEnd", "LeftToeEnd", "RightToeEnd"}
_KEPT_ENDS = ("ThumbEnd", "MiddleEnd")
_MIRROR = np.array([-1.0, 1.0, 1.0])


class Soma(NamedTuple):
    """A skeleton: names and parents of its joints, parents first, and the mean person's places.

    Attributes:
        names: In the order of files.
        parents: Index of the parent; -1 for the hips.
        rest: Places in the T-pose (J, 3) [m], the hips at the origin.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    rest: Array

    @property
    def offsets(self) -> Array:
        """The mean person's bones (J, 3) [m]."""
        offsets = self.rest.copy()
        offsets[1:] -= self.rest[list(self.parents[1:])]
        return offsets


def _fingers(full: bool) -> list[tuple[str, str, tuple[int, int, int]]]:
    found, ends = [], []
    for finger, places in _FINGERS.items():
        above = "@Hand"
        for number, place in enumerate(places, 1):
            last = number == len(places)
            name = f"@Hand{finger}{'End' if last else number}"
            found.append((name, above, place))
            if last and f"{finger}End" in _KEPT_ENDS:
                ends.append((name, "@Hand", place))
            above = name
    return found if full else ends


def _skeleton(full: bool) -> Soma:
    rows = list(_TRUNK)
    for limb in ((*_ARM, *_fingers(full)), _LEG):
        for side, sign in _SIDES.items():
            for name, parent, (x, y, z) in limb:
                named = (name.replace("@", side), parent.replace("@", side))
                rows.append((*named, (int(sign * x), y, z)))
    rows = [row for row in rows if full or row[0] not in _LEFT_OUT]
    index = {name: i for i, (name, _, _) in enumerate(rows)}
    return Soma(
        tuple(index),
        tuple(index.get(parent, -1) for _, parent, _ in rows),
        1e-3 * np.array([place for _, _, place in rows], dtype=np.float64),
    )


#: The skeletons by their number of joints.
SOMA = {len(soma.names): soma for soma in (_skeleton(True), _skeleton(False))}


def is_soma(names: Iterable[str]) -> bool:
    """Whether a skeleton has all 77 joints of SOMA under their own names."""
    return set(names) >= set(SOMA[max(SOMA)].names)


def world_turns(soma: Soma, local: Array) -> Array:
    """Quaternions (T, J, 4), world from joint, of local ones."""
    world = np.array(local)
    for joint, parent in enumerate(soma.parents):
        if parent >= 0:
            world[:, joint] = rot.multiply(world[:, parent], world[:, joint])
    return world


def bones_of(soma: Soma, places: Array, world: Array) -> tuple[Array, float]:
    """Bones (J, 3) of places (T, J, 3) and world rotations (T, J, 4): medians over the frames.

    Returns:
        The bones and the largest distance of a joint from where its bone ends over the frames.
    """
    parents = list(soma.parents[1:])
    steps = rot.rotate(rot.conjugate(world[:, parents]), places[:, 1:] - places[:, parents])
    offsets = np.zeros((len(soma.names), 3))
    offsets[1:] = np.median(steps, axis=0)
    return offsets, float(np.linalg.norm(steps - offsets[1:], axis=-1).max(initial=0.0))


def is_mirror_image(soma: Soma, offsets: Array) -> bool:
    """Whether bones (J, 3) are those of a mirror image: toes point away from where the body,
    whose left is on the left, is ahead of itself."""
    at = dict(zip(soma.names, _summed(soma, offsets), strict=True))
    left = at["LeftLeg"] - at["RightLeg"]
    toes = sum(at[f"{side}ToeBase"] - at[f"{side}Foot"] for side in _SIDES)
    return bool(np.cross(left, at["Head"]) @ toes < 0.0)


def mirrored(offsets: Array, places: Array, world: Array) -> tuple[Array, Array, Array]:
    """Bones, places and world rotations mirrored at x = 0."""
    return offsets * _MIRROR, places * _MIRROR, world * [1.0, 1.0, -1.0, -1.0]


def _summed(soma: Soma, offsets: Array) -> Array:
    """Places (J, 3) in the T-pose of bones (J, 3), the hips at the origin."""
    places = np.zeros_like(offsets)
    for joint, parent in enumerate(soma.parents):
        if parent >= 0:
            places[joint] = places[parent] + offsets[joint]
    return places


def places_of(soma: Soma, hips: Array, world: Array) -> Array:
    """Places (T, J, 3) of the mean person's joints for hips (T, 3) and rotations (T, J, 4)."""
    offsets = soma.offsets
    places = np.zeros((*world.shape[:2], 3))
    for joint, parent in enumerate(soma.parents):
        if parent < 0:
            places[:, joint] = hips
        else:
            step = rot.rotate(world[:, parent], offsets[joint])
            places[:, joint] = places[:, parent] + step
    return places


def animated(soma: Soma, offsets: Array, places: Array, world: Array) -> AnimatedSkeleton:
    """The skeleton in motion, as retargeting takes it."""
    return AnimatedSkeleton(
        names=soma.names,
        parents=soma.parents,
        offsets=offsets,
        ends={},
        positions=places,
        quaternions=world,
    )
