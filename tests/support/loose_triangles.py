"""Loose triangles: soups in which hardly any triangle lies behind the plane of another."""

from __future__ import annotations

import numpy as np


def around_a_ball(rng, count, *, radius=0.1, near=0.003, far=None, size=8e-4, cone=None):
    """Small triangles that face a ball at the origin, near to far from it; (vertices, faces).

    `cone`: only behind it, in directions whose x is less than this.
    """
    directions = rng.normal(size=(4 * count + 400, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    if cone is not None:
        directions = directions[directions[:, 0] < cone]
    d = directions[:count]
    t = np.cross(d, [0.3, 0.5, 0.8])
    t /= np.linalg.norm(t, axis=1)[:, None]
    s = np.cross(d, t)
    away = near if far is None else rng.uniform(near, far, size=(count, 1))
    c = d * (radius + away)
    corners = [
        c + size * t,
        c - 0.5 * size * t + 0.8 * size * s,
        c - 0.5 * size * t - 0.8 * size * s,
    ]
    vertices = np.stack(corners, axis=1).reshape(-1, 3)
    return vertices, np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
