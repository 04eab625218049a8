"""A wooden chair as a scanner gives it: one closed surface, finely cut, rough.

The chair is a signed distance field (rounded boxes and capsules, joined smoothly) whose zero level
is cut into quads by surface nets: one corner in every cell of a grid that the surface crosses.
"""

from __future__ import annotations

import numpy as np


def _capsule(p, a, b, radius):
    a, b = np.asarray(a, float), np.asarray(b, float)
    along = np.clip(((p - a) @ (b - a)) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(p - a - along[..., None] * (b - a), axis=-1) - radius


def _slab(p, middle, size, round_):
    q = np.abs(p - np.asarray(middle, float)) - 0.5 * np.asarray(size, float) + round_
    return np.linalg.norm(np.maximum(q, 0.0), axis=-1) + np.minimum(q.max(axis=-1), 0.0) - round_


def distance(p):
    """Signed distance [m], negative in the wood, of points (..., 3): z up, the seat at 0.45 m."""
    parts = [_slab(p, (0.0, 0.0, 0.44), (0.44, 0.44, 0.035), 0.012)]
    for x in (-0.19, 0.19):
        parts.append(_capsule(p, (x, 0.19, 0.02), (x, 0.19, 0.44), 0.018))
        parts.append(_capsule(p, (x, -0.19, 0.02), (x, -0.17, 0.45), 0.018))
        parts.append(_capsule(p, (x, -0.18, 0.45), (x, -0.26, 0.92), 0.016))
        parts.append(_capsule(p, (x, -0.18, 0.2), (x, 0.19, 0.2), 0.011))
    for z, y in ((0.15, 0.19), (0.25, -0.18)):
        parts.append(_capsule(p, (-0.19, y, z), (0.19, y, z), 0.011))
    for z in (0.9, 0.66):
        y = -0.18 - 0.08 * (z - 0.45) / 0.47
        parts.append(_slab(p, (0.0, y, z), (0.38, 0.022, 0.06), 0.008))
    for x in np.linspace(-0.12, 0.12, 4):
        parts.append(_capsule(p, (x, -0.216, 0.66), (x, -0.257, 0.9), 0.008))
    near = np.stack(parts)
    return -0.004 * np.log(np.exp(-near / 0.004).sum(axis=0))


def surface(field, low, high, cell):
    """Vertices (V, 3) and triangles (F, 3), outward, of the zero level of a signed distance."""
    axes = [np.arange(l, h + cell, cell) for l, h in zip(low, high, strict=True)]
    count = tuple(len(a) for a in axes)
    value = np.empty(count)
    for i, x in enumerate(axes[0]):  # a sheet at a time: the grid has millions of points
        value[i] = field(np.stack(np.meshgrid([x], axes[1], axes[2], indexing="ij"), -1))[0]
    inside = value < 0.0
    cells = tuple(n - 1 for n in count)
    total, hits = np.zeros((*cells, 3)), np.zeros(cells, np.int16)
    offsets = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])

    def corner(array, offset):
        return array[tuple(slice(o, o + n) for o, n in zip(offset, cells, strict=True))]

    for axis in range(3):
        step = np.eye(3, dtype=int)[axis]
        for offset in offsets[offsets[:, axis] == 0]:
            a, b = corner(value, offset), corner(value, offset + step)
            cross = (a < 0.0) != (b < 0.0)
            share = a[cross] / (a[cross] - b[cross])
            total[cross] += offset + share[:, None] * step
            hits[cross] += 1
    used = hits > 0
    index = np.full(cells, -1)
    index[used] = np.arange(np.count_nonzero(used))
    origin = np.array([a[0] for a in axes])
    vertices = origin + cell * (np.argwhere(used) + total[used] / hits[used][:, None])
    faces = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        step = np.eye(3, dtype=int)
        a = inside[tuple(slice(None, -1) if k == axis else slice(1, -1) for k in range(3))]
        b = inside[tuple(slice(1, None) if k == axis else slice(1, -1) for k in range(3))]
        at = np.argwhere(a != b)
        outward = a[tuple(at.T)]
        base = at + step[u] + step[v]
        quad = np.stack(
            [
                index[tuple((base - d).T)]
                for d in (step[u] + step[v], step[v], 0 * step[u], step[u])
            ],
            axis=1,
        )
        quad[~outward] = quad[~outward, ::-1]
        faces += [quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]]
    return vertices, np.concatenate(faces)


def chair(cell=0.004, noise=0.0005, seed=0):
    """Vertices (V, 3) [m] and triangles (F, 3); 4 mm cells give about 100,000 triangles."""
    low, high = np.array([-0.26, -0.31, -0.04]), np.array([0.26, 0.26, 0.99])
    vertices, faces = surface(distance, low, high, cell)
    return vertices + noise * np.random.default_rng(seed).normal(size=vertices.shape), faces
