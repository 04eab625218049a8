"""The up axis by how the person stands, for data sets that do not document theirs."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.axes import axes_of
from halfphysics.base.reader_warnings import warn
from halfphysics.formats.format import Options

Array = NDArray[np.float64]
Up: TypeAlias = Literal["y", "z", "-y"]

#: The mean component of the trunk's direction along an axis, above which the person stands.
_STANDS = 0.7


def standing_axis(
    where: str, rotations: Array, options: Options, *, rule: Up, others: tuple[Up, ...], of: str
) -> Up:
    """The axis along which the trunk points on average.

    Args:
        where: Name of the file in messages.
        rotations: Axis-angle of the root, or of all joints, (T, 3) or (T, J, 3).
        options: The caller's; with `up` nothing is looked at.
        rule: The axis where the person does not stand clearly along any of them.
        others: The other axes of which copies are known.
        of: Name of the data set, for the message.

    Warns:
        HalfPhysicsWarning: The person stands along another axis than the rule says, or along none.
    """
    if not len(rotations) or options.up is not None:
        return rule
    root = rotations if rotations.ndim == 2 else rotations[:, 0]
    trunk = rot.to_matrix(rot.exp(root))[:, :, 1].mean(axis=0)
    along: dict[Up, float] = {up: float(axes_of(up)[2] @ trunk) for up in (rule, *others)}
    best = max(along, key=lambda up: along[up])
    if along[best] < _STANDS:
        warn(
            f"{where}: read with {_words(rule)}, as {of} usually is; nobody stands upright long "
            "enough to tell. up= says another axis"
        )
        return rule
    if best != rule:
        warn(f"{where}: the person stands along {best}: read with {_words(best)} (up= for another)")
    return best


def _words(up: str) -> str:
    return "y down" if up == "-y" else f"{up} up"
