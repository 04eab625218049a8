"""A body with the bones of a person: its joints are met exactly, and its skin follows.

With j_k and j'_k the joints before and after and w_vk the skin's weights, every joint k carries the
skin by an affine map, and the maps are blended as in skinning::

    v' = sum_k w_vk (M_k (v - j_k) + a_k)

M_k takes the joint's own bone to the given one: the smallest rotation, the ratio of lengths along
the bone, and g_k = sqrt(ratio * size) across it. `size` is the sum of the given bones over that of
the body's own, so a long shank is a little thicker, and a tall person evenly so.

The anchor a_k is where the skin around joint k goes: j'_k for the limbs. Models that regress
joints from the skin have hips and spine joints up to 8 cm from those of this body, in the same
flesh. There the skin keeps its form and the joint turns inside it:

- Trunk, neck and head have one similarity T, which takes pelvis to neck and shoulders to the given
  ones (one scale, Horn 1987; the rotation by Kabsch). The head stays upright. Thighs start at
  a_hip = T(j_hip).
- A hand with several given bones has the similarity that fits them.
- A foot turns about the vertical only, and its toes keep their height over the sole, so that soles
  stay flat.
- A joint without a given bone follows its parent.

The body's own bones give the body itself; its own bones times s give the body times s.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base.arrays import array_of
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, N_JOINTS, PARENTS

Array = NDArray[np.float64]

#: A given bone may be this much shorter or longer than the body's own: those of the spine are cut
#: at other places in other models, by a factor of two.
RATIOS = (0.25, 4.0)
#: Largest turn of the trunk [rad]: beyond it the bones are in another frame.
LARGEST_TURN = 1.0
#: Offsets shorter than this [m] have no direction.
_SHORT = 1e-6


def _named(*names: str) -> tuple[int, ...]:
    return tuple(JOINT_INDEX[name] for name in names)


#: Joints whose skin moves with the trunk.
_TRUNK = _named("spine1", "spine2", "spine3", "neck", "left_collar", "right_collar")
_HEAD = JOINT_INDEX["head"]
_HIPS, _ANKLES, _TOES = (
    _named(f"left_{name}", f"right_{name}") for name in ("hip", "ankle", "foot")
)
#: Joints whose bones are upper arms and forearms.
ARMS = _named("left_elbow", "right_elbow", "left_wrist", "right_wrist")
#: Where the trunk ends.
_ENDS = _named("neck", "left_shoulder", "right_shoulder")
_UP = np.array([0.0, 1.0, 0.0])
_FLAT = np.array([1.0, 0.0, 1.0])


class Maps(NamedTuple):
    """Where a change of bones takes a body.

    Attributes:
        joints: The joints at rest after it (55, 3) [m].
        linear: M_k of every joint (55, 3, 3).
        anchors: a_k of every joint (55, 3) [m].
        girths: Scale of every joint's skin across its bone (55,).
    """

    joints: Array
    linear: Array
    anchors: Array
    girths: Array


class _Bone(NamedTuple):
    """A map of a part's skin: a rotation, a stretch along a direction before it, a girth."""

    turn: Array
    girth: float
    stretch: float
    along: Array

    @property
    def linear(self) -> Array:
        along = np.outer(self.along, self.along)
        return np.asarray(self.turn @ (self.girth * (np.eye(3) - along) + self.stretch * along))


