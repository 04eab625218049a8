"""Furniture of starts in penetration: boxes, in front of a body that faces +x."""

from __future__ import annotations

import numpy as np

from halfphysics.base import rotations as rot
from support.starts.solids import box, ground

#: Forms whose boxes become one mesh: none of them may lean.
STRAIGHT = ("merged", "room")


def furniture_for(kind, form, posed, rng):
    """Boxes whose front is at x = 0 and whose ground is at z = 0, in front of a body there."""
    u = rng.uniform
    y = 0.1 * rng.normal()
    if kind == "floor":
        return [ground()]
    if kind.startswith("wall"):
        lean = rot.to_matrix(rot.exp(0.15 * rng.normal(size=3) * (form not in STRAIGHT)))
        return [box("wall", (0.0, -2.0, -2.0), (0.01, 2.0, 2.0), near=1).moved(lean, (0, 0, 1.0))]
    if kind == "sofa_side":
        if rng.random() < 0.3:  # beside an armrest
            out = _sofa(rng, y)
            quarter = rot.to_matrix(rot.exp([0.0, 0.0, np.pi / 2]))
            left = min(s.centre[1] - s.half[1] for s in out)
            return [s.moved(np.eye(3), (-0.4, -left, 0.0)).moved(quarter.T, (0.0, 0.0, 0.0))
                    for s in out]  # fmt: skip
        return _sofa(rng, y)
    lying = posed.joints[0, 15, 2] < posed.joints[0, 0, 2] + 0.3
    if kind == "sofa_seat" or (kind == "root" and not lying):
        # The chair faces +x too; its back rest behind the back, its front under the thighs.
        about = np.diag([-1.0, -1.0, 1.0])
        out = [s.moved(about, (0.0, 0.0, 0.0)) for s in _sofa(rng, y)]
        deep = 2.0 * out[0].half[0]
        front = posed.joints[0, 0, 0] + u(0.2, 0.4)
        front = min(front, posed.skin[0, :, 0].min() + deep - 0.18 + u(-0.15, 0.04))
        return [s.moved(np.eye(3), (front, 0.0, 0.0)) for s in out]
    if kind == "root":
        lie = posed.joints[0, 0]
        size, top = (1.1, u(0.5, 0.8)), u(0.3, 0.5)
        z = posed.low[0, :, 2].min() - 0.3
        low = lie[:2] - size
        high = lie[:2] + size
        return [
            box("base", (*low, z - top), (*high, z - 0.2)),
            box("mattress", (*low, z - 0.2), (*high, z)),
            box("head", (low[0] - 0.06, low[1], z - top), (low[0], high[1], z + 0.4)),
        ]
    if kind == "shelf":
        return _shelf(rng, y)
    return _table(kind, posed, rng)


def _sofa(rng, y):
    u = rng.uniform
    deep, wide, seat, cushion = u(0.6, 0.9), u(1.4, 2.0), u(0.38, 0.46), u(0.12, 0.18)
    arm, back = u(0.12, 0.2), u(0.7, 0.9)
    left, right = y - 0.5 * wide, y + 0.5 * wide
    n = rng.integers(1, 4)
    edges = np.linspace(left, right, n + 1)
    out = [box("base", (0.0, left, 0.05), (deep, right, seat - cushion))]
    out += [
        box(f"cushion{i}", (0.0, edges[i], seat - cushion), (deep - 0.18, edges[i + 1], seat))
        for i in range(n)
    ]
    out.append(box("back", (deep - 0.18, left, seat - cushion), (deep, right, back)))
    out.append(box("arm0", (0.0, left - arm, 0.05), (deep, left, seat + 0.2)))
    out.append(box("arm1", (0.0, right, 0.05), (deep, right + arm, seat + 0.2)))
    return out


def _shelf(rng, y):
    u = rng.uniform
    wide, deep, tall, thick = u(0.8, 1.2), u(0.25, 0.35), u(1.8, 2.1), u(0.018, 0.03)
    left, right = y - 0.5 * wide, y + 0.5 * wide
    out = [
        box("side0", (0.0, left - thick, 0.0), (deep, left, tall)),
        box("side1", (0.0, right, 0.0), (deep, right + thick, tall)),
        box("rear", (deep - 0.01, left, 0.0), (deep, right, tall)),
    ]
    z, level = u(0.05, 0.1), 0
    while z < tall - 0.2:
        out.append(box(f"board{level}", (0.0, left, z), (deep - 0.01, right, z + thick)))
        step = u(0.25, 0.38)
        if rng.random() < 0.7:  # books
            a = left + u(0.0, 0.3 * wide)
            low = np.array([u(0.02, 0.08), a, z + thick])
            high = np.array([deep - 0.01, a + u(0.3, 0.6) * wide, z + thick + u(0.16, 0.22)])
            out.append(box(f"books{level}", low, high))
        z, level = z + step, level + 1
    return out


def _table(kind, posed, rng):
    u = rng.uniform
    top, thick, deep, wide = u(0.70, 0.78), u(0.025, 0.05), u(0.7, 0.9), u(1.2, 1.6)
    y = 0.1 * rng.normal()
    low = np.array([0.0, y - 0.5 * wide])
    high = np.array([deep, y + 0.5 * wide])
    z = 0.0
    if kind == "table_hip":  # the edge at the height of the hips
        z = posed.joints[0, 0, 2] + u(-0.12, 0.05) - top
    else:  # pushed from above: the edge in front of the body's trunk
        x = (0.1 if kind == "table_hand" else -0.05) + posed.joints[0, 0, 0] + u(0.05, 0.15)
        low[0], high[0] = x, x + deep
        hands = [20, 21] if kind == "table_hand" else [9]
        z = posed.joints[0, hands, 2].min() - 0.45 - top
    out = [box("top", (*low, z + top - thick), (*high, z + top))]
    for i, (x, yy) in enumerate(
        [(low[0] + 0.04, low[1] + 0.04), (low[0] + 0.04, high[1] - 0.1),
         (high[0] - 0.1, low[1] + 0.04), (high[0] - 0.1, high[1] - 0.1)]
    ):  # fmt: skip
        out.append(box(f"leg{i}", (x, yy, z), (x + 0.06, yy + 0.06, z + top - thick)))
    return out
