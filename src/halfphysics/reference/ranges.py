"""Ranges of joints in plain numpy: slow and obvious; the tests hold it equal to the native core.

A joint's rotation q is a twist about its bone, then a swing; `axes` (3, 3) are those of twist,
flexion and abduction. A row keeps one angle off one end of its range, as a contact without friction
does a gap: gap_end = gap + h rate . omega - shift >= target, counted in metres at a lever.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from halfphysics._native import tuning
from halfphysics.base import rotations as rot

Array = NDArray[np.float64]

#: Metres that a row counts for a radian.
LEVER = tuning.range_lever
_STEP = 1e-3  # of differences of fourth order [rad]: rounding and remainder are under 1e-12


def joint_angles(quat: Array, axes: Array) -> Array:
    """Twist, flexion and abduction (3,) [rad] of a rotation (4,)."""
    about = float(axes[0] @ quat[1:])
    angle = 2.0 * np.arctan2(about, quat[0])
    twist = rot.exp(angle * axes[0])
    turn = rot.log(rot.multiply(quat, rot.conjugate(twist)))  # of the swing
    size = float(np.linalg.norm(turn))
    quarter = np.tan(0.25 * size) / size * turn if size > 0.0 else 0.25 * turn
    angle = (angle + np.pi) % (2.0 * np.pi) - np.pi
    return np.array([angle, *(4.0 * np.arctan(axes[1:] @ quarter))])


def angle_rates(quat: Array, axes: Array) -> Array:
    """Rates (3, 3) of the angles by the joint's angular velocity in the child's frame."""
    out = np.zeros((3, 3))
    for k, e in enumerate(_STEP * np.eye(3)):
        for times, weight in ((1.0, 8.0), (-1.0, -8.0), (2.0, -1.0), (-2.0, 1.0)):
            out[:, k] += weight * joint_angles(rot.multiply(quat, rot.exp(times * e)), axes)
    return out / (12.0 * _STEP)


def ends(lower: Array, upper: Array, axes: Array, asked: Sequence[Array]) -> tuple[Array, Array]:
    """Ends (3,), (3,) of a joint's range [rad], widened to rotations (4,) that a motion asks."""
    angles = np.array([joint_angles(quat, axes) for quat in asked])
    return np.minimum(lower, angles.min(axis=0)), np.maximum(upper, angles.max(axis=0))


def demands(gap: Array, h: float) -> Array:
    """What rows with these gaps [rad] demand at the end of a substep of length h, in metres."""
    out: Array = LEVER * np.minimum(gap + h * tuning.range_return, 0.0)
    return out


def joined(
    contacts: Mapping[str, Array], rows: Mapping[str, Array], axes: Array, nv: int
) -> dict[str, Array]:
    """Contacts, and after them rows of joints' ranges in the form of contacts.

    Args:
        contacts: Contact points (n) of a substep, as the core found them.
        rows: Rows (m): which angle of which joint, linear at which rotation.
        axes: Of every joint in the model's order (55, 3, 3).
        nv: Number of the model's degrees of freedom.
    """
    n, m = len(contacts["dist"]), len(rows["dist"])
    out = {}
    for name, values in contacts.items():
        out[name] = np.concatenate([values, np.zeros((m, *values.shape[1:]))])
    for i, name in enumerate(("normal", "tangent", "binormal")):
        out[name][n:, i] = 1.0
    for name in ("dist", "target", "shift"):
        out[name][n:] = rows[name]
    out["impulse"][n:, 0] = rows["impulse"]
    out["bounce"][n:] = -1e300
    out["turns"] = np.zeros((n + m, nv))
    for i in range(m):
        dof, axis = int(rows["dof"][i]), int(rows["axis"][i])
        rate = angle_rates(rows["at"][i], axes[int(rows["ball"][i])])[axis]
        out["turns"][n + i, dof : dof + 3] = LEVER * rows["sign"][i] * rate
    return out