def checked_bones(bones: ArrayLike, joints: Array) -> Array:
    """Bones (55, 3) as they are used: rows of numbers, or of NaN where nothing is known.

    Args:
        bones: Offset of every joint from its parent at rest [m]; row 0 the pelvis.
        joints: Joints of the body at rest (55, 3) [m].

    Raises:
        InputError: Not (55, 3) numbers, infinite, half a row, a bone that nobody has, or a trunk
            that is not upright.
    """
    try:
        given = np.array(array_of(bones), dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"bones: not numbers ({error}), expected ({N_JOINTS}, 3)") from None
    if given.shape != (N_JOINTS, 3):
        raise InputError(
            f"bones: found shape {given.shape}, expected ({N_JOINTS}, 3): the offset of every "
            "joint from its parent at rest [m], NaN where it is not known"
        )
    known = np.isfinite(given)
    bad = np.isinf(given).any(axis=1) | (known.any(axis=1) & ~known.all(axis=1))
    if bad.any():
        joint = int(np.argmax(bad))
        raise InputError(
            f"bones: {JOINT_NAMES[joint]}: found {given[joint].tolist()}, expected three finite "
            "numbers, or three NaN where nothing is known"
        )
    offsets = _offsets(joints)
    own, lengths = np.linalg.norm(offsets, axis=1), np.linalg.norm(given, axis=1)
    for joint in range(1, N_JOINTS):
        low, high = RATIOS[0] * own[joint], RATIOS[1] * own[joint]
        if own[joint] > _SHORT and known[joint, 0] and not low <= lengths[joint] <= high:
            raise InputError(
                f"bones: {JOINT_NAMES[PARENTS[joint]]} to {JOINT_NAMES[joint]}: found "
                f"{lengths[joint]:.3g} m, expected {low:.2g} to {high:.2g} m; is it in metres?"
            )
    there = known[:, 0] & (np.arange(N_JOINTS) > 0)
    turn = _trunk(joints, offsets, given, there, _size(offsets, given, there)).turn
    angle = np.arccos(np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0))
    if angle > LARGEST_TURN:
        raise InputError(
            f"bones: found a trunk turned by {np.degrees(angle):.0f} degrees, expected one at "
            "rest: y up, z forward, x to the person's left"
        )
    return given


def proportioned(
    vertices: Array, joints: Array, weights: Array, bones: Array
) -> tuple[Array, Maps]:
    """The skin and the joints at rest of a body that has other bones.

    Args:
        vertices: Skin at rest (V, 3) [m].
        joints: Joints at rest (55, 3) [m].
        weights: Skinning weights (V, 55).
        bones: A result of `checked_bones`.

    Returns:
        The skin (V, 3) [m], and the maps, which have the joints.
    """
    maps = maps_of(joints, bones)
    moved = np.zeros_like(vertices)
    for k in range(N_JOINTS):  # each row by itself: sums do not depend on threads
        share = weights[:, k]
        rows = np.flatnonzero(share)
        at = np.einsum("ij,vj->vi", maps.linear[k], vertices[rows] - joints[k]) + maps.anchors[k]
        moved[rows] += share[rows, None] * at
    return moved, maps


def maps_of(joints: Array, bones: Array) -> Maps:
    """The maps of every part; arguments as for `proportioned`."""
    own, known = _offsets(joints), np.isfinite(bones[:, 0])
    known[0] = False
    size = _size(own, bones, known)
    trunk = _trunk(joints, own, bones, known, size)
    parts: list[_Bone] = []
    new, anchors = np.zeros((N_JOINTS, 3)), np.zeros((N_JOINTS, 3))
    new[0] = anchors[0] = bones[0] if np.isfinite(bones[0, 0]) else size * joints[0]
    for k in range(N_JOINTS):
        parent = int(PARENTS[k])
        if k:
            step = bones[k] if known[k] else parts[parent].linear @ own[k]
            anchors[k] = new[k] = new[parent] + step
        if k in (*_TRUNK, *_HIPS, _HEAD):
            anchors[k] = new[0] + trunk.linear @ (joints[k] - joints[0])
        if k == 0 or k in _TRUNK:
            parts.append(trunk)
        elif k == _HEAD:
            parts.append(trunk._replace(turn=np.eye(3)))
        elif parent == _HEAD:
            anchors[k] = anchors[parent] + parts[parent].linear @ own[k]
            parts.append(parts[parent])
        elif k in _TOES:
            anchors[k, 1] = anchors[parent, 1] + (parts[parent].linear @ own[k])[1]
            parts.append(parts[parent])
        else:
            children = [c for c in np.flatnonzero(k == PARENTS) if known[c]]
            above = parts[parent]
            follows = _Bone(above.turn, above.girth, above.girth, _UP)
            if k in _ANKLES:
                foot = _foot(own[children[0]], bones[children[0]], size) if children else None
                parts.append(foot or follows._replace(turn=np.eye(3)))
            elif len(children) == 1:
                to = new[k] + bones[children[0]] - anchors[k]
                parts.append(_single(own[children[0]], to, size))
            else:
                parts.append(_several(own[children], bones[children]) if children else follows)
    linear = np.stack([part.linear for part in parts])
    return Maps(new, linear, anchors, np.array([part.girth for part in parts]))


