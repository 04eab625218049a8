"""Body models before a shape is chosen: the content of a model file in the 55-joint layout."""

from __future__ import annotations

import dataclasses
import warnings
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base.arrays import array_of
from halfphysics.errors import HalfPhysicsWarning, InputError

Array = NDArray[np.float64]


class Source(NamedTuple):
    """A file by path and SHA-256: licensed models are referenced, never copied."""

    path: str
    sha256: str


@dataclass(frozen=True, kw_only=True, eq=False)
class ShapeSpace:
    """A template, its shape directions, and the regression of joints from vertices.

    Args:
        model: "smplx", "smplh", "smpl" or "free".
        gender: "neutral", "male", "female", or "unknown" if the file does not state it.
        template: Mean skin at rest [m], y up, z forward, shape (V, 3).
        faces: Triangles, counter-clockwise from outside, shape (F, 3), int32.
        weights: Skinning weights, rows sum to one, shape (V, 55).
        joint_regressor: Joints from vertices, shape (55, V). A joint that the file does not
            have has its parent's row and so its position.
        shapedirs: Shape directions [m per unit of beta], shape (V, 3, n), in the file's float
            type.
        posedirs: Pose blend shapes [m], shape (V, 3, 486), or None.
        hands_mean: Relaxed left and right hand, axis-angle [rad], shape (2, 45), or None.
        hands_components: Their principal components, shape (2, 45, 45), rows; or None.
        source: The file, or None for the default body.
        template_source: The file of a per-subject template, if one replaced the mean.
        given_template: Whether an array replaced the mean: no file has this person.
    """

    model: str
    gender: str
    template: Array
    faces: NDArray[np.int32]
    weights: Array
    joint_regressor: Array
    shapedirs: NDArray[np.floating]
    posedirs: Array | None = None
    hands_mean: Array | None = None
    hands_components: Array | None = None
    source: Source | None = None
    template_source: Source | None = None
    given_template: bool = False

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):  # so bodies share them and copy nothing
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                value = value.view()
                value.setflags(write=False)
                object.__setattr__(self, field.name, value)

    def betas(self, betas: ArrayLike | None, stacklevel: int = 2) -> Array:
        """Coefficients (n,) for all directions: padded with zeros, or truncated.

        Warns:
            HalfPhysicsWarning: Coefficients other than zero are dropped.

        Raises:
            InputError: Not one vector of finite numbers.
        """
        count = self.shapedirs.shape[2]
        try:
            given = np.asarray([] if betas is None else array_of(betas), dtype=np.float64)
        except (TypeError, ValueError, OverflowError) as error:
            raise InputError(f"betas: not numbers ({error}), expected a vector (n,)") from None
        if given.ndim == 2 and len(given) == 1:
            given = given[0]
        if given.ndim != 1:
            raise InputError(
                f"betas: found shape {given.shape}, expected one vector (n,): a shape that holds "
                "for the whole motion"
            )
        if not np.isfinite(given).all():
            raise InputError("betas: found NaN or infinity, expected finite numbers")
        lost = np.count_nonzero(given[count:])
        if lost:
            warnings.warn(
                f"betas: {len(given)} given, but the {self.model} model has {count} shape "
                f"directions: {lost} of the last {len(given) - count}, not zero, are unused",
                HalfPhysicsWarning,
                stacklevel=stacklevel + 1,
            )
        full = np.zeros(count)
        full[: len(given)] = given[:count]
        return full

    def shaped(self, betas: Array) -> tuple[Array, Array]:
        """Vertices (V, 3) and joints (55, 3) at rest [m] of the shape `betas` (n,)."""
        used = np.flatnonzero(betas)
        vertices = self.template.copy()
        # einsum, not a matrix product: its sums do not depend on the threads of a linear algebra
        # library.
        if len(used):
            directions = self.shapedirs[:, :, used].astype(np.float64)
            vertices += np.einsum("vcn,n->vc", directions, betas[used])
        return vertices, np.einsum("jv,vc->jc", self.joint_regressor, vertices)
