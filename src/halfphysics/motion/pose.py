"""Pose: one frame of a motion, and the checks that poses and motions share."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base.arrays import array_of, as_array
from halfphysics.base.copying import ReadOnly
from halfphysics.base.in_notebook import InNotebook
from halfphysics.base.short_repr import numbers
from halfphysics.errors import InputError
from halfphysics.motion import skeleton

Array = NDArray[np.float64]


def frozen(array: ArrayLike) -> Array:
    copy = np.array(array_of(array), dtype=np.float64)
    copy.setflags(write=False)
    return copy


def floats(name: str, value: ArrayLike, expected: str) -> Array:
    """A float64 copy of `value`, of any shape. Raises `InputError` where it is no array of numbers.

    Args:
        name: The value's name, for the message.
        value: An array, a tensor or lists.
        expected: What the message says was expected.
    """
    try:
        return np.array(array_of(value), dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(
            f"{name}: not an array of numbers ({error}); expected {expected}"
        ) from None


def checked(
    name: str,
    value: ArrayLike,
    shape: tuple[int | None, ...],
    expected: str,
    *,
    endless: bool = False,
) -> Array:
    """Read-only float64 copy of `value`, refused unless finite and of `shape` (None: any).

    With `endless` inf is a value too: farther than anybody looked.
    """
    array = floats(name, value, expected)
    array.setflags(write=False)
    fits = array.ndim == len(shape) and all(
        want is None or have == want for have, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        raise InputError(f"{name}: found shape {array.shape}, expected {expected}")
    bad = ~np.isfinite(array) & ~(endless & np.isposinf(array))
    if bad.any():
        where = np.argwhere(bad)[0]
        raise InputError(
            f"{name}: {int(bad.sum())} values are NaN or infinite, the first at index "
            f"{tuple(int(i) for i in where)}; expected finite numbers. Cut or fill those frames"
        )
    return array


def checked_axes(axes: ArrayLike | None) -> Array:
    array = checked("axes", np.eye(3) if axes is None else axes, (3, 3), "a rotation (3, 3)")
    if not np.allclose(array @ array.T, np.eye(3), atol=1e-9) or np.linalg.det(array) < 0.0:
        raise InputError(f"axes: found {array.tolist()}, expected a rotation matrix (3, 3)")
    return array


def flat_rotations(rotations: ArrayLike, leading: int) -> ArrayLike:
    """Rotations (..., 165) as (..., 55, 3); anything else unchanged, for the check to refuse."""
    width = 3 * skeleton.N_JOINTS
    try:
        array = as_array(rotations)
    except (TypeError, ValueError):
        return rotations
    if array.ndim == leading + 1 and array.shape[-1] == width:
        return array.reshape(*array.shape[:-1], skeleton.N_JOINTS, 3)
    return array


def checked_scale(scale: ArrayLike, shape: tuple[int | None, ...], expected: str) -> Array:
    """Read-only factors on stiffness, refused unless of `shape` and at least 0."""
    array = checked("stiffness_scale", scale, shape, expected)
    if (array < 0.0).any():
        where = tuple(int(i) for i in np.argwhere(array < 0.0)[0])
        raise InputError(
            f"stiffness_scale: found {array[where]:g} at index {where}, expected numbers >= 0"
        )
    return array


@dataclass(frozen=True, eq=False)
class Pose(InNotebook, ReadOnly):
    """One frame: the position of the body and the rotations of its joints.

    Args:
        translation: Of the SMPL-X origin [m], world, shape (3,).
        rotations: Axis-angle [rad] of the 55 joints in their parents' frames (the pelvis in
            the world), shape (55, 3) or (165,).
        axes: World from file axes, shape (3, 3): the pelvis is at ``axes @ J0 + translation``.
        stiffness_scale: As of `Motion`, of the way to this frame (55,).

    Raises:
        InputError: A wrong shape, NaN or infinity, or `axes` that are no rotation.
    """

    translation: Array
    rotations: Array
    axes: Array = field(default_factory=lambda: np.eye(3), repr=False)
    stiffness_scale: Array | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        rotations = flat_rotations(self.rotations, 0)
        for name, value in (
            ("translation", checked("translation", self.translation, (3,), "(3,)")),
            ("rotations", checked("rotations", rotations, (55, 3), "(55, 3) or (165,)")),
            ("axes", checked_axes(self.axes)),
        ):
            object.__setattr__(self, name, value)
        if self.stiffness_scale is not None:
            scale = checked_scale(self.stiffness_scale, (skeleton.N_JOINTS,), "(55,)")
            object.__setattr__(self, "stiffness_scale", scale)

    def __repr__(self) -> str:
        return f"Pose({skeleton.N_JOINTS} joints, translation {numbers(self.translation)} m)"

    @classmethod
    def trusted(cls, translation: Array, rotations: Array, axes: Array) -> Pose:
        """A pose of float64 arrays of our own making: they are taken over, not checked."""
        pose = object.__new__(cls)
        object.__setattr__(pose, "stiffness_scale", None)
        for name, array in (("translation", translation), ("rotations", rotations), ("axes", axes)):
            array.setflags(write=False)
            object.__setattr__(pose, name, array)
        return pose
