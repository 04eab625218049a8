"""Retargeting of a human skeleton to SMPL-X: keeps bone directions, uses the body's lengths."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.formats.skeletons.animated_skeleton import AnimatedSkeleton
from halfphysics.formats.skeletons.rest_alignment import RestAlignment
from halfphysics.formats.skeletons.source_skeleton import SourceSkeleton
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, N_JOINTS, PARENTS

Array = NDArray[np.float64]

_SPINE = tuple(JOINT_INDEX[f"spine{k}"] for k in (1, 2, 3))
_NOT_TURNED = (1.0, 0.0, 0.0, 0.0)
_SIDES = ("left", "right")
# Units by the length of a leg from hip to ankle [unit of the file].
_LEGS = {"m": (0.35, 1.3), "cm": (35.0, 130.0), "mm": (350.0, 1300.0)}


@dataclass(frozen=True, eq=False, kw_only=True)
class Retargeted:
    """A clip on the SMPL-X skeleton, in the file's axes.

    Attributes:
        pelvis: Positions of the pelvis joint (T, 3) [m].
        rotations: Axis-angle (T, 55, 3).
        up: The file's up axis by the body's posture, "y" or "z".
        scale: Metres of the target per unit of the file.
        matched: SMPL-X joints found in the file, with the spine joints if it has a spine.
        unmatched: Names of the file's joints without a matching SMPL-X joint.
        unit: The file's likely unit, for messages.
    """

    pelvis: Array
    rotations: Array
    up: Literal["y", "z"]
    scale: float
    matched: tuple[int, ...]
    unmatched: tuple[str, ...]
    unit: str


def retarget(where: str, skeleton: AnimatedSkeleton, rest: Array) -> Retargeted:
    """Retarget a skeleton in motion to a body with joints `rest` (55, 3) [m].

    The midpoint of the hips follows the source's, scaled by the ratio of leg lengths, so that the
    feet reach the floor as the source's do. Joints without a match stay at rest.

    Raises:
        FileError: The skeleton is not a person's.
    """
    source = SourceSkeleton.of(where, skeleton)
    positions, quaternions = skeleton.positions, skeleton.quaternions
    alignment = RestAlignment(source, rest, quaternions)
    world = np.empty((len(positions), N_JOINTS, 4))
    world[:, 0] = rot.multiply(quaternions[:, source.joints[0]], alignment.turn(0))
    world[:, _SPINE] = _spine(source, alignment, quaternions)
    for joint in range(1, N_JOINTS):
        if joint in source.joints and joint not in _SPINE:
            own = quaternions[:, source.joints[joint]]
            world[:, joint] = rot.multiply(own, alignment.turn(joint))
        elif joint not in _SPINE:
            world[:, joint] = world[:, PARENTS[joint]]
    local = world.copy()
    local[:, 1:] = rot.multiply(rot.conjugate(world[:, PARENTS[1:]]), world[:, 1:])
    matched = {*source.joints, *(_SPINE if source.spine else ())}
    local[:, [joint for joint in range(N_JOINTS) if joint not in matched]] = _NOT_TURNED
    scale = _leg(rest) / source.leg
    hips = [JOINT_INDEX[f"{side}_hip"] for side in _SIDES]
    middle = scale * positions[:, [source.joints[hip] for hip in hips]].mean(axis=1)
    below = rest[hips].mean(axis=0) - rest[0]
    return Retargeted(
        pelvis=middle - rot.rotate(world[:, 0], below),
        rotations=rot.log(local),
        up=up_axis(world[:, 0]),
        scale=scale,
        matched=tuple(sorted(matched)),
        unmatched=tuple(
            name
            for joint, name in enumerate(skeleton.names)
            if joint not in source.joints.values() and joint not in source.spine
        ),
        unit=next(
            (unit for unit, (low, high) in _LEGS.items() if low < source.leg < high),
            f"{100.0 * scale:.3g} cm",
        ),
    )


def _spine(source: SourceSkeleton, alignment: RestAlignment, quaternions: Array) -> Array:
    """World rotations (T, 3, 4) of spine1, spine2, spine3.

    The source's chain from pelvis to chest is divided into three equal parts, with slerp between
    two of its joints. So spine3 always equals the source's chest, and a chain of three joints is
    copied.
    """
    chain = [(source.joints[0], alignment.turn(0))]
    # Without a zero pose, the twist of the joints between is unknown.
    between = source.spine if alignment.is_pose else source.spine[-1:]
    chain += [(joint, alignment.turn(_SPINE[0])) for joint in between]
    world = [rot.multiply(quaternions[:, joint], turn) for joint, turn in chain]
    out = []
    for k in (1, 2, 3):
        place = k * (len(chain) - 1) / 3
        low = int(place)
        if place == low:
            out.append(world[low])
        else:
            t = np.full(len(world[low]), place - low)
            out.append(rot.slerp(world[low], world[low + 1], t))
    return np.stack(out, axis=1)


def _leg(rest: Array) -> float:
    lengths = [
        np.linalg.norm(rest[JOINT_INDEX[f"{side}_{a}"]] - rest[JOINT_INDEX[f"{side}_{b}"]])
        for side in _SIDES
        for a, b in (("hip", "knee"), ("knee", "ankle"))
    ]
    return float(sum(lengths)) / 2.0


def up_axis(pelvis: Array) -> Literal["y", "z"]:
    """The axis along which the trunk of a pelvis (T, 4) points on average; y if it lies or both
    fit."""
    trunk = rot.rotate(pelvis, np.array([0.0, 1.0, 0.0])).mean(axis=0)
    return "z" if trunk[2] > 0.7 and abs(trunk[1]) < 0.5 else "y"


def names_of(joints: tuple[int, ...]) -> str:
    """Names of SMPL-X joints that are not among `joints`, fingers in one phrase, no face."""
    missing = [j for j in range(N_JOINTS) if j not in joints]
    body = [JOINT_NAMES[j] for j in missing if j < 22]
    fingers = sum(j >= 25 for j in missing)
    if fingers:
        body.append("all fingers" if fingers == 30 else f"{fingers} of 30 finger joints")
    return ", ".join(body)
