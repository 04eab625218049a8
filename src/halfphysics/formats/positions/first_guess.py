"""A first guess of all rotations from the directions of bones, frame by frame in closed form.

- Pelvis and chest have three bones each, which say their rotation: that of least squares between
  the bones' directions at rest and in the frame (Kabsch 1976), which is continuous in time. Joints
  of the spine between are on the way from one to the other.
- A bone with one bone below it turns from its parent's rotation by the smallest rotation to its
  direction. What is left, the turn about the bone, is seen in the bending plane of knee or elbow:
  the axis about which it flexes is across thigh and shank. Where a limb is straight it has no
  plane, so the angles of the frames around are averaged on the circle, weighed by the squared sine
  of the flexion, with zero as a weak prior.
- Joints with nothing known below them follow their parents.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.formats.limb_bones import BONES, HINGES
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS, PARENTS

Array = NDArray[np.float64]

#: Upper joint of a hinge -> the hinge.
_LIMBS = {hinge.upper: hinge for hinge in HINGES}
_SPINE = tuple(JOINT_INDEX[f"spine{k}"] for k in (1, 2, 3))
_PELVIS, _CHEST = 0, _SPINE[2]
#: What a straight limb's plane counts against a turn of zero: the squared sine of the flexion.
_STRAIGHT = 0.2
#: Frames over which bending planes are averaged, to both sides.
_AROUND = 5


def first_guess(places: Array, rest: Array) -> Array:
    """World rotations (T, 55, 4).

    Args:
        places: Joint positions (T, 55, 3) [m]; only the first 22 are used.
        rest: Joints of the body at rest (55, 3) [m].
    """
    world = np.zeros((len(places), N_JOINTS, 4))
    world[:, _PELVIS] = branch(places, rest, _PELVIS, (1, 2, 3))
    chest = branch(
        places, rest, _CHEST, tuple(JOINT_INDEX[j] for j in ("neck", "left_collar", "right_collar"))
    )
    for joint in range(1, N_JOINTS):
        parent = int(PARENTS[joint])
        if joint in _SPINE:
            share = np.full(len(places), (_SPINE.index(joint) + 1) / len(_SPINE))
            between = rot.slerp(world[:, _PELVIS], chest, share)
            if joint == _CHEST:
                world[:, joint] = between
            else:
                world[:, joint] = _swung(
                    places, rest, joint, _SPINE[_SPINE.index(joint) + 1], between
                )
        elif joint in BONES:
            world[:, joint] = _swung(places, rest, joint, BONES[joint], world[:, parent])
            if joint in _LIMBS:
                world[:, joint] = _twisted(places, joint, world[:, joint])
        else:
            world[:, joint] = world[:, parent]
    return world


def branch(places: Array, rest: Array, joint: int, ends: tuple[int, ...]) -> Array:
    """The rotation (T, 4) of a joint with several bones, by least squares of their directions.

    A joint on the line between two others has no turn about it from these: the vector from one to
    the other counts too.
    """
    pairs = [(joint, end) for end in ends] + [(ends[-1], ends[-2])]
    ours = np.stack([unit_of(rest[b] - rest[a]) for a, b in pairs])
    theirs = np.stack([unit_of(places[:, b] - places[:, a]) for a, b in pairs], axis=1)
    return rigid(ours, theirs)


def rigid(ours: Array, theirs: Array) -> Array:
    """The rotations (T, 4) of least squares from vectors (n, 3) to others (T, n, 3)."""
    left, _, right = np.linalg.svd(np.einsum("tki,kj->tij", theirs, ours))
    sign = np.linalg.det(left @ right)
    left[:, :, 2] *= sign[:, None]
    return rot.from_matrix(left @ right)


def _swung(places: Array, rest: Array, joint: int, end: int, base: Array) -> Array:
    """`base` (T, 4) turned the shortest way so that a bone has its direction."""
    ours = rot.rotate(base, unit_of(rest[end] - rest[joint]))
    return rot.multiply(_shortest(ours, unit_of(places[:, end] - places[:, joint])), base)


def _twisted(places: Array, upper: int, turn: Array) -> Array:
    """A rotation (T, 4) turned about its bone so that the hinge below bends about its axis."""
    hinge = _LIMBS[upper]
    bone = unit_of(places[:, hinge.joint] - places[:, upper])
    below = places[:, BONES[hinge.joint]] - places[:, hinge.joint]
    across = np.cross(bone, unit_of(below))
    now = rot.rotate(turn, hinge.axis)
    now = unit_of(now - bone * np.einsum("ti,ti->t", bone, now)[:, None])
    # |across| is the sine of the flexion, so this has its square as weight.
    cosine = np.einsum("ti,ti->t", now, across)
    sine = np.einsum("ti,ti->t", np.cross(now, across), bone)
    size = np.linalg.norm(across, axis=1)
    seen = size * (cosine + 1j * sine)
    kernel = np.hanning(2 * _AROUND + 3)[1:-1]
    around = np.convolve(seen, kernel, mode="full")[_AROUND : _AROUND + len(seen)]
    angle = np.angle(around + _STRAIGHT)
    return rot.multiply(rot.exp(angle[:, None] * bone), turn)


def unit_of(way: Array) -> Array:
    """Unit vectors (..., 3); zero stays zero."""
    return np.asarray(way / np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), 1e-12))


def _shortest(a: Array, b: Array) -> Array:
    """The shortest rotations (T, 4) between unit vectors (T, 3)."""
    dot = np.einsum("ti,ti->t", a, b)[:, None]
    half = np.concatenate([1.0 + dot, np.cross(a, b)], axis=1)
    opposite = dot[:, 0] < -1.0 + 1e-9
    if opposite.any():
        axis = np.cross(a[opposite], np.eye(3)[np.argmin(np.abs(a[opposite]), axis=1)])
        half[opposite] = np.concatenate([np.zeros((len(axis), 1)), axis], axis=1)
    return rot.normalize(half)
