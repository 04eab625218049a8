"""Estimates the shape of a person from joint positions that a file has beside poses."""

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

#: Number of coefficients estimated, at most: that of the data sets.
_BETAS = 16
#: Noise of positions in single precision [m], weighed against one standard deviation of betas.
_NOISE = 1e-5
#: Bones differ by less than this from the shapes of the right model [m].
_FITS = 3e-3


class Bones(NamedTuple):
    """Bones estimated from a motion.

    Attributes:
        offsets: Offset of every joint in its parent's frame (55, 3) [m], medians over the frames;
            NaN if the file has no such joint. At rest all joint frames are parallel.
        spread: Largest distance of a body joint from its offset over the frames [m].
    """

    offsets: Array
    spread: float


def world_turns(rotations: Array) -> Array:
    """Quaternions (T, 55, 4) of all joints, from rotations in their parents' frames (T, 55, 3)."""
    turns = rot.exp(rotations)
    for joint in range(1, skeleton.N_JOINTS):
        turns[:, joint] = rot.multiply(turns[:, skeleton.PARENTS[joint]], turns[:, joint])
    return turns


def bones_of(positions: Array, rotations: Array) -> Bones:
    """Bones from world positions and rotations of the joints.

    Args:
        positions: Joint positions (T, 55, 3) [m]; NaN if the file has no such joint.
        rotations: Axis-angle (T, 55, 3) of each joint relative to its parent, of the root in the
            world.
    """
    turns = world_turns(rotations)
    parents = skeleton.PARENTS[1:]
    steps = positions[:, 1:] - positions[:, parents]
    steps = rot.rotate(rot.conjugate(turns[:, parents]), steps)
    offsets = np.full((skeleton.N_JOINTS, 3), np.nan)
    offsets[1:] = np.median(steps, axis=0)
    body = list(skeleton.BODY_JOINTS)
    spread = np.linalg.norm(steps[:, [j - 1 for j in body]] - offsets[body], axis=-1)
    return Bones(offsets, float(spread.max()))


def bend(offsets: Array) -> float:
    """Mean bend of the fingers without the thumbs at rest [rad]."""
    angles = []
    for joint, name in enumerate(skeleton.JOINT_NAMES):
        if name[-1] == "3" and name[:-1].endswith(("index", "middle", "ring", "pinky")):
            a, b = offsets[joint - 1], offsets[joint]
            angles.append(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))
    return float(np.mean(angles))


def shaped_like(
    where: str, bones: Bones, path: str | os.PathLike[str], gender: str | None, hands: bool
) -> Body:
    """The body of the user's model that fits the bones.

    Args:
        where: Name of the clip in messages.
        bones: The bones to fit.
        path: Model file, or a folder of them, in which the best fitting gender is chosen.
        gender: Gender in the caller's options.
        hands: Whether to fit the bones of the hands, too.

    Raises:
        FileError: The model file is missing or cannot be read.

    Warns:
        HalfPhysicsWarning: No shape of the model has these bones.
    """
    from halfphysics.body.model_files import read_model
    from halfphysics.body.model_paths import genders_in

    there: tuple[str | None, ...] = (gender,)
    if gender is None and os.path.isdir(path):
        there = genders_in(Path(path)) or there  # a folder may lack some of the three
    spaces = [read_model(path, gender=each) for each in there]
    joints = list(skeleton.BODY_JOINTS)
    if hands:
        joints += [*skeleton.LEFT_HAND_JOINTS, *skeleton.RIGHT_HAND_JOINTS]
    fits = []
    for space in spaces:
        # SMPL has no fingers: these joints are at their parents for every shape.
        count = min(_BETAS, space.shapedirs.shape[2])
        places = np.einsum("jv,vck->jck", space.joint_regressor, space.shapedirs[:, :, :count])
        parents = skeleton.PARENTS[joints]
        directions = (places[joints] - places[parents]).reshape(-1, count)
        mean = space.joint_regressor @ space.template
        wanted = (bones.offsets[joints] - (mean[joints] - mean[parents])).reshape(-1)
        moved = directions.any(axis=1)
        # Least squares with a prior that fixes only what the bones leave undetermined.
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
    """The default body with these bones.

    Raises:
        FileError: Nobody has such bones.
    """
    try:
        return Body.default(bones=bones.offsets)
    except InputError as error:
        raise FileError(f"{where}: joint positions: {error}") from None
