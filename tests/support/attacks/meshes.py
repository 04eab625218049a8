"""Meshes of the attacks, all of plain triangles: vertices (n, 3) [m], faces (k, 3)."""

from __future__ import annotations

import numpy as np
import trimesh


def mesh(vertices, faces):
    """A `trimesh.Trimesh`, as given."""
    return trimesh.Trimesh(np.asarray(vertices, float), np.asarray(faces), process=False)


def loose(triangles):
    """Triangles (n, 3, 3) that share no vertex."""
    triangles = np.asarray(triangles, float).reshape(-1, 3, 3)
    return mesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))


def joined(parts):
    """One mesh of several."""
    first, vertices, faces = 0, [], []
    for part in parts:
        vertices.append(part.vertices)
        faces.append(np.asarray(part.faces) + first)
        first += len(part.vertices)
    return mesh(np.concatenate(vertices), np.concatenate(faces))


def grid(height, across, up, corner, u, v):
    """A sheet of `across` x `up` cells from `corner` along u and v, moved by `height(a, b)`."""
    a, b = np.meshgrid(np.linspace(0, 1, across + 1), np.linspace(0, 1, up + 1), indexing="ij")
    a, b = a.ravel(), b.ravel()
    vertices = np.asarray(corner) + np.outer(a, u) + np.outer(b, v) + height(a, b)
    i, j = np.meshgrid(np.arange(across), np.arange(up), indexing="ij")
    first = (i * (up + 1) + j).ravel()
    faces = np.concatenate(
        [
            np.stack([first, first + up + 1, first + up + 2], axis=1),
            np.stack([first, first + up + 2, first + 1], axis=1),
        ]
    )
    return mesh(vertices, faces)


def wall(across, corner=(0.0, -1.0, 0.0), size=(2.0, 2.0), bump=None):
    """A sheet in the y-z plane of cells `across` x `across`; bump: (a, b) -> x."""
    flat = np.zeros(3)

    def height(a, b):
        x = np.zeros_like(a) if bump is None else bump(a, b)
        return x[:, None] * np.array([1.0, 0.0, 0.0])

    return grid(height, across, across, np.add(corner, flat), (0, size[0], 0), (0, 0, size[1]))


def floor(across, corner, size, bump=None):
    """A sheet of cells `across` x `across` in the x-y plane; bump: (a, b) -> z."""

    def height(a, b):
        z = np.zeros_like(a) if bump is None else bump(a, b)
        return z[:, None] * np.array([0.0, 0.0, 1.0])

    return grid(height, across, across, corner, (size[0], 0, 0), (0, size[1], 0))


def spikes(tips, bases, width, sides=3):
    """Thin pyramids without bottoms from around `bases` (n, 3) to `tips` (n, 3)."""
    tips, bases = np.asarray(tips, float), np.asarray(bases, float)
    along = _unit(tips - bases)
    one = _unit(np.cross(along, [0.31, 0.52, 0.79]))[:, None]
    two = np.cross(along[:, None], one)
    angle = (np.arange(sides) * 2 * np.pi / sides)[:, None]
    ring = bases[:, None] + width * (np.cos(angle) * one + np.sin(angle) * two)
    faces = np.array([[k, (k + 1) % sides, sides] for k in range(sides)])
    first = (sides + 1) * np.arange(len(tips))[:, None, None]
    vertices = np.concatenate([ring, tips[:, None]], axis=1)
    return mesh(vertices.reshape(-1, 3), (faces + first).reshape(-1, 3))


def _unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def scattered(rng, count, low, high, size):
    """Loose triangles with corners about `size` [m] around random middles in a box."""
    middle = rng.uniform(low, high, (count, 1, 3))
    return middle + size * rng.normal(size=(count, 3, 3))


def tube(radius, length, around, along, axis=1):
    """An open cylinder about the origin, finely cut."""
    angle = np.arange(around) * 2 * np.pi / around
    ends = np.linspace(-0.5 * length, 0.5 * length, along + 1)
    ring = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    vertices = np.zeros((along + 1, around, 3))
    others = [k for k in range(3) if k != axis]
    vertices[:, :, others] = ring[None]
    vertices[:, :, axis] = ends[:, None]
    k = np.arange(around)
    n = (k + 1) % around
    faces = []
    for r in range(along):
        a, b = r * around, (r + 1) * around
        faces += [np.stack([a + k, a + n, b + n], 1), np.stack([a + k, b + n, b + k], 1)]
    return mesh(vertices.reshape(-1, 3), np.concatenate(faces))


def behind(rng, count, at, radius, gap=0.003, size=0.0008):
    """Tiny triangles around the rear half (x > 0 is ahead) of a ball, facing it."""
    out = []
    while len(out) < count:
        d = rng.normal(size=3)
        d /= np.linalg.norm(d)
        if d[0] > -0.05:
            continue
        t = np.cross(d, [0.3, 0.5, 0.8])
        t /= np.linalg.norm(t)
        s = np.cross(d, t)
        c = np.asarray(at) + d * (radius + gap)
        out.append([c + size * t, c - size * (0.5 * t - 0.8 * s), c - size * (0.5 * t + 0.8 * s)])
    return np.array(out)
