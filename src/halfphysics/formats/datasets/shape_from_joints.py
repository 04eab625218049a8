"""Whose skeleton it is: the shape of a person from joint positions that a file has beside poses."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.body.body import Body
from halfphysics.errors import FileError, InputError
from halfphysics.motion import skeleton

Array = NDArray[np.float64]

#: Coefficients that are asked for, where the model has as many: those of the data sets.
_BETAS = 16
#: Positions in single precision [m]; what a coefficient of one standard deviation weighs against.
_NOISE = 1e-5
#: Bones of the right model differ less than this from its shapes [m].
_FITS = 3e-3
_LEGS = [skeleton.JOINT_INDEX[f"{s}_{j}"] for s in ("left", "right") for j in ("knee", "ankle")]


class Bones(NamedTuple):
    """Bones that a person shows while moving.

    Attributes:
        offsets: Of every joint from its parent in the frame of the parent [m], at rest all frames
            are alike; shape (55, 3), NaN where the file has no such joint. Medians over the frames.
        spread: How far a joint of the body comes from there at most [m].
    """

    offsets: Array
    spread: float


def bones_of(positions: Array, rotations: Array) -> Bones:
    """Bones from world positions and rotations of the joints.

    Args:
        positions: (T, 55, 3) [m]; NaN where the file has no such joint.
        rotations: Axis-angle of each joint against its parent, of the root in the world,
            (T, 55, 3).
    """
    turns = rot.exp(rotations)
    for joint in range(1, skeleton.N_JOINTS):
        turns[:, joint] = rot.multiply(turns[:, skeleton.PARENTS[joint]], turns[:, joint])
    parents = skeleton.PARENTS[1:]
    steps = positions[:, 1:] - positions[:, parents]
    steps = rot.rotate(rot.conjugate(turns[:, parents]), steps)
    offsets = np.full((skeleton.N_JOINTS, 3), np.nan)
    offsets[1:] = np.median(steps, axis=0)
    body = list(skeleton.BODY_JOINTS)
    spread = np.linalg.norm(steps[:, [j - 1 for j in body]] - offsets[body], axis=-1)
    return Bones(offsets, float(spread.max()))


def bend(offsets: Array) -> float:
    """How much the fingers but the thumbs are bent at rest [rad], on average."""
    angles = []
    for joint, name in enumerate(skeleton.JOINT_NAMES):
        if name[-1] == "3" and name[:-1].endswith(("index", "middle", "ring", "pinky")):
            a, b = offsets[joint - 1], offsets[joint]
            angles.append(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))
    return float(np.mean(angles))


def shaped_like(
    where: str, bones: Bones, path: str | os.PathLike[str], gender: str | None, hands: bool
) -> Body:
    """The body of the user's model whose bones these are.

    Args:
        where: What messages call the clip.
        bones: The bones.
        path: Model file, or folder of them; of a folder the gender that fits best.
        gender: What the caller says.
        hands: Whether the bones of the hands are those at rest, too.

    Raises:
        FileError: No model file is there, or it cannot be read.

    Warns:
        HalfPhysicsWarning: No shape of the model has these bones.
    """
    from halfphysics.body.model_files import read_model
    from halfphysics.body.model_paths import genders_in

    there: tuple[str | None, ...] = (gender,)
    if gender is None and os.path.isdir(path):
        there = genders_in(Path(path)) or there  # a folder need not have all three
    spaces = [read_model(path, gender=each) for each in there]
    joints = list(skeleton.BODY_JOINTS)
    if hands:
        joints += [*skeleton.LEFT_HAND_JOINTS, *skeleton.RIGHT_HAND_JOINTS]
    fits = []
    for space in spaces:
        # SMPL has no fingers: these joints sit at their parents on every shape.
        count = min(_BETAS, space.shapedirs.shape[2])
        places = np.einsum("jv,vck->jck", space.joint_regressor, space.shapedirs[:, :, :count])
        parents = skeleton.PARENTS[joints]
        directions = (places[joints] - places[parents]).reshape(-1, count)
        mean = space.joint_regressor @ space.template
        wanted = (bones.offsets[joints] - (mean[joints] - mean[parents])).reshape(-1)
        moved = directions.any(axis=1)
        # Least squares with a prior that only settles what the bones do not say.
        left = np.vstack([directions[moved] / _NOISE, np.eye(count)])
        right = np.concatenate([wanted[moved] / _NOISE, np.zeros(count)])
        betas = np.linalg.lstsq(left, right, rcond=None)[0]
        off = float(np.abs(directions[moved] @ betas - wanted[moved]).max(initial=0.0))
        fits.append((off, space, betas))
    off, space, betas = min(fits, key=lambda fit: fit[0])
    body = Body.shaped(space, betas)
    if off > _FITS:
        warn(
            f"{where}: the bones differ by up to {1e3 * off:.0f} mm from every shape of {path} "
            f"({body.gender}). Is the person of another gender, or the file of another model?"
        )
    return body


def default_like(where: str, bones: Bones) -> Body:
    """The body that comes with the package, scaled until its legs are as long as these.

    Raises:
        FileError: Nobody has such legs.
    """
    rest = Body.default().rest_joints
    own = np.linalg.norm(rest[_LEGS] - rest[skeleton.PARENTS[_LEGS]], axis=1).sum()
    legs = np.linalg.norm(bones.offsets[_LEGS], axis=1).sum()
    try:
        return Body.default(stature=round(Body.default().stature * float(legs / own), 3))
    except InputError as error:
        raise FileError(f"{where}: joint positions: legs of {legs:.3g} m: {error}") from None
