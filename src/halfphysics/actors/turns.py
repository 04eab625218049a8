"""Rotations of one joint as tuples: numpy takes ten times as long for one as for ten thousand.

Quaternions are (w, x, y, z), vectors (x, y, z). The functions of many are in
`halfphysics.base.rotations`, which the tests compare these with.
"""

from __future__ import annotations

import math
from typing import TypeAlias

Quat: TypeAlias = tuple[float, float, float, float]
Vec: TypeAlias = tuple[float, float, float]

NO_TURN: Quat = (1.0, 0.0, 0.0, 0.0)
#: World (z up, heading x) from the rest frame (x left, y up, z forward).
WORLD_FROM_REST: Quat = (0.5, 0.5, 0.5, 0.5)


def multiply(a: Quat, b: Quat) -> Quat:
    """First b, then a."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def back(q: Quat) -> Quat:
    """The inverse."""
    return (q[0], -q[1], -q[2], -q[3])


def rotate(q: Quat, v: Vec) -> Vec:
    """A vector turned by a unit quaternion."""
    w, x, y, z = q
    a, b, c = v
    tx, ty, tz = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return (
        a + w * tx + y * tz - z * ty,
        b + w * ty + z * tx - x * tz,
        c + w * tz + x * ty - y * tx,
    )


def about_x(angle: float) -> Quat:
    return (math.cos(0.5 * angle), math.sin(0.5 * angle), 0.0, 0.0)


def about_y(angle: float) -> Quat:
    return (math.cos(0.5 * angle), 0.0, math.sin(0.5 * angle), 0.0)


def about_z(angle: float) -> Quat:
    return (math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle))


def exp(v: Vec) -> Quat:
    """The rotation of an axis-angle vector [rad]."""
    angle = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    if angle < 1e-12:
        return (1.0, 0.5 * v[0], 0.5 * v[1], 0.5 * v[2])
    s = math.sin(0.5 * angle) / angle
    return (math.cos(0.5 * angle), s * v[0], s * v[1], s * v[2])


def log(q: Quat) -> Vec:
    """The axis-angle vector [rad] of the shortest arc."""
    w, x, y, z = q
    size = math.sqrt(x * x + y * y + z * z)
    if size < 1e-12:
        k = 2.0 if w >= 0.0 else -2.0
    else:
        k = 2.0 * math.atan2(size, abs(w)) / size
        if w < 0.0:
            k = -k
    return (k * x, k * y, k * z)


def slerp(a: Quat, b: Quat, share: float) -> Quat:
    """Between a (0) and b (1), along the shortest arc."""
    x, y, z = log(multiply(back(a), b))
    return multiply(a, exp((share * x, share * y, share * z)))


def unit(v: Vec) -> Vec:
    size = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    return (v[0] / size, v[1] / size, v[2] / size)


def cross(a: Vec, b: Vec) -> Vec:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a: Vec, b: Vec) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def plus(a: Vec, b: Vec, k: float = 1.0) -> Vec:
    """a + k b."""
    return (a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2])


def frame(x: Vec, y: Vec) -> Quat:
    """The rotation to a frame with x axis along `x` and the y axis nearest to `y`."""
    x = unit(x)
    y = unit(plus(y, x, -dot(x, y)))
    z = cross(x, y)
    trace = x[0] + y[1] + z[2]
    if trace > 0.0:
        s = 0.5 / math.sqrt(1.0 + trace)
        return (0.25 / s, s * (y[2] - z[1]), s * (z[0] - x[2]), s * (x[1] - y[0]))
    if x[0] >= y[1] and x[0] >= z[2]:
        s = 0.5 / math.sqrt(1.0 + x[0] - y[1] - z[2])
        return (s * (y[2] - z[1]), 0.25 / s, s * (y[0] + x[1]), s * (z[0] + x[2]))
    if y[1] >= z[2]:
        s = 0.5 / math.sqrt(1.0 + y[1] - x[0] - z[2])
        return (s * (z[0] - x[2]), s * (y[0] + x[1]), 0.25 / s, s * (z[1] + y[2]))
    s = 0.5 / math.sqrt(1.0 + z[2] - x[0] - y[1])
    return (s * (x[1] - y[0]), s * (z[0] + x[2]), s * (z[1] + y[2]), 0.25 / s)


def swing_twist(q: Quat, axes: tuple[Vec, Vec, Vec]) -> Vec:
    """Twist, flexion and abduction [rad], as `halfphysics.body.joint_ranges.swing_twist`."""
    w, x, y, z = q if q[0] >= 0.0 else (-q[0], -q[1], -q[2], -q[3])
    v = (x, y, z)
    t, f, a = dot(axes[0], v), dot(axes[1], v), dot(axes[2], v)
    n = math.hypot(w, t)
    c, s = (w / n, t / n) if n > 0.0 else (1.0, 0.0)
    k = 1.0 / (1.0 + n)
    return (
        2.0 * math.atan2(t, w),
        4.0 * math.atan(k * (c * f - s * a)),
        4.0 * math.atan(k * (c * a + s * f)),
    )


def from_swing_twist(angles: Vec, axes: tuple[Vec, Vec, Vec]) -> Quat:
    """The rotation whose `swing_twist` these are."""
    f, a = math.tan(0.25 * angles[1]), math.tan(0.25 * angles[2])
    size = math.hypot(f, a)
    k = 4.0 * math.atan(size) / size if size > 1e-12 else 4.0
    swing = exp(plus(times(axes[1], k * f), axes[2], k * a))
    return multiply(swing, exp(times(axes[0], angles[0])))


def times(v: Vec, k: float) -> Vec:
    """k v."""
    return (k * v[0], k * v[1], k * v[2])


def wrapped(angle: float) -> float:
    """The same angle in (-pi, pi]."""
    return angle - 2.0 * math.pi * math.ceil((angle - math.pi) / (2.0 * math.pi))


def heading_of(root: Quat) -> float:
    """Direction that a pelvis faces, about z [rad]: its forward axis seen from above."""
    x, y, _ = rotate(root, (0.0, 0.0, 1.0))
    return math.atan2(y, x)