def _offsets(joints: Array) -> Array:
    offsets = joints - joints[np.maximum(PARENTS, 0)]
    return np.asarray(offsets)


def scaled_bones(joints: Array, size: float, arms: float = 1.0) -> Array:
    """Bones (55, 3) [m] of a body so many times as large, its arms so many times longer still.

    Args:
        joints: Of the body at rest (55, 3) [m].
        size: Factor on all bones, and on the place of the pelvis, which is row 0.
        arms: Factor on upper arms and forearms.
    """
    out = size * _offsets(joints)
    out[0] = size * joints[0]
    out[list(ARMS)] *= arms
    return out


def _size(own: Array, bones: Array, known: NDArray[np.bool_]) -> float:
    """Size of the person by that of the body."""
    if not known.any():
        return 1.0
    lengths = np.linalg.norm(own[known], axis=1).sum()
    return float(np.linalg.norm(bones[known], axis=1).sum() / lengths)


def _trunk(joints: Array, own: Array, bones: Array, known: NDArray[np.bool_], size: float) -> _Bone:
    """The map T of the trunk; what is not known below its ends is of the person's size."""
    steps = np.where(known[:, None], bones, size * own)
    before = np.stack([joints[end] - joints[0] for end in _ENDS])
    return _several(before, np.stack([steps[_chain(end)].sum(axis=0) for end in _ENDS]))


def _chain(joint: int) -> list[int]:
    """The joints from below the pelvis to one."""
    return [*_chain(int(PARENTS[joint])), joint] if joint else []


def _single(own: Array, given: Array, size: float) -> _Bone:
    """The map of a part with one bone: the smallest rotation, the ratio of lengths."""
    length, wanted = float(np.linalg.norm(own)), float(np.linalg.norm(given))
    stretch = float(np.clip(wanted / length, *RATIOS))
    return _Bone(_smallest(own, given), float(np.sqrt(stretch * size)), stretch, own / length)


def _several(own: Array, given: Array) -> _Bone:
    """The map of a part with several bones: one scale (Horn 1987, symmetric), Kabsch's rotation."""
    scale = float(np.sqrt((given**2).sum() / (own**2).sum()))
    left, values, right = np.linalg.svd(given.T @ own)
    if values[1] < 1e-9 * values[0]:  # all on one line
        turn = _smallest(own[0], given[0])
    else:
        sign = np.sign(np.linalg.det(left @ right))
        turn = (left * [1.0, 1.0, sign]) @ right
    return _Bone(turn, scale, scale, _UP)


def _foot(own: Array, given: Array, size: float) -> _Bone:
    """The map of a foot: about the vertical, longer along the foot, flat."""
    before, after = own * _FLAT, given * _FLAT
    length = float(np.linalg.norm(before))
    girth = float(np.sqrt(np.linalg.norm(given) / np.linalg.norm(own) * size))
    stretch = float(np.clip(np.linalg.norm(after) / length, 0.5 * girth, 2.0 * girth))
    return _Bone(_smallest(before, after), girth, stretch, before / length)


def _smallest(a: Array, b: Array) -> Array:
    """The smallest rotation that turns the direction of a into that of b (3, 3)."""
    lengths = float(np.linalg.norm(a)), float(np.linalg.norm(b))
    if min(lengths) < _SHORT:
        return np.eye(3)
    a, b = a / lengths[0], b / lengths[1]
    cosine = float(a @ b)
    if cosine < -1.0 + 1e-9:  # half a turn, about any axis across
        across = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
        across /= np.linalg.norm(across)
        return np.asarray(2.0 * np.outer(across, across) - np.eye(3))
    x, y, z = np.cross(a, b)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + cosine))
