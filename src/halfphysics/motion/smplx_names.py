"""The parameter names of the `smplx` package, to and from a `Motion`."""

from __future__ import annotations

import warnings
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.arrays import as_array
from halfphysics.base.axes import turned
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.motion import skeleton
from halfphysics.motion.motion import Motion
from halfphysics.motion.pose import floats

Array = NDArray[np.float64]

#: smplx name -> indices into `JOINT_NAMES`.
PARTS: Mapping[str, tuple[int, ...]] = {
    "global_orient": (0,),
    "body_pose": skeleton.BODY_JOINTS,
    "jaw_pose": (22,),
    "leye_pose": (23,),
    "reye_pose": (24,),
    "left_hand_pose": skeleton.LEFT_HAND_JOINTS,
    "right_hand_pose": skeleton.RIGHT_HAND_JOINTS,
}
_SMPL_BODY = 23


def one_shape(name: str, betas: ArrayLike, frames: int) -> Array | None:
    """Betas (n,) of (n,), (1, n) or (frames, n) with equal rows; None of an empty array.

    Raises:
        InputError: Rows differ, or the shape fits none of these.
    """
    array = floats(name, betas, "(n,), (1, n) or (T, n)")
    if array.size == 0:
        return None
    rows = array.reshape(-1, array.shape[-1]) if array.ndim else array.reshape(1, 1)
    if len(rows) not in (1, frames):
        raise InputError(f"{name}: found shape {array.shape}, expected (n,), (1, n) or (T, n)")
    varying = np.abs(rows - rows[0]).max()
    if varying > 0.0:
        raise InputError(
            f"{name}: the shape changes over the frames (by up to {varying:.3g}), expected one "
            "shape per person. Take one row, for example the median over the frames"
        )
    result: Array | None = rows[0]
    return result


def _joints_in(name: str, array: Array) -> int:
    """Of how many joints rotations are: as many as the part has, or SMPL's 23 of a body."""
    of_smpl = (
        array.shape[-1:] == (3 * _SMPL_BODY,)
        or array.shape[-2:] == (_SMPL_BODY, 3)
        or array.shape[1:] == (_SMPL_BODY, 3, 3)
    )
    return _SMPL_BODY if name == "body_pose" and of_smpl else len(PARTS[name])


def _axis_angle(name: str, array: Array, joints: int, frames: int) -> Array:
    """Rotations (T, J, 3) of axis-angle (..., 3 J) or (..., J, 3), or matrices (T, J, 3, 3), of one
    joint also (T, 3, 3)."""
    if array.ndim == 4 and array.shape[1] == joints and array.shape[2:] == (3, 3):
        return rot.matrix_to_rotvec(array)
    if joints == 1 and (
        array.shape == (frames, 3, 3)  # of axis-angle it would be too many frames
        or (array.shape == (1, 3, 3) and np.allclose(array[0] @ array[0].T, np.eye(3), atol=1e-4))
    ):
        return rot.matrix_to_rotvec(array[:, None])
    if array.shape[-1:] == (3 * joints,) or array.shape[-2:] == (joints, 3):
        return array.reshape(-1, joints, 3)
    way_out = ""
    if name.endswith("hand_pose") and array.ndim and array.shape[-1] < 3 * joints:
        way_out = (
            "; these look like PCA coefficients: create the smplx model with use_pca=False, or "
            "multiply by its hand components first"
        )
    raise InputError(f"{name}: found shape {array.shape}, expected (T, {3 * joints}){way_out}")


def read_parameters(
    *,
    rotations: Mapping[str, ArrayLike | None],
    transl: ArrayLike,
    fps: float,
    betas: ArrayLike | None,
    expression: ArrayLike | None,
    gender: str,
    model: str,
    axes: Array,
    hands_mean: ArrayLike | None,
) -> Motion:
    """The work behind `Motion.from_smplx`; see there."""
    translation = floats("transl", transl, "(T, 3)")
    if translation.shape[-1:] != (3,):
        raise InputError(f"transl: found shape {translation.shape}, expected (T, 3)")
    translation = translation.reshape(-1, 3)
    frames = len(translation)
    full = np.zeros((frames, skeleton.N_JOINTS, 3))
    for name, value in rotations.items():
        if value is None:
            continue
        joints = PARTS[name]
        array = floats(name, value, f"(T, {3 * len(joints)})")
        part = _axis_angle(name, array, _joints_in(name, array), frames)[:, : len(joints)]
        if len(part) not in (1, frames):
            matrices = len(joints) == 1 and array.shape[-2:] == (3, 3)
            raise InputError(
                f"{name}: found {len(part)} frames, expected {frames} as in transl (or one)"
                + (". Matrices have the shape (T, 3, 3)" if matrices else "")
            )
        full[:, list(joints)] = part
    if hands_mean is not None:
        mean = floats("hands_mean", hands_mean, "(90,)")
        if mean.size != 90:
            raise InputError(f"hands_mean: found shape {mean.shape}, expected (90,)")
        full[:, list(skeleton.LEFT_HAND_JOINTS + skeleton.RIGHT_HAND_JOINTS)] += mean.reshape(30, 3)
    if expression is not None and np.any(as_array(expression)):
        warnings.warn(
            "expression: ignored, the face is not simulated; keep it beside the result",
            HalfPhysicsWarning,
            stacklevel=3,
        )
    shape = None if betas is None else one_shape("betas", betas, frames)
    if not np.array_equal(axes, np.eye(3)):
        translation, full = turned(translation, full, axes)
    return Motion(translation, full, fps, betas=shape, gender=gender, model=model, axes=axes)


def write_parameters(motion: Motion) -> dict[str, Array]:
    """The work behind `Motion.to_smplx`; see there."""
    translation, rotations = motion.in_file_axes()
    frames = len(motion)
    out = {name: rotations[:, list(joints)].reshape(frames, -1) for name, joints in PARTS.items()}
    out["transl"] = translation
    if motion.betas is not None:
        out["betas"] = motion.betas[None].copy()
    return out
